# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The kernels on clouds in NumPy."""

import numpy as np


def measured(points, limit):
    """Return (points float64, numbers) of `measured`."""
    with np.errstate(invalid='ignore'):
        good = (np.abs(points) <= limit).all(axis=1)
    numbers = np.full(len(points), -1, np.int32)
    numbers[good] = np.arange(good.sum())
    return points[good].astype(np.float64), numbers


def count_holes(points):
    """Return (halves, zeros) of `count_holes`."""
    halves = ~np.isfinite(points[:, :2]).all(axis=1) & ~np.isnan(points[:, 2])
    return int(halves.sum()), int((points == 0).all(axis=1).sum())


def block_means(points, grid, colors, axis, side, slack):
    """Return (means, colours, grid) of `block_means`."""
    height, width = (-(-length // side) for length in grid.shape)
    small = np.full((height, width), -1, np.int32)
    means, tints = [], []
    for row in range(height):
        for column in range(width):
            cut = grid[row * side:(row + 1) * side, column * side:(column + 1) * side]
            index = cut[cut >= 0]
            if not len(index):
                continue
            x, y, z = axis
            depth = points[index, 0] * x + points[index, 1] * y + points[index, 2] * z
            index = index[depth - depth.min() <= slack]
            small[row, column] = len(means)
            means.append(_sum(points[index]) / len(index))
            if colors is not None:
                tints.append(np.rint(colors[index].sum(axis=0) / len(index)))
    return np.array(means).reshape(-1, 3), np.array(tints, np.uint8).reshape(-1, 3), small


def cell_means(points, colors, side):
    """Return (means, colours) of `cell_means`."""
    low = points.min(axis=0)
    cells = ((points - low) * (1.0 / side)).astype(np.int64)
    _, first, number = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    number = number.ravel()
    order = np.argsort(first)
    groups = [np.flatnonzero(number == k) for k in order]
    means = [_sum(points[group]) / len(group) for group in groups]
    tints = [] if colors is None else [
        np.rint(colors[group].sum(axis=0) / len(group)) for group in groups]
    return np.array(means).reshape(-1, 3), np.array(tints, np.uint8).reshape(-1, 3)


def _sum(rows):
    """Add rows one after the other, as the kernel does (NumPy adds in pairs)."""
    total = np.zeros(3)
    for row in rows:
        total = total + row
    return total
