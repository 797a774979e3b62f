# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Range view to triangle mesh (Guo et al. 2014, III-A)."""

import math

import numpy as np
from ros_rops.core.config import MeshConfig
from ros_rops.core.errors import ViewError
from ros_rops.core.types import Floats, frozen, Ints, RangeMesh, RangeView, SensorModel
from ros_rops.kernels.mesh import delaunay_triangles, grid_triangles, mesh_from_triangles

_FEWEST_POINTS = 3


def build_mesh(view: RangeView, config: MeshConfig) -> RangeMesh:
    """
    Mesh a range view (Guo et al. 2014, III-A).

    Organized views connect neighbouring pixels; others get the 2D Delaunay triangulation of the
    sensor's image plane. Triangles go that span a depth step (edges longer than the spacing
    expected at their place) or that the sensor sees too flat to be trusted.

    Parameters
    ----------
    view : RangeView
    config : MeshConfig

    Returns
    -------
    RangeMesh
        Its vertices are the view's points, all of them and in their order.

    Raises
    ------
    ViewError
        If the view has fewer than three points or no triangle comes of it.
    """
    if len(view.points) < _FEWEST_POINTS:
        raise ViewError(
            f'view {view.name!r}: {len(view.points)} points, a mesh needs {_FEWEST_POINTS}'
        )
    candidates = _candidates(view)
    rays = np.ascontiguousarray(view.sensor.to_sensor(view.points))
    surface = mesh_from_triangles(
        view.points, rays, candidates, config.edge_factor, _least_cosine(view, config)
    )
    if not len(surface.faces):
        raise ViewError(
            f'view {view.name!r}: no triangle comes of its {len(view.points)} points '
            f'(they coincide, lie on a line or are scattered in depth)'
        )
    return RangeMesh(
        vertices=view.points,
        faces=frozen(surface.faces, np.int32),
        normals=frozen(surface.normals, np.float64),
        boundary=frozen(surface.boundary, np.bool_),
        resolution=surface.resolution,
    )


def image_plane(sensor: SensorModel, points: Floats) -> tuple[Floats, Ints]:
    """
    Project `points` (N, 3) on the sensor's image plane.

    Parameters
    ----------
    sensor : SensorModel
        Pinhole: central projection through its origin on the plane at distance 1; otherwise
        parallel projection along its direction.
    points : (N, 3) float64

    Returns
    -------
    uv : (M, 2) float64
        Pinhole: tangents of the angles; otherwise lengths about the points' mean.
    indices : (M,) int32
        The points projected: for a pinhole those in front of it, else all.
    """
    axis = np.asarray(sensor.direction, dtype=np.float64)
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    right = np.cross(helper, axis)
    right /= np.linalg.norm(right)
    basis = np.stack([right, np.cross(axis, right)], axis=1)
    if sensor.kind != 'pinhole':
        return (points - points.mean(axis=0)) @ basis, np.arange(len(points), dtype=np.int32)
    offsets = points - np.asarray(sensor.origin)
    depth = offsets @ axis
    front = np.flatnonzero(depth > 0)
    return (offsets[front] @ basis) / depth[front, None], front.astype(np.int32)


def _candidates(view: RangeView) -> Ints:
    if view.grid is not None:
        return grid_triangles(view.points, view.grid)
    uv, indices = image_plane(view.sensor, view.points)
    if len(uv) < _FEWEST_POINTS:
        raise ViewError(f'view {view.name!r}: {len(uv)} points lie in front of the sensor')
    triangles: Ints = indices[delaunay_triangles(uv)]
    return triangles


def _least_cosine(view: RangeView, config: MeshConfig) -> float:
    # A grid tells its neighbours without rays; unknown rays must not cost it triangles.
    if view.sensor.kind == 'unknown' and view.grid is not None:
        return 0.0
    return math.cos(math.radians(config.grazing_deg))
