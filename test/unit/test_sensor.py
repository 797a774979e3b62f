# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Where the rays come from; truth: rays laid by the test, and the published poses."""

import os
from pathlib import Path

import numpy as np
import pytest

from ros_rops.core.errors import ParameterError
from ros_rops.recordings.dataset import read_dataset
from ros_rops.recordings.sensor import resolve_sensor

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))
needs_scans = pytest.mark.skipif(not DATA.is_dir(), reason=f'no real scans at {DATA}')


def bumps(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.sin(u / 5) + np.cos(v / 7) + 0.02 * u


def pixels(height: int = 30, width: int = 40) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    v, u = np.mgrid[:height, :width].astype(float)
    return u.ravel(), v.ravel(), np.arange(height * width, dtype=np.int32).reshape(height, width)


@pytest.mark.parametrize('sign', [1, -1])
def test_organized_pinhole(sign):
    u, v, grid = pixels()
    z = sign * (20 + bumps(u, v))
    points = np.stack([(u - 19) / 50 * z, (v - 14) / 50 * z, z], axis=1)
    sensor, note = resolve_sensor(points, grid, 'auto')
    assert sensor.kind == 'pinhole'
    assert sensor.direction == (0, 0, sign)
    assert 'inferred' in note


@pytest.mark.parametrize('slope', [(0.0, 0.0), (0.5, -0.1)])
@pytest.mark.parametrize('offset', [0.0, 100.0, 1e6])
def test_organized_parallel_rays_also_oblique(slope, offset):
    u, v, grid = pixels()
    z = bumps(u, v)
    points = np.stack([u + slope[0] * z, v + slope[1] * z, z], axis=1) + offset
    sensor, _ = resolve_sensor(points, grid, 'auto')
    assert sensor.kind == 'orthographic'
    expected = -np.array([*slope, 1.0]) / np.linalg.norm([*slope, 1.0])
    np.testing.assert_allclose(sensor.direction, expected, atol=1e-6)


def test_flat_organized_view_looks_along_the_axis():
    u, v, grid = pixels()
    points = np.stack([u, v, np.zeros(len(u))], axis=1)
    sensor, _ = resolve_sensor(points, grid, 'auto')
    np.testing.assert_allclose(sensor.direction, (0, 0, -1), atol=1e-12)


def test_holes_and_noise_do_not_disturb():
    rng = np.random.default_rng(4)
    u, v, grid = pixels(60, 80)
    z = 30 + bumps(u, v) + rng.normal(0, 0.05, len(u))
    points = np.stack([(u - 39) / 90 * z, (v - 29) / 90 * z, z], axis=1)
    grid[rng.random(grid.shape) < 0.5] = -1
    assert resolve_sensor(points, grid, 'auto')[0].kind == 'pinhole'


def test_scrambled_grid_is_not_believed():
    rng = np.random.default_rng(5)
    u, v, grid = pixels()
    points = np.stack([u, v, bumps(u, v)], axis=1)
    shuffled = rng.permutation(grid.ravel()).reshape(grid.shape)
    sensor, note = resolve_sensor(points, shuffled, 'auto')
    assert sensor.kind == 'orthographic'
    assert 'assumed' in note


@pytest.mark.parametrize(
    ('offset', 'kind', 'direction'),
    [
        ((0, 0, 10), 'pinhole', (0, 0, 1)),
        ((1, -2, -10), 'pinhole', (0, 0, -1)),
        ((0, 0, 0), 'orthographic', (0, 0, -1)),  # the origin amid the points
        ((0, 0, 1.5), 'orthographic', (0, 0, -1)),  # too near
        ((30, 0, 10), 'orthographic', (0, 0, -1)),  # far at the side
        ((0, 0, 1e6), 'orthographic', (0, 0, -1)),  # no sensor sees that far
    ],
)
def test_unorganized(offset, kind, direction):
    points = np.random.default_rng(6).uniform(-1, 1, (500, 3)) + offset
    sensor, note = resolve_sensor(points, None, 'auto')
    assert (sensor.kind, sensor.direction) == (kind, direction)
    assert note


@pytest.mark.parametrize('count', [0, 1, 2])
def test_too_few_points(count):
    assert resolve_sensor(np.zeros((count, 3)), None, 'auto')[0].kind == 'unknown'
    grid = np.arange(count, dtype=np.int32).reshape(1, count)
    assert resolve_sensor(np.zeros((count, 3)), grid, 'auto')[0].kind == 'unknown'


def test_coinciding_points():
    assert resolve_sensor(np.ones((50, 3)), None, 'auto')[0].kind == 'orthographic'
    sensor, _ = resolve_sensor(np.zeros((30 * 40, 3)), pixels()[2], 'auto')
    assert np.isfinite(sensor.direction).all()


def test_stated():
    behind = np.full((5, 3), -3.0)
    assert resolve_sensor(behind, None, '+x')[0].direction == (1, 0, 0)
    assert resolve_sensor(behind, None, 'pinhole')[0].direction == (0, 0, -1)
    assert resolve_sensor(-behind, None, 'pinhole')[0].direction == (0, 0, 1)
    assert resolve_sensor(behind, None, 'unknown')[0].kind == 'unknown'
    with pytest.raises(ParameterError, match='sensor'):
        resolve_sensor(behind, None, 'sideways')


def raster_frame(direction: tuple[float, float, float]) -> np.ndarray:
    d = np.array(direction)
    a = np.cross(d, (0.0, 1.0, 0.0))
    a /= np.linalg.norm(a)
    return np.stack([a, np.cross(d, a), d])


def share_in_front(name: str, cell: float, flip: bool) -> float:
    """Share of other views' points that float in front of what a view saw, by known poses."""
    dataset = read_dataset(DATA / name)
    views = [noted.view for noted in dataset.read_views()]
    tested = in_front = 0
    for view in views[::4]:
        frame = raster_frame(view.sensor.direction) * (-1 if flip else 1)
        local = view.points @ frame.T
        low = np.floor(local[:, :2].min(axis=0) / cell).astype(int)
        cells = np.floor(local[:, :2] / cell).astype(int) - low
        nearest = np.full(cells.max(axis=0) + 1, np.inf)
        np.minimum.at(nearest, tuple(cells.T), local[:, 2])
        for other in views:
            T = np.linalg.inv(dataset.T_world_view[view.name]) @ dataset.T_world_view[other.name]
            moved = (other.points[::31] @ T[:3, :3].T + T[:3, 3]) @ frame.T
            at = np.floor(moved[:, :2] / cell).astype(int) - low
            inside = ((at >= 0) & (at < nearest.shape)).all(axis=1)
            seen = nearest[tuple(at[inside].T)]
            depth = moved[inside, 2][np.isfinite(seen)]
            tested += len(depth)
            in_front += np.count_nonzero(depth < seen[np.isfinite(seen)] - 5 * cell)
    return in_front / tested


@needs_scans
@pytest.mark.parametrize(('name', 'cell'), [('bunny', 0.001), ('dragon_stand', 0.0012)])
def test_nothing_floats_in_front_of_a_stanford_view(name, cell):
    assert share_in_front(name, cell, flip=False) < 0.005
    assert share_in_front(name, cell, flip=True) > 0.2  # the other direction would be refuted


@needs_scans
def test_minolta_rays_leave_the_origin():
    """Neighbours along a scan line are equally far apart in x/z (a lattice), not in x."""
    for name in ('chef', 'parasaurolophus'):
        for noted in read_dataset(DATA / name).read_views()[::4]:
            view = noted.view
            assert view.sensor.kind == 'pinhole'
            assert view.sensor.direction == (0, 0, -1)
            steps = np.diff(view.points[:, :2] / view.points[:, 2:], axis=0)
            line = np.abs(steps[:, 1]) < 1e-4
            along = np.abs(steps[line, 0])
            unit = np.median(along)
            near = along[along < 1.5 * unit]
            assert len(near) > 0.9 * np.count_nonzero(line)
            assert near.std() < 0.02 * unit
            plain = np.abs(np.diff(view.points[:, 0]))[line][along < 1.5 * unit]
            assert plain.std() / plain.mean() > 1.5 * near.std() / near.mean()
