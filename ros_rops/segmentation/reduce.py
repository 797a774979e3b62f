# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fewer points for huge clouds: neighbours averaged, on the pixel grid or in cubic cells."""

from dataclasses import replace

import numpy as np
from ros_rops.core.types import Floats, Ints, RangeView
from ros_rops.kernels.points import block_means, cell_means, count_cells, some_groups

DEEP = 4.0
"""Pixels of a block are averaged with the nearest one within so many block widths of depth."""
SAMPLE = 40_000
"""Points on which the size of cells is guessed, at most."""
OFF = 1.1
"""Cells are of the right size when they hold the points wanted within this factor."""
ROUNDS = 5
"""Their size is corrected at most so often."""
GROUPS = 500
"""Groups of 64 cells from which their number is told, about."""


def reduce_view(view: RangeView, most_points: int, threads: int = 0) -> RangeView:
    """
    Return the view with about `most_points` points or fewer.

    An organized view stays organized: blocks of pixels become pixels, each the mean of the points
    on the block's nearest surface. Of others, the points of each cubic cell become their mean.

    Parameters
    ----------
    view : RangeView
    most_points : int
        At least 1.
    threads : int
        0 takes all cores; no influence on the result.
    """
    if len(view.points) <= most_points:
        return view
    if view.grid is not None:
        side = int(np.ceil(np.sqrt(len(view.points) / most_points)))
        slack = DEEP * side * _pixel(view.points, view.grid)
        means, grid = block_means(
            view.points, view.grid, view.colors, view.sensor.direction, side, slack, threads)
        return replace(view, points=means.points, grid=grid, colors=means.colors)
    means = cell_means(view.points, view.colors, _cell_side(view.points, most_points))
    return replace(view, points=means.points, colors=means.colors)


def _cell_side(points: Floats, wanted: int) -> float:
    """Return the side of cubic cells of which about `wanted` hold a point."""
    side = _guessed_side(points, wanted)
    # A surface passes through 16 of a group's 64 cells.
    some = some_groups(points, side, max(1, wanted // (16 * GROUPS)))
    expected = wanted * len(some) / len(points)
    for _ in range(ROUNDS if len(some) else 0):
        ratio = count_cells(some, side) / expected
        if 1 / OFF <= ratio <= OFF:
            break
        side *= float(np.sqrt(ratio))
    return side


def _guessed_side(points: Floats, wanted: int) -> float:
    """
    Guess the side of cells on a sample that fills few of them well.

    A surface fills cells by the square of their side; noise, by less.
    """
    thin = np.ascontiguousarray(points[::max(1, len(points) // SAMPLE)])
    extent = float(np.ptp(thin, axis=0).max())
    if extent <= 0:
        return 1.0
    few = max(1, min(wanted, len(thin) // 20))
    low, high = extent / 4096, extent * 1.001
    for _ in range(10):
        side = float(np.sqrt(low * high))
        if count_cells(thin, side) > few:
            low = side
        else:
            high = side
    return float(np.sqrt(low * high * few / wanted))


def _pixel(points: Floats, grid: Ints) -> float:
    """Return the median distance of neighbouring pixels; 0 without neighbours."""
    step = max(1, min(grid.shape) // 200)
    first, second = grid[::step, :-1], grid[::step, 1:]
    both = (first >= 0) & (second >= 0)
    if not both.any():
        return 0.0
    off = points[second[both]] - points[first[both]]
    return float(np.median(np.linalg.norm(off, axis=1)))
