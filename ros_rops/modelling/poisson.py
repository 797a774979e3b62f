# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Watertight surface of an assembled cloud: screened Poisson (Kazhdan and Hoppe 2013)."""

import math
from typing import Any

import numpy as np
from ros_rops.core.config import ModelConfig
from ros_rops.core.errors import ModelError
from ros_rops.core.types import Bools, Bytes, Floats, frozen, Ints
from ros_rops.modelling.cleaning import cleaned
from ros_rops.modelling.products import Fact, ModelCloud, SurfaceMesh
from ros_rops.modelling.topology import (
    face_components, grouped_sides, linked, Longs, simple_mates, vertex_normals)
from scipy.spatial import cKDTree

FILLED_MR = 2.0
"""Faces farther from every point of the cloud are filled: no view saw a surface there."""
LEAST_SCALE = 1.1
"""Side of the cube that the octree divides, over that of the cloud."""
BYTES_A_CELL = 2000
"""Memory of the solver by cell of the finest level in which points lie, measured."""
_FEWEST_POINTS = 10
_BLENDED = 4


def poisson_surface(
    cloud: ModelCloud, config: ModelConfig, *, resolution: float
) -> SurfaceMesh:
    """
    Make the surface whose indicator function fits the cloud's normals and points best.

    It closes what no view saw, smoothly and without regard to the lines of sight. Where nothing
    lies behind a border (one view) it has no end: such parts are cut off, and the surface stays
    open, which its facts say.

    Parameters
    ----------
    cloud : ModelCloud
    config : ModelConfig
        `voxel_mr`, `memory_mb`.
    resolution : float
        What mr means.

    Returns
    -------
    SurfaceMesh
        `cleaned`; `filled` where no point is within `FILLED_MR`. The same for the same cloud,
        byte by byte: the solver runs in one thread.

    Raises
    ------
    ModelError
        If Open3D is missing, or nothing comes of the cloud.
    """
    used = cloud.normals.any(axis=1)
    points, normals = cloud.points[used], cloud.normals[used].astype(np.float64)
    if len(points) < _FEWEST_POINTS:
        raise ModelError(f'{len(points)} points with a normal are too few for a Poisson surface')
    extent = float(np.ptp(points, axis=0).max())
    if not extent > 0:
        raise ModelError(f'the {len(points)} points of the cloud coincide')
    voxel = _affordable(points, config.voxel_mr * resolution, config.memory_mb)
    depth = max(math.ceil(math.log2(max(LEAST_SCALE * extent / voxel, 2.0))), 2)
    vertices, faces = _solved(points, normals, depth, 2 ** depth * voxel / extent)
    tree = cKDTree(points)
    filled = _far(tree, vertices[faces].mean(axis=1), FILLED_MR * max(resolution, voxel))
    kept = _founded(faces, filled)
    if not kept.any():
        raise ModelError('the Poisson surface comes near no point of the cloud')
    colors = None if cloud.colors is None else _blended(tree, cloud.colors[used], vertices)
    facts: dict[str, Fact] = {'method': 'poisson', 'voxel': voxel, 'depth': depth}
    surface = SurfaceMesh(
        vertices, frozen(faces[kept], np.int32),
        frozen(vertex_normals(vertices, faces), np.float32), colors,
        frozen(filled[kept], np.bool_), facts)
    return cleaned(surface, resolution=resolution)


def _affordable(points: Floats, voxel: float, memory_mb: int) -> float:
    """Return the voxel, or the least coarser one with which the solver fits the memory."""
    low = points.min(axis=0)
    while True:
        cells = len(np.unique(np.floor((points - low) / voxel).astype(np.int32), axis=0))
        needed = cells * BYTES_A_CELL / 1e6
        if needed <= memory_mb:
            return voxel
        # The cells on a surface are as many as the square of the resolution.
        voxel *= max(math.sqrt(needed / memory_mb), 1.05)


def _solved(
    points: Floats, normals: Floats, depth: int, scale: float
) -> tuple[Floats, Ints]:
    open3d = _open3d()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.normals = open3d.utility.Vector3dVector(normals)
    level = open3d.utility.VerbosityLevel.Error
    with open3d.utility.VerbosityContextManager(level):
        mesh, _ = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(
            # More threads add up in another order every time.
            cloud, depth=depth, scale=scale, n_threads=1)
    faces = np.asarray(mesh.triangles, dtype=np.int32)
    if not len(faces):
        raise ModelError('the Poisson solver found no surface in the cloud')
    return np.array(mesh.vertices, dtype=np.float64), faces


def _open3d() -> Any:
    try:
        import open3d
    except ImportError as error:
        raise ModelError(
            'model.surface poisson needs Open3D, which does not load here '
            f"({error}): pip install 'ros_rops[poisson]', or take model.surface volume"
        ) from error
    return open3d


def _far(tree: cKDTree, places: Floats, reach: float) -> Bools:
    distance, _ = tree.query(places, distance_upper_bound=reach)
    far: Bools = ~np.isfinite(distance)
    return far


def _founded(faces: Ints, filled: Bools) -> Bools:
    """
    Tell which faces to keep (F,).

    Not those of pieces without any data, nor filled ones that run to the border of the solver's
    cube: what they close is nowhere.
    """
    mates = simple_mates(faces, *grouped_sides(faces))
    count, piece = face_components(mates)
    founded: Bools = (np.bincount(piece[~filled], minlength=count) > 0)[piece]
    patch = _patches(mates, filled)
    endless = np.zeros(int(patch.max(initial=0)) + 1, dtype=bool)
    rim = np.flatnonzero(mates < 0) // 3
    endless[patch[rim[filled[rim]]]] = True
    return founded & ~(filled & endless[patch])


def _patches(mates: Longs, filled: Bools) -> Ints:
    """Give each patch of filled faces a number, (F,)."""
    sides = np.flatnonzero(mates > np.arange(len(mates)))
    one, other = sides // 3, mates[sides] // 3
    both = filled[one] & filled[other]
    return linked(len(filled), one[both], other[both])[1]


def _blended(tree: cKDTree, colors: Bytes, vertices: Floats) -> Bytes:
    """Return the colours at vertices: of the nearest points, by inverse distance."""
    distance, index = tree.query(vertices, k=_BLENDED)
    weight = 1.0 / np.maximum(distance, 1e-6 * np.maximum(distance[:, -1:], 1e-300))
    weight /= weight.sum(axis=1, keepdims=True)
    mixed = np.einsum('nk,nkc->nc', weight, colors[index].astype(np.float64))
    blended: Bytes = np.rint(mixed).astype(np.uint8)
    return blended
