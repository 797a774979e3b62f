# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The unit of length, dres. Truth: analytic (lattices, whose edges can be counted)."""

from dataclasses import replace

import numpy as np
import pytest
from ros_rops.bench.resolution import mesh_resolution
from ros_rops.core.errors import ViewError
from ros_rops.core.types import RangeView, SensorModel

N = 12
# N rows of N - 1 edges, as many columns, a diagonal in each cell.
LATTICE = (2 * N * (N - 1) + np.sqrt(2) * (N - 1) ** 2) / (2 * N * (N - 1) + (N - 1) ** 2)


def lattice(size=1.0, z=5.0):
    v, u = np.mgrid[:N, :N]
    points = np.stack([u * size, v * size, np.full(u.shape, z)], axis=-1).reshape(-1, 3)
    return RangeView('lattice', points, np.arange(N * N).reshape(N, N))


@pytest.mark.parametrize('size', [1.0, 0.001, 1000.0])
def test_a_lattice_has_the_mean_of_its_edges(size):
    assert mesh_resolution(lattice(size)) == pytest.approx(size * LATTICE)


@pytest.mark.parametrize('sensor', [
    SensorModel('orthographic', direction=(0.0, 0.0, -1.0)), SensorModel('pinhole'),
    SensorModel()])
def test_points_without_a_grid_give_the_same(sensor):
    view = replace(lattice(), grid=None, sensor=sensor)
    # Along the rim of an image that is not square to the lattice, slivers may come in.
    assert mesh_resolution(view) == pytest.approx(LATTICE, rel=0.02)


def test_steps_in_depth_do_not_count():
    view = lattice()
    points = view.points.copy()
    points[points[:, 0] >= N / 2, 2] += 100.0
    stepped = RangeView('stepped', points, view.grid)
    assert mesh_resolution(stepped) == pytest.approx(LATTICE, rel=0.02)


def test_holes_of_the_grid_have_no_edges():
    view = lattice()
    grid = np.asarray(view.grid).copy()
    grid[1::2] = -1
    # Every other row is gone: what is left are the edges along the rows, all of length 1.
    assert mesh_resolution(RangeView('rows', view.points, grid)) == pytest.approx(1.0)


@pytest.mark.parametrize('points', [
    np.zeros((0, 3)), np.zeros((1, 3)), np.zeros((50, 3)), np.eye(3)[:2]])
def test_too_little_is_named(points):
    with pytest.raises(ViewError, match='few'):
        mesh_resolution(RangeView('few', points))
