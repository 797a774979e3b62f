# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Points shown of a view. Truth: cells counted one by one, and a lattice that halves exactly."""

import numpy as np
import pytest
from ros_rops.live.thinning import spread_order


def _cells(points, side):
    return [tuple(cell) for cell in np.floor((points - points.min(axis=0)) / side).astype(int)]


def test_one_point_of_each_cell_the_one_nearest_to_its_centre():
    points = np.random.default_rng(1).uniform(-3.0, 5.0, (3000, 3))
    order = spread_order(points, 0.9)
    best = {}
    for index, cell in enumerate(_cells(points, 0.9)):
        centre = points.min(axis=0) + (np.array(cell) + 0.5) * 0.9
        off = np.linalg.norm(points[index] - centre)
        best[cell] = min(best.get(cell, (np.inf, -1)), (off, index))
    assert order.dtype == np.int32
    assert sorted(order) == sorted(index for _, index in best.values())


@pytest.mark.parametrize('part', [16, 64, 256])
def test_any_first_part_is_spread_evenly(part):
    # 64 x 64 points shuffled; of the first 16, 64, 256, each of 16 squares holds as many.
    lattice = np.stack(np.meshgrid(np.arange(64.0), np.arange(64.0), [0.0]), -1).reshape(-1, 3)
    lattice = np.random.default_rng(2).permutation(lattice)
    first = lattice[spread_order(lattice, 0.99)[:part]]
    counts = np.zeros((4, 4), int)
    np.add.at(counts, tuple((first[:, :2] // 16).astype(int).T), 1)
    assert (counts == part // 16).all()


def test_without_a_spacing_every_point_comes_once():
    points = np.random.default_rng(3).normal(size=(777, 3))
    assert sorted(spread_order(points, 0.0)) == list(range(777))


@pytest.mark.parametrize(('points', 'side', 'count'), [
    (np.zeros((0, 3)), 1.0, 0), (np.ones((1, 3)), 0.0, 1), (np.ones((9, 3)), 0.5, 1),
    (np.ones((9, 3)), 0.0, 9), (np.array([[0.0, 0, 0], [1e9, 0, 0]]), 1e-6, 2)])
def test_odd_points(points, side, count):
    assert len(spread_order(points, side)) == count
