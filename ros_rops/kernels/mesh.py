# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the mesh kernels (METHOD 1; Guo et al. 2014, III-A)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from ros_rops.kernels import _kernels


class Surface(NamedTuple):
    """What `mesh_from_triangles` returns; see there."""

    faces: NDArray[np.int32]
    normals: NDArray[np.float64]
    boundary: NDArray[np.bool_]
    resolution: float


def _check_points(name: str, points: NDArray[np.float64]) -> None:
    if points.ndim != 2 or points.shape[1] != 3:
        raise ShapeError(f'{name}: expected (N, 3), got {points.shape}')


def _check_faces(faces: NDArray[np.int32], vertices: int) -> None:
    if faces.ndim != 2 or faces.shape[1] != 3:
        raise ShapeError(f'faces: expected (F, 3), got {faces.shape}')
    if faces.size and (faces.min() < 0 or faces.max() >= vertices):
        raise ShapeError(f'faces: indices must lie in 0..{vertices - 1}')


def grid_triangles(points: NDArray[np.float64], grid: NDArray[np.int32]) -> NDArray[np.int32]:
    """
    Connect neighbouring pixels, across the shorter diagonal.

    Parameters
    ----------
    points : (N, 3) float64
    grid : (H, W) int32
        Point behind each pixel, -1 where none.

    Returns
    -------
    (F, 3) int32
        Candidate triangles, turned the same way on the grid.

    Raises
    ------
    ShapeError
        If an array has the wrong shape or the grid points outside `points`.
    """
    _check_points('points', points)
    if grid.ndim != 2:
        raise ShapeError(f'grid: expected (H, W), got {grid.shape}')
    if grid.size and grid.max() >= len(points):
        raise ShapeError(f'grid: indices must be below {len(points)}, got {grid.max()}')
    faces: NDArray[np.int32] = _kernels.grid_triangles(points, grid)
    return faces


def delaunay_triangles(uv: NDArray[np.float64]) -> NDArray[np.int32]:
    """
    Delaunay triangulation of points in the plane, in exact arithmetic.

    Parameters
    ----------
    uv : (N, 2) float64
        Finite; seen on a raster of 2^-30 of their extent.

    Returns
    -------
    (F, 3) int32
        Counter-clockwise triangles; none if the points lie on a line of the raster. Of points
        that coincide only the first has any.

    Raises
    ------
    ShapeError
        If `uv` has the wrong shape or is not finite.
    """
    if uv.ndim != 2 or uv.shape[1] != 2 or not np.isfinite(uv).all():
        raise ShapeError(f'uv: expected finite (N, 2), got {uv.shape}')
    faces: NDArray[np.int32] = _kernels.delaunay_triangles(uv)
    return faces


def mesh_from_triangles(
    points: NDArray[np.float64],
    rays: NDArray[np.float64],
    candidates: NDArray[np.int32],
    edge_factor: float,
    least_cosine: float,
) -> Surface:
    """
    Keep the triangles that lie on one surface; give normals, boundary and resolution.

    The length expected at a vertex is the lower median of the lateral lengths (across the ray)
    of its candidate edges; a triangle goes when its longest edge exceeds `edge_factor` times the
    mean of its vertices, or when it is seen too flat.

    Parameters
    ----------
    points : (N, 3) float64
    rays : (N, 3) float64
        Unit vectors from the points towards the sensor.
    candidates : (F, 3) int32
    edge_factor : float
    least_cosine : float
        Least cosine between a triangle's normal and the ray.

    Returns
    -------
    Surface
        `faces` (F', 3), counter-clockwise seen from the sensor; `normals` (N, 3), area-weighted,
        zero without a face; `boundary` (N,); `resolution`, the mean length of the edges, each
        once, 0 without any.

    Raises
    ------
    ShapeError
        If an array has the wrong shape or an index lies outside `points`.
    """
    _check_points('points', points)
    _check_points('rays', rays)
    if len(rays) != len(points):
        raise ShapeError(f'rays: expected {len(points)} rows, got {len(rays)}')
    _check_faces(candidates, len(points))
    return Surface(
        *_kernels.mesh_from_triangles(points, rays, candidates, edge_factor, least_cosine)
    )
