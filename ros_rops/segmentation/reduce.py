# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fewer points for huge clouds: neighbours averaged, on the pixel grid or in cubic cells."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats, Ints, RangeView
from ros_rops.segmentation.patches import cell_side, number_cells, renumber

DEEP = 4.0
"""Pixels of a block are averaged with the nearest one within so many block widths of depth."""


def reduce_view(view: RangeView, most_points: int) -> RangeView:
    """
    Return the view with about `most_points` points or fewer.

    An organized view stays organized: blocks of pixels become pixels, each the mean of the points
    on the block's nearest surface. Of others, the points of each cubic cell become their mean.

    Parameters
    ----------
    view : RangeView
    most_points : int
        At least 1.
    """
    if len(view.points) <= most_points:
        return view
    if view.grid is not None:
        side = int(np.ceil(np.sqrt(len(view.points) / most_points)))
        return _in_blocks(view, view.grid, side)
    side_length = cell_side(view.points, most_points)
    cell, count = number_cells(view.points, side_length)
    return replace(
        view, points=_means(view.points, cell, len(count)),
        colors=_colors(view.colors, cell, len(count)))


def _means(values: NDArray, cell: NDArray, count: int) -> Floats:
    total = np.bincount(cell, minlength=count)
    sums = [np.bincount(cell, values[:, k], count) for k in range(values.shape[1])]
    means: Floats = np.stack(sums, axis=1) / total[:, None]
    return means


def _colors(colors: Bytes | None, cell: NDArray, count: int) -> Bytes | None:
    return None if colors is None else np.rint(_means(colors, cell, count)).astype(np.uint8)


def _in_blocks(view: RangeView, grid: Ints, side: int) -> RangeView:
    height, width = (-(-length // side) for length in grid.shape)
    rows, columns = np.nonzero(grid >= 0)
    index = grid[rows, columns]
    block = (rows // side) * width + columns // side
    x, y, z = view.sensor.direction
    depth = (view.points[:, 0] * x + view.points[:, 1] * y + view.points[:, 2] * z)[index]
    nearest = np.full(height * width, np.inf)
    np.minimum.at(nearest, block, depth)
    # On one surface: not deeper than the block is wide, several times.
    near = depth - nearest[block] <= DEEP * side * _pixel(view.points, grid)
    block, index = block[near], index[near]
    number, count = renumber(block, height * width)
    small = np.full(height * width, -1, np.int32)
    small[block] = number
    colors = None if view.colors is None else view.colors[index]
    return replace(
        view, points=_means(view.points[index], number, len(count)),
        grid=small.reshape(height, width), colors=_colors(colors, number, len(count)))


def _pixel(points: Floats, grid: Ints) -> float:
    """Return the median distance of neighbouring pixels; 0 without neighbours."""
    step = max(1, min(grid.shape) // 200)
    first, second = grid[::step, :-1], grid[::step, 1:]
    both = (first >= 0) & (second >= 0)
    if not both.any():
        return 0.0
    off = points[second[both]] - points[first[both]]
    return float(np.median(np.linalg.norm(off, axis=1)))
