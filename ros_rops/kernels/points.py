# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the kernels on clouds as sensors deliver them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Bytes, Floats, Floats32or64, Ints
from ros_rops.kernels import _kernels


class Measured(NamedTuple):
    """What `measured` returns; see there."""

    points: Floats
    numbers: Ints


class Means(NamedTuple):
    """
    Points averaged together.

    Parameters
    ----------
    points : (M, 3) float64
    colors : (M, 3) uint8 or None
    """

    points: Floats
    colors: Bytes | None


class Blocks(NamedTuple):
    """Means, and the grid (H, W) int32 of the blocks that they are of, -1 for those of none."""

    means: Means
    grid: Ints


def measured(points: Floats32or64, limit: float) -> Measured:
    """
    Drop points of which a coordinate is NaN or beyond a limit.

    Parameters
    ----------
    points : (N, 3) float32 or float64
    limit : float
        Most that the size of a coordinate may be; compared in the points' own precision.

    Returns
    -------
    Measured
        `points` (M, 3) float64; `numbers` (N,) int32, where each stands among these, or -1.

    Raises
    ------
    ShapeError
        If `points` has another shape or type.
    """
    _check(points)
    take = _kernels.measured_single if points.dtype == np.float32 else _kernels.measured_double
    return Measured(*take(np.ascontiguousarray(points), limit))


def count_holes(points: Floats32or64) -> tuple[int, int]:
    """
    Count the points (N, 3) not finite in x or y yet no NaN in z, and those at the origin.

    Raises
    ------
    ShapeError
        As `measured`.
    """
    _check(points)
    single = points.dtype == np.float32
    count = _kernels.count_holes_single if single else _kernels.count_holes_double
    halves, zeros = count(np.ascontiguousarray(points))
    return halves, zeros


def block_means(
    points: Floats, grid: Ints, colors: Bytes | None, axis: tuple[float, float, float],
    side: int, slack: float, threads: int = 0,
) -> Blocks:
    """
    Average the points of each block of pixels that lie on its nearest surface.

    Parameters
    ----------
    points : (N, 3) float64
    grid : (H, W) int32
        Point behind each pixel, -1 where none.
    colors : (N, 3) uint8 or None
    axis : (3,) tuple of float
        Depth grows along it.
    side : int
        Pixels along a block's side.
    slack : float
        Points deeper than the nearest of their block by more than this are left out.
    threads : int
        0 takes all cores; no influence on the result.

    Raises
    ------
    ShapeError
        If an array has the wrong shape, the grid points outside `points`, or `side` is below 1.
    """
    _check(points)
    if grid.ndim != 2 or (grid.size and grid.max() >= len(points)):
        raise ShapeError(f'grid: expected (H, W) indices below {len(points)}, got {grid.shape}')
    if side < 1:
        raise ShapeError(f'side: must be at least 1, got {side}')
    means, tints, numbers = _kernels.block_means(
        np.ascontiguousarray(points, np.float64), np.ascontiguousarray(grid, np.int32),
        _colors(colors, points), axis, side, slack, threads)
    rows, columns = (-(-length // side) for length in grid.shape)
    return Blocks(
        Means(means, None if colors is None else tints), numbers.reshape(rows, columns))


def cell_means(points: Floats, colors: Bytes | None, side: float) -> Means:
    """
    Average the points of each cubic cell; cells stand in the order of their first points.

    Parameters
    ----------
    points : (N, 3) float64
        Finite.
    colors : (N, 3) uint8 or None
    side : float
        Of a cell; made longer where the extent is more than two million of it.

    Raises
    ------
    ShapeError
        If an array has the wrong shape, or points are not finite.
    """
    _check_finite(points)
    means, tints = _kernels.cell_means(
        np.ascontiguousarray(points, np.float64), _colors(colors, points), side)
    return Means(means, None if colors is None else tints)


def count_cells(points: Floats, side: float) -> int:
    """Count the cells that `cell_means` would make of points (N, 3); errors as there."""
    _check_finite(points)
    count: int = _kernels.count_cells(np.ascontiguousarray(points, np.float64), side)
    return count


def some_groups(points: Floats, side: float, share: int) -> Floats:
    """
    Return the points of some places, as dense there as they are: one place in `share`.

    Parameters
    ----------
    points : (N, 3) float64
        Finite.
    side : float
        A place is a group of 4 x 4 x 4 cubic cells of this side.
    share : int
        Places are taken at random, always the same ones.

    Raises
    ------
    ShapeError
        As `cell_means`, or if `share` is below 1.
    """
    _check_finite(points)
    if share < 1:
        raise ShapeError(f'share: must be at least 1, got {share}')
    some: Floats = _kernels.some_groups(np.ascontiguousarray(points, np.float64), side, share)
    return some


def _check(points: NDArray[np.floating]) -> None:
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype not in (np.float32, np.float64):
        raise ShapeError(
            f'points: expected (N, 3) float32 or float64, got {points.shape} {points.dtype}')


def _check_finite(points: Floats) -> None:
    _check(points)
    with np.errstate(all='ignore'):
        finite = np.isfinite(points.sum()) or np.isfinite(points).all()
    if not finite:
        raise ShapeError('points: not finite')


def _colors(colors: Bytes | None, points: Floats) -> Bytes:
    if colors is None:
        return np.zeros((0, 3), np.uint8)
    if colors.shape != points.shape or colors.dtype != np.uint8:
        raise ShapeError(
            f'colors: expected {points.shape} uint8, got {colors.shape} {colors.dtype}')
    return np.ascontiguousarray(colors)
