# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What registration works on: a view's or a grown shape's features and evidence."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.config import Config
from ros_rops.core.errors import ViewError
from ros_rops.core.rops import compute_features
from ros_rops.core.se3 import move
from ros_rops.core.types import Features, Floats, RangeMesh, SensorModel, SupportPlane
from ros_rops.kernels.evidence import Evidence
from scipy.spatial import cKDTree

# Fewer vertices than one keypoint's support tell nothing of a pose.
FEWEST_VERTICES = 50


@dataclass(frozen=True, slots=True)
class Surface:
    """
    One side of a registration.

    Parameters
    ----------
    name : str
        Of the view, or `object_<k>`.
    features : Features
    evidence : Evidence
    resolution : float
        Mesh resolution (mr), in the units of the points.
    support : SupportPlane or None
        What the object stands on, in the frame of the points, where that was seen.
    T_fixed_surface : (4, 4) float64 or None
        Where the frame of the points stands in one in which the object stands still, where
        something else than the points tells it.
    """

    name: str
    features: Features
    evidence: Evidence
    resolution: float
    support: SupportPlane | None = None
    T_fixed_surface: Floats | None = None


def make_surface(
    name: str,
    mesh: RangeMesh,
    sensor: SensorModel,
    config: Config,
    *,
    resolution: float | None = None,
    beyond: NDArray[np.float32] | None = None,
    threads: int = 0,
) -> Surface:
    """
    Describe a view's mesh for registration (III-A).

    Parameters
    ----------
    name : str
    mesh : RangeMesh
    sensor : SensorModel
    config : Config
        Groups `keypoints`, `lrf`, `rops`, `evidence`.
    resolution : float, optional
        What `mr` means; the mesh's own by default.
    beyond : (M, 3) float32, optional
        Where rays ended that pass by the object.
    threads : int
        0 takes all cores; no influence on the result.

    Raises
    ------
    ViewError
        If too few vertices have a face, or the extent is out of proportion (stray points).
    """
    unit = resolution or mesh.resolution
    used = mesh.normals.any(axis=1)
    if np.count_nonzero(used) < FEWEST_VERTICES:
        raise ViewError(
            f'view {name!r}: {np.count_nonzero(used)} points form a surface, registration '
            f'needs {FEWEST_VERTICES}')

    def evidence() -> Evidence:
        return Evidence.of(
            mesh.vertices[used], mesh.normals[used], mesh.boundary[used], sensor,
            cell=config.evidence.cell_mr * unit, reach=config.evidence.reach_cells,
            beyond=beyond)

    if threads == 1:
        return Surface(
            name, compute_features(mesh, config, resolution=unit, threads=1), evidence(), unit)
    # One thread builds the evidence while the others describe the features.
    with ThreadPoolExecutor(1) as other:
        building = other.submit(evidence)
        features = compute_features(mesh, config, resolution=unit, threads=threads)
        return Surface(name, features, building.result(), unit)


def grow_surface(
    shape: Surface, view: Surface, T_shape_view: Floats, config: Config, *, threads: int = 0
) -> Surface:
    """
    Add a registered view, or another shape, to a shape (IV-A).

    No descriptor is computed anew; the features of both are kept, but for those of the view
    that lie within the spacing of keypoints of one of the shape's (resolution control).

    Parameters
    ----------
    shape, view : Surface
    T_shape_view : (4, 4) float64
    config : Config

    Returns
    -------
    Surface
        In the frame of `shape`.
    """
    near = config.evidence.grow_mr * shape.resolution
    evidence = shape.evidence.grown(view.evidence, T_shape_view, near, threads=threads)
    spacing = config.keypoints.spacing_mr * shape.resolution
    features = _joined(shape.features, view.features, T_shape_view, spacing)
    support = shape.support
    if support is None and view.support is not None:
        support = _moved_plane(T_shape_view, view.support)
    T_fixed_surface = shape.T_fixed_surface
    if T_fixed_surface is None and view.T_fixed_surface is not None:
        T_fixed_surface = view.T_fixed_surface @ np.linalg.inv(T_shape_view)
    return Surface(
        shape.name, features, evidence, shape.resolution, support, T_fixed_surface)


def _moved_plane(transform: Floats, plane: SupportPlane) -> SupportPlane:
    x, y, z = transform[:3, :3] @ np.asarray(plane.normal)
    shift = float(transform[:3, 3] @ (x, y, z))
    return SupportPlane((float(x), float(y), float(z)), plane.offset + shift)


def _joined(
    shape: Features, view: Features, T_shape_view: Floats, spacing: float
) -> Features:
    positions = move(T_shape_view, view.positions)
    fresh = np.ones(len(positions), dtype=bool)
    if len(shape.positions) and len(positions):
        distance, _ = cKDTree(shape.positions).query(positions, distance_upper_bound=spacing)
        fresh = ~np.isfinite(distance)
    return Features(
        indices=np.concatenate([shape.indices, view.indices[fresh]]),
        positions=np.concatenate([shape.positions, positions[fresh]]),
        lrfs=np.concatenate([shape.lrfs, view.lrfs[fresh] @ T_shape_view[:3, :3].T]),
        descriptors=np.concatenate([shape.descriptors, view.descriptors[fresh]]),
    )
