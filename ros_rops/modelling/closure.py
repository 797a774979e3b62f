# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
A coarse closed surface of an object, and which of its faces no view saw: to tell what is missing.

The indicator function of a body is the inverse Laplacian of the divergence of its boundary's
normals (Kazhdan 2005, Reconstruction of solid models from oriented point sets, 3; solved by FFT).
Where points are missing it closes smoothly. This surface is an estimate made for coverage only:
it does not depend on how the model's own surface is made, and is there without one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.residuals import thinned
from scipy import fft
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

CELLS = 64
"""Cells along the longest side of the object."""
POINTS = 8000
"""Points taken of each view."""
_MARGIN = 0.25
# Nearer than this to a point seen, in cells, a face of the estimate counts as seen.
_NEAR = 1.5
# Standard deviation of the smoothing of normals, in cells.
_SMOOTH = 1.0
# Holes of fewer cells are noise of the estimate.
_LEAST_CELLS = 4.0


@dataclass(frozen=True, slots=True)
class Closure:
    """
    A closed surface in triangles.

    Parameters
    ----------
    centres, normals : (F, 3) float64
        Of the faces; unit, outwards.
    areas : (F,) float64
    unseen : (F,) bool
    holes : int
        Connected groups of unseen faces.
    cell : float
        Length that it resolves.
    """

    centres: Floats
    normals: Floats
    areas: Floats
    unseen: Bools
    holes: int
    cell: float


def close_views(
    views: Sequence[PosedView], resolution: float, *, threads: int = 0
) -> Closure | None:
    """Estimate the closed surface from the views alone; None if it comes to nothing."""
    chosen = [thinned(one, POINTS) for one in views]
    points = np.concatenate([one.points[kept] for one, kept in zip(views, chosen, strict=True)])
    normals = np.concatenate(
        [one.normals[kept] for one, kept in zip(views, chosen, strict=True)])
    if not len(points):
        return None
    cell = max(float(np.ptp(points, axis=0).max()) / CELLS, 2.0 * resolution)
    mesh = closed_surface(points, normals, cell, threads=threads)
    if mesh is None:
        return None
    vertices, faces = mesh
    centres, normals, areas = _measured(vertices, faces)
    distance, _ = cKDTree(points).query(centres, distance_upper_bound=_NEAR * cell)
    unseen = _without_specks(faces, np.isinf(distance), areas, cell)
    return Closure(centres, normals, areas, unseen, count_groups(faces, unseen), cell)


def closed_surface(
    points: Floats, normals: Floats, cell: float, *, threads: int = 0
) -> tuple[Floats, Ints] | None:
    """
    Return a closed surface through oriented points.

    Parameters
    ----------
    points, normals : (N, 3) float64
        Normals outwards; several points in a cell count as one.
    cell : float
        Edge of the grid's cells.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    vertices : (V, 3) float64
    faces : (F, 3) int32
        Outwards; None instead of both where no surface comes.
    """
    from skimage.measure import marching_cubes

    low = points.min(axis=0)
    extent = np.ptp(points, axis=0) / cell
    margin = int(np.ceil(_MARGIN * extent.max())) + 3
    shape = tuple(
        fft.next_fast_len(int(np.ceil(side)) + 2 * margin, real=True) for side in extent)
    at = (points - low) / cell + margin
    field = _splat(at, normals, shape)
    inside = _integrate(field, shape, threads)
    level = float(np.mean(_sample(inside, at)))
    if not inside.min() < level < inside.max():
        return None
    vertices, faces, _, _ = marching_cubes(inside, level)  # type: ignore[no-untyped-call]
    tri = vertices[faces]
    volume = np.einsum('ij,ij->', tri[:, 0], np.cross(tri[:, 1], tri[:, 2]))
    if volume < 0:
        faces = faces[:, ::-1]
    return (vertices - margin) * cell + low, np.ascontiguousarray(faces, np.int32)


def _splat(at: Floats, normals: Floats, shape: tuple[int, ...]) -> Floats:
    """Spread normals over the eight cells around; each cell's mean direction, (3, X, Y, Z)."""
    base = np.floor(at).astype(np.int64)
    share = at - base
    size = int(np.prod(shape))
    corners = np.array(list(np.ndindex(2, 2, 2)))
    parts = np.where(corners[:, None], share, 1.0 - share).prod(axis=2)
    cells = np.ravel_multi_index(tuple(np.moveaxis(base + corners[:, None], 2, 0)), shape).ravel()
    # As much surface in a cell as it holds, however many points: full from one point on.
    full = np.maximum(np.bincount(cells, parts.ravel(), minlength=size), 1.0)
    return np.stack([
        np.bincount(cells, (parts * along).ravel(), minlength=size) / full
        for along in normals.T]).reshape(3, *shape)


def _integrate(field: Floats, shape: tuple[int, ...], threads: int) -> Floats:
    """Return the function whose gradient is nearest to the smoothed field, high inside."""
    workers = threads or -1
    waves = np.meshgrid(
        *(2.0 * np.pi * fft.fftfreq(side) for side in shape[:2]),
        2.0 * np.pi * fft.rfftfreq(shape[2]), indexing='ij', sparse=True)
    square = sum(wave * wave for wave in waves)
    total = sum(
        wave * fft.rfftn(part, workers=workers) for wave, part in zip(waves, field, strict=True))
    smooth = np.exp(-0.5 * _SMOOTH ** 2 * square)
    square[0, 0, 0] = 1.0
    solved: Floats = fft.irfftn(1j * total * smooth / square, s=shape, workers=workers)
    return solved


def _sample(values: Floats, at: Floats) -> Floats:
    nearest = np.rint(at).astype(np.int64)
    result: Floats = values[tuple(nearest.T)]
    return result


def areas_of(vertices: Floats, faces: Ints) -> Floats:
    """Return the areas (F,) of triangles."""
    return _measured(vertices, faces)[2]


def _measured(vertices: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    tri = vertices[faces].astype(np.float64)
    cross = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    double = np.linalg.norm(cross, axis=1)
    return tri.mean(axis=1), cross / np.maximum(double, 1e-300)[:, None], double / 2.0


def _without_specks(faces: Ints, unseen: Bools, areas: Floats, cell: float) -> Bools:
    """Drop groups of unseen faces that are no larger than what the cells make by chance."""
    chosen = np.flatnonzero(unseen)
    labels = _groups(faces[chosen])
    size = np.bincount(labels, areas[chosen])
    kept = np.zeros(len(faces), dtype=np.bool_)
    kept[chosen[size[labels] >= _LEAST_CELLS * cell * cell]] = True
    return kept


def count_groups(faces: Ints, chosen: Bools) -> int:
    """Count the groups of chosen (F,) faces (F, 3) that share vertices."""
    labels = _groups(faces[chosen])
    return int(labels.max()) + 1 if len(labels) else 0


def _groups(faces: Ints) -> Ints:
    """Give a number to each of the groups of faces (F, 3) that share vertices."""
    if not len(faces):
        return np.empty(0, np.int32)
    used, local = np.unique(faces, return_inverse=True)
    local = local.reshape(faces.shape)
    ends = np.concatenate([local[:, :2], local[:, 1:]])
    graph = coo_array((np.ones(len(ends)), tuple(ends.T)), shape=(len(used), len(used)))
    labels: Ints = connected_components(graph, directed=False)[1][local[:, 0]].astype(np.int32)
    return labels
