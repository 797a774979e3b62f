# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Sampling no finer than the depths are; truth: analytic surfaces rounded to a known step."""

from dataclasses import replace

import numpy as np
import pytest
from ros_rops.core.config import MeshConfig
from ros_rops.core.sampling import coarsened, depth_step
from ros_rops.core.types import RangeView, SensorModel

FOCAL = 600.0
CONFIG = MeshConfig()


def depth_camera(step, depth=0.3, shape=(90, 120), noise=0.0):
    """Return a bumpy wall seen by a pinhole, its depths rounded to `step`, and exact depths."""
    rows, columns = np.mgrid[:shape[0], :shape[1]]
    exact = depth + 0.02 * np.sin(columns / 17.0) + 0.01 * np.cos(rows / 11.0)
    z = exact + np.random.default_rng(3).normal(0.0, noise or 1e-12, shape)
    z = np.round(z / step) * step if step else z
    x = (columns - shape[1] / 2) / FOCAL * z
    y = (rows - shape[0] / 2) / FOCAL * z
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    grid = np.arange(len(points), dtype=np.int32).reshape(shape)
    return RangeView('wall', points, grid, SensorModel('pinhole'), units='m'), exact


@pytest.mark.parametrize('step', [0.001, 0.0005, 0.004])
def test_the_step_is_found(step):
    view, _ = depth_camera(step, noise=step)
    assert depth_step(view) == pytest.approx(step, rel=1e-6)


def test_continuous_depths_leave_the_view_alone():
    view, _ = depth_camera(0.0)
    assert depth_step(view) < 0.05 * 0.3 / FOCAL
    assert coarsened(view, CONFIG) is view


def test_zero_steps_leave_the_view_alone():
    view, _ = depth_camera(0.001)
    assert coarsened(view, replace(CONFIG, depth_steps=0.0)) is view


def test_pixels_at_the_wanted_spacing_are_kept():
    view, _ = depth_camera(0.001, depth=0.9)
    assert coarsened(view, CONFIG) is view


def test_blocks_are_spaced_as_wanted_and_nearer_to_the_truth():
    view, exact = depth_camera(0.001, noise=0.0005)
    result = coarsened(view, CONFIG)
    size = round(CONFIG.depth_steps * 0.001 / (0.3 / FOCAL))
    assert result.grid.shape == (-(-90 // size), -(-120 // size))
    points = result.points
    columns, rows = points[:, :2].T / points[:, 2] * FOCAL + np.array([[60.0], [45.0]])
    truth = 0.3 + 0.02 * np.sin(columns / 17.0) + 0.01 * np.cos(rows / 11.0)
    before = np.abs(view.points[:, 2] - exact.reshape(-1)).mean()
    assert np.abs(points[:, 2] - truth).mean() < 0.6 * before


def test_without_a_grid_the_same_blocks_come_of_the_rays():
    view, _ = depth_camera(0.001, noise=0.0005)
    with_grid, without = coarsened(view, CONFIG), coarsened(replace(view, grid=None), CONFIG)
    assert len(without.points) == pytest.approx(len(with_grid.points), rel=0.1)
    assert without.grid is not None


def test_an_unknown_sensor_without_a_grid_tells_no_pixels():
    view, _ = depth_camera(0.001)
    loose = replace(view, grid=None, sensor=SensorModel('unknown'))
    assert coarsened(loose, CONFIG) is loose


def test_a_depth_edge_is_not_bridged():
    view, _ = depth_camera(0.001)
    points = view.points.copy()
    far = np.arange(len(points)) % 120 >= 61
    points[far] *= 1.5
    result = coarsened(replace(view, points=points), CONFIG)
    near, beyond = 0.3 + 0.03, 1.5 * (0.3 - 0.03)
    z = result.points[:, 2]
    assert ((z <= near + 1e-3) | (z >= beyond - 1e-3)).all()


def test_colours_are_averaged():
    view, _ = depth_camera(0.001)
    colors = np.full(view.points.shape, (10, 20, 30), np.uint8)
    colors[::2] = (20, 20, 30)
    result = coarsened(replace(view, colors=colors), CONFIG)
    assert result.colors.shape == result.points.shape
    assert abs(result.colors[:, 0].astype(float).mean() - 15.0) < 1.0
    assert (result.colors[:, 1:] == (20, 30)).all()


def test_points_all_over_the_place_cost_no_memory():
    view, _ = depth_camera(0.001)
    points = view.points.copy()
    points[0] = (1e6, 0.0, 0.3)
    loose = replace(view, points=points, grid=None)
    assert len(coarsened(loose, CONFIG).points) > 0


@pytest.mark.parametrize('count', [0, 1, 2])
def test_hardly_any_points(count):
    points = np.array([[0.0, 0.0, 0.3], [0.001, 0.0, 0.301]])[:count]
    view = RangeView('few', points, None, SensorModel('pinhole'), units='m')
    assert len(coarsened(view, CONFIG).points) <= count
