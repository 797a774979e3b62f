# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Kernels on clouds against their twins in NumPy, bit by bit."""

import numpy as np
import pytest
from reference import points_twin as twin
from ros_rops.core.errors import ShapeError
from ros_rops.kernels.points import (
    block_means, cell_means, count_cells, count_holes, measured, some_groups)

LIMIT = 1e15


def _cloud(dtype, count=5000, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3)).astype(dtype)
    odd = [np.nan, np.inf, -np.inf, LIMIT, 1.01 * LIMIT, -2e15, 0.0, 3e38]
    where = rng.integers(0, count, (1200, 2)) % [count, 3]
    points[where[:, 0], where[:, 1]] = rng.choice(odd, len(where)).astype(dtype)
    points[rng.integers(0, count, 100)] = 0
    points[rng.integers(0, count, 100)] = np.nan
    return points


@pytest.mark.parametrize('dtype', [np.float32, np.float64])
def test_measured_and_holes(dtype):
    points = _cloud(dtype)
    kept, numbers = measured(points, LIMIT)
    expected, places = twin.measured(points, LIMIT)
    assert 3000 < len(kept) < 4900
    assert np.array_equal(kept, expected)
    assert np.array_equal(numbers, places)
    assert numbers.dtype == np.int32 and kept.dtype == np.float64
    halves, zeros = count_holes(points)
    assert (halves, zeros) == twin.count_holes(points)
    assert halves > 50 and zeros > 90


def test_rows_apart_and_nothing_at_all():
    points = _cloud(np.float32)
    every = measured(points[::3], LIMIT)
    assert np.array_equal(every.points, twin.measured(points[::3], LIMIT)[0])
    none = measured(np.zeros((0, 3), np.float32), LIMIT)
    assert none.points.shape == (0, 3) and none.numbers.shape == (0,)
    assert count_holes(np.zeros((0, 3))) == (0, 0)


def _image(seed=1, shape=(61, 83)):
    rng = np.random.default_rng(seed)
    grid = np.full(shape, -1, np.int32)
    seen = rng.random(shape) < 0.7
    seen[:20, :20] = False
    grid[seen] = rng.permutation(seen.sum())
    points = rng.normal(size=(seen.sum(), 3))
    return points, grid, rng.integers(0, 256, points.shape).astype(np.uint8)


@pytest.mark.parametrize('side', [1, 2, 5, 100])
@pytest.mark.parametrize('slack', [0.0, 0.4, np.inf])
def test_block_means(side, slack):
    points, grid, colors = _image()
    axis = (0.1, -0.2, 0.97)
    means, tints, small = twin.block_means(points, grid, colors, axis, side, slack)
    for threads in (1, 2, 3):
        found = block_means(points, grid, colors, axis, side, slack, threads)
        assert np.array_equal(found.means.points, means)
        assert np.array_equal(found.means.colors, tints)
        assert np.array_equal(found.grid, small)
    assert block_means(points, grid, None, axis, side, slack).means.colors is None


@pytest.mark.parametrize('side', [0.05, 0.3, 100.0])
def test_cell_means(side):
    points, _, colors = _image(2)
    means, tints = twin.cell_means(points, colors, side)
    found = cell_means(points, colors, side)
    assert np.array_equal(found.points, means)
    assert np.array_equal(found.colors, tints)
    assert count_cells(points, side) == len(means)


def test_cells_of_one_place_and_of_absurd_extent():
    same = np.full((10, 3), 2.5)
    assert np.array_equal(cell_means(same, None, 0.1).points, same[:1])
    assert count_cells(np.zeros((0, 3)), 0.1) == 0
    far = np.concatenate([same, [[1e15, -1e15, 1e15]]])
    assert count_cells(far, 1e-9) == 2


@pytest.mark.parametrize('share', [1, 4])
def test_some_groups_are_whole_and_taken_in_their_share(share):
    points = np.random.default_rng(3).random((60000, 3))
    some = some_groups(points, 0.02, share)
    kept = np.isin(points[:, 0], some[:, 0])
    groups = ((points - points.min(axis=0)) * (1 / 0.02)).astype(int) // 4
    taken = set(map(tuple, groups[kept].tolist()))
    assert taken.isdisjoint(map(tuple, groups[~kept].tolist()))
    assert np.array_equal(some, points[kept])
    assert len(some) == pytest.approx(len(points) / share, rel=0.15)


def test_wrong_shapes():
    points, grid, colors = _image()
    axis = (0.0, 0.0, 1.0)
    for call in (
            lambda: measured(points[:, :2], LIMIT),
            lambda: measured(grid, LIMIT),
            lambda: count_holes(points[0]),
            lambda: block_means(points[:9], grid, None, axis, 2, 1.0),
            lambda: block_means(points, grid[0], None, axis, 2, 1.0),
            lambda: block_means(points, grid, colors[:9], axis, 2, 1.0),
            lambda: block_means(points, grid, colors, axis, 0, 1.0),
            lambda: cell_means(np.full((3, 3), np.nan), None, 0.1),
            lambda: some_groups(points, 0.1, 0),
            lambda: cell_means(points, colors.astype(float), 0.1)):
        with pytest.raises(ShapeError):
            call()
