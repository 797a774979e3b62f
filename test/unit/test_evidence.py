# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Closest-cell field, depth raster, growing, noise. Truth: brute force and plain geometry."""

import numpy as np
import pytest
from ros_rops.core.errors import ShapeError, ViewError
from ros_rops.core.types import SensorModel
from ros_rops.kernels.verification import Evidence, examine, score
from scipy.spatial import cKDTree

UP = np.array([0.0, 0.0, 1.0])
BLIND = SensorModel()


def evidence(points, sensor=BLIND, rim=None, normal=UP, cell=2.0, reach=7):
    points = np.asarray(points, float)
    rim = np.zeros(len(points), bool) if rim is None else rim
    return Evidence.of(
        points, np.tile(normal, (len(points), 1)).astype(float), rim, sensor,
        cell=cell, reach=reach)


def probe(target, places, normal=UP, tau=12.0, front=4.0):
    """Score a surface of one point, brought to each of `places`."""
    point = evidence(np.zeros((1, 3)), normal=normal)
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, 3] = places
    return score(point, target, poses, samples=1, tau=tau, front=front)


def plane(side=20, height=0.0, step=1.0):
    at = np.arange(-side, side + 1) * step
    x, y = (a.ravel() for a in np.meshgrid(at, at))
    return np.stack([x, y, np.full(len(x), height)], axis=1)


def test_field_knows_the_nearest_cell():
    random = np.random.default_rng(2)
    # Two bent sheets; all normals alike, so that the score tells the distance alone.
    x, y = random.uniform(-20, 20, (2, 3000))
    sheet = np.stack([x, y, 4 * np.sin(x / 6) + 3 * np.cos(y / 5)], axis=1)
    points = np.concatenate([sheet, sheet + 9.0 * UP])
    target = evidence(points)
    low = (points - points.mean(axis=0)).min(axis=0) - 16.0  # corner of the cells
    cells, at = np.unique(
        np.floor((points - points.mean(axis=0) - low) / 2), axis=0, return_inverse=True)
    means = np.stack([np.bincount(at.ravel(), points[:, a]) for a in range(3)], axis=1)
    means /= np.bincount(at.ravel())[:, None]
    # Middles of cells, where the field promises the nearest.
    middles = np.unique(cells + random.integers(-5, 6, cells.shape), axis=0)
    places = (middles + 0.5) * 2 + low + points.mean(axis=0)
    truth, _ = cKDTree(means).query(places)
    places, truth = places[truth < 10], truth[truth < 10]
    found = 12.0 * np.sqrt(1 - np.sqrt(probe(target, places).overlap[:, 0]))
    assert len(places) > 1000
    assert (found >= truth - 1e-3).all()
    assert (found <= 1.001 * truth + 1e-3).mean() > 0.9
    # A cell that holds surface names itself, though a neighbour's mean may be nearer.
    assert (found <= np.maximum(1.1 * truth, np.sqrt(3)) + 1e-3).all()


def test_field_ends_at_its_reach():
    target = evidence(plane(), reach=3)
    heights = np.array([[0.3, 0.3, z] for z in (1.0, 4.9, 9.0, 100.0, -9.0)])
    overlap = probe(target, heights, tau=14.0).overlap[:, 0]
    assert (overlap[:2] > 0).all()
    assert not overlap[2:].any()


DOWN = SensorModel('orthographic', direction=(0.0, 0.0, -1.0))


@pytest.mark.parametrize(('normal', 'height', 'word'), [
    (UP, 3.0, None),       # within the tolerance
    (UP, 5.0, 'front'),    # between the sensor and what it saw
    (UP, -8.0, None),      # hidden behind what it saw
    (-UP, 5.0, 'front'),   # whichever way it faces
])
def test_depth_over_the_plane(normal, height, word):
    found = probe(evidence(plane(), DOWN), [[0.5, 3.5, height]], normal)
    assert (found.front[0, 0], found.empty[0, 0]) == (word == 'front', 0)


@pytest.mark.parametrize(('normal', 'aside', 'word'), [
    (UP, 20.0, None),                    # over the plane's rim
    (UP, 23.5, None),                    # so near that a pixel's width decides
    (UP, 30.0, 'empty'),                 # faces the sensor, which saw nothing there
    (UP, 400.0, 'empty'),                # outside the image, but nothing was cut off
    (-UP, 30.0, None),                   # faces away: cannot have been seen
    (np.array([1.0, 0, 0.2]), 30.0, None),  # too oblique
])
def test_depth_beside_the_plane(normal, aside, word):
    normal = normal / np.linalg.norm(normal)
    found = probe(evidence(plane(), DOWN), [[aside, 0.5, 1.0]], normal)
    assert (found.front[0, 0], found.empty[0, 0]) == (0, word == 'empty')


@pytest.mark.parametrize(('place', 'normal', 'front', 'empty'), [
    ((0.5, 0.5, 60.0), UP, 1, 0),     # half way to the sensor
    ((0.5, 0.5, -50.0), UP, 0, 0),    # behind the plane
    ((28.0, 0.5, 0.0), UP, 0, 1),     # beside it
    ((28.0, 0.5, -60.0), UP, 0, 0),   # the same, but its ray passes through the plane
    ((14.0, 0.5, 60.0), UP, 0, 1),    # over the plane, but its ray passes beside it
    ((0.5, 0.5, 150.0), UP, 0, 0),    # behind the sensor
    ((28.0, 0.5, 0.0), -UP, 0, 0),    # faces away
])
def test_pinhole_sees_along_its_rays(place, normal, front, empty):
    sensor = SensorModel('pinhole', origin=(0.0, 0.0, 100.0), direction=(0.0, 0.0, -1.0))
    found = probe(evidence(plane(), sensor), [place], normal)
    assert (found.front[0, 0], found.empty[0, 0]) == (front, empty)


def test_a_blind_sensor_contradicts_nothing():
    found = probe(evidence(plane(), BLIND), [[0, 0, 9.0], [40.0, 0, 0]])
    assert not found.front.any()
    assert not found.empty.any()


def _rim(points):
    return np.abs(points[:, :2]).max(axis=1) >= 20


def test_growing_adds_what_is_new_once():
    left = plane()
    shape = evidence(left, DOWN, _rim(left))
    same = shape.grown(shape, np.eye(4), 0.9)
    assert same.kernel.vertex_count == len(left)
    # Twelve steps to the right, of which one column is the other's inside: 29 columns overlap.
    pose = np.eye(4)
    pose[0, 3] = 12.0
    grown = shape.grown(evidence(left, DOWN, _rim(left)), pose, 0.9)
    assert grown.kernel.vertex_count == len(left) + 12 * 41
    assert grown.kernel.sensor_count == 2


def test_growing_replaces_a_rim_by_the_inside():
    points = plane()
    shape = evidence(points, DOWN, _rim(points))
    wide = plane(30)
    wider = evidence(wide, DOWN, np.abs(wide[:, :2]).max(axis=1) >= 30)
    grown = shape.grown(wider, np.eye(4), 0.9)
    assert grown.kernel.vertex_count == len(wide)
    # Nothing of the old rim is left: a sample there is matched as an inside is.
    small = evidence(plane(2) + np.array([20.0, 0, 0.3]))
    options = {'rounds': 0, 'samples': 1000, 'radius': 2.0, 'front': 3.0}
    before = examine(small, shape, np.eye(4)[None], **options)[0].numbers[0]
    after = examine(small, grown, np.eye(4)[None], **options)[0].numbers[0]
    assert (before[1], after[1]) == (10, 25)


def test_growing_leaves_the_normals_as_they_were():
    # A sphere: wherever normals are carried along it, they no longer point outwards.
    random = np.random.default_rng(3)
    out = random.normal(size=(4000, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    shape = Evidence.of(30.0 * out, out, np.zeros(len(out), bool), BLIND, cell=2.0, reach=7)
    grown = shape
    for _ in range(100):
        grown = grown.grown(shape, np.eye(4), 1.0)
    first, last = shape.vertices(), grown.vertices()
    assert len(last.points) == len(first.points)
    _, same = cKDTree(last.points).query(first.points)
    assert np.abs(last.normals[same] - first.normals).max() < 1e-6


def test_a_grown_shape_remembers_where_each_sensor_stood():
    points = plane()
    shape = evidence(points, DOWN)
    away = np.eye(4)
    away[2, 3] = 50.0
    grown = shape.grown(evidence(points, DOWN), away, 0.9)
    # The second sample asks the second sensor; both lie between a sensor and its plane.
    pair = evidence([[0.5, 0.5, 0], [8.5, 0.5, 0]])
    for height, share in ((30.0, 0.5), (70.0, 1.0), (-30.0, 0.0)):
        pose = np.eye(4)
        pose[2, 3] = height
        front = score(pair, grown, pose[None], samples=2, tau=3.0, front=4.0).front[0, 0]
        assert front == share


@pytest.mark.parametrize('sigma', [0.0, 0.05, 0.2, 0.5])
@pytest.mark.parametrize('tilt', [0.0, 0.6])
def test_noise_of_a_plane(sigma, tilt):
    random = np.random.default_rng(4)
    points = plane(40)
    points[:, 2] += sigma * random.normal(size=len(points))
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    found = evidence(points @ turn.T, normal=turn @ UP).noise
    assert found == pytest.approx(sigma, rel=0.1, abs=1e-4)


def test_stray_points_are_told():
    points = np.concatenate([plane(), [[0, 0, 1e9]]])
    with pytest.raises(ViewError, match='stray'):
        evidence(points)


def test_arrays_that_do_not_fit():
    with pytest.raises(ShapeError, match='boundary'):
        evidence(plane(), rim=np.zeros(3, bool))
    with pytest.raises(ShapeError, match='normals'):
        Evidence.of(plane(), plane()[1:], np.zeros(1681, bool), BLIND, cell=2.0, reach=7)
