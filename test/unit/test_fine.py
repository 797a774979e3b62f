# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Multi-view fine registration; truth: analytic surfaces with exact poses, and invariances."""

import numpy as np
import pytest
from reference import bumpy
from ros_rops.core import williams
from ros_rops.core.config import FineConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.fine import FineView, refine_shape
from scipy.spatial.transform import Rotation

AROUND = [[np.cos(a), np.sin(a), h] for a, h in zip(
    np.arange(6) * np.pi / 3, [0.3, -0.3] * 3, strict=True)]
CONFIG = FineConfig()


@pytest.fixture(scope='module')
def ring():
    return bumpy.views_of(AROUND)


def refine(ring, start, config=CONFIG, threads=2):
    views, _, resolution = ring
    return refine_shape(views, start, resolution, config, threads=threads)


@pytest.mark.parametrize(('noise', 'count', 'most_deg', 'most_dres'), [
    (0.0, 12000, 0.015, 0.025), (0.5, 40000, 0.15, 0.2)])
def test_exact_poses_are_found(noise, count, most_deg, most_dres):
    views, truth, resolution = bumpy.views_of(AROUND, noise=noise, count=count)
    start = bumpy.disturbed(views, truth, resolution)
    assert bumpy.errors(views, start, truth, resolution)[0].max() > 1
    result = refine_shape(views, start, resolution, CONFIG)
    turns, shifts = bumpy.errors(views, result.poses, truth, resolution)
    assert turns.mean() < most_deg
    assert shifts.mean() < most_dres
    assert result.converged
    assert np.array_equal(result.poses[0], start[0])


def test_edges_and_views_tell_how_well_they_fit(ring):
    result = refine(ring, bumpy.disturbed(*ring))
    found = {(e.source, e.target): e for e in result.edges}
    neighbours = {(i, (i + 1) % 6) for i in range(6)}
    assert {tuple(sorted(n)) for n in neighbours} <= set(found)
    assert found[0, 1].overlap > 0.3
    assert max(e.residual_mr for e in result.edges) < 0.1
    for view in result.views:
        assert view.constrained
        assert view.component == 0
        assert view.residual_mr < 0.1
        assert view.agreement > 0.7


def test_a_common_motion_changes_nothing_else(ring):
    start = bumpy.disturbed(*ring)
    common = bumpy.rigid(Rotation.from_rotvec([0.3, -1.2, 0.7]), [1e3, -2e3, 5e2])
    here, there = refine(ring, start), refine(ring, [common @ pose for pose in start])
    moved = [np.linalg.inv(common) @ pose for pose in there.poses]
    turns, shifts = bumpy.errors(ring[0], moved, here.poses, ring[2])
    assert turns.max() < 1e-5
    assert shifts.max() < 1e-5


def test_units_change_nothing(ring):
    views, _, resolution = ring
    start = bumpy.disturbed(*ring)
    small = [FineView(v.points * 1e-3, v.normals, v.boundary) for v in views]
    scaled = [pose.copy() for pose in start]
    for pose in scaled:
        pose[:3, 3] *= 1e-3
    here = refine(ring, start)
    there = refine_shape(small, scaled, resolution * 1e-3, CONFIG)
    for a, b in zip(here.poses, there.poses, strict=True):
        np.testing.assert_allclose(a[:3, :3], b[:3, :3], atol=1e-6)
        np.testing.assert_allclose(a[:3, 3], b[:3, 3] * 1e3, atol=1e-3 * resolution)


def test_order_of_views_changes_only_the_common_frame(ring):
    views, _, resolution = ring
    start, order = bumpy.disturbed(*ring), [4, 2, 0, 5, 1, 3]
    here = refine(ring, start)
    there = refine_shape(
        [views[k] for k in order], [start[k] for k in order], resolution, CONFIG)
    placed = dict(zip(order, there.poses, strict=True))
    common = here.poses[0] @ np.linalg.inv(placed[0])
    moved = [common @ placed[k] for k in range(6)]
    turns, shifts = bumpy.errors(views, moved, here.poses, resolution)
    assert turns.max() < 0.01
    assert shifts.max() < 0.01


@pytest.mark.parametrize('method', ['simultaneous', 'williams'])
def test_threads_change_no_byte(ring, method):
    start, config = bumpy.disturbed(*ring), FineConfig(method=method, iterations=6)
    one, four = (refine(ring, start, config, threads) for threads in (1, 4))
    assert [p.tobytes() for p in one.poses] == [p.tobytes() for p in four.poses]
    assert one.edges == four.edges
    assert one.residual_mr == four.residual_mr


def test_groups_without_overlap_are_refined_apart():
    looks = [[0, 0, 1], [0.5, 0, 1], [0, 0, -1], [0.5, 0, -1]]
    views, truth, resolution = bumpy.views_of(looks, count=6000)
    start = bumpy.disturbed(views, truth, resolution)
    result = refine_shape(views, start, resolution, CONFIG)
    assert [v.component for v in result.views] == [0, 0, 1, 1]
    for first, second in ((0, 1), (2, 3)):
        assert np.array_equal(result.poses[first], start[first])
        apart = np.linalg.inv(result.poses[first]) @ result.poses[second]
        exact = np.linalg.inv(truth[first]) @ truth[second]
        turns, shifts = bumpy.errors([views[second]], [apart], [exact], resolution)
        assert turns.max() < 0.1
        assert shifts.max() < 0.3


def test_a_view_that_touches_nothing_keeps_its_pose(ring):
    views, _, resolution = ring
    start = bumpy.disturbed(*ring)
    start[3] = bumpy.rigid(Rotation.identity(), [1e4, 0, 0])
    empty = FineView(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, bool))
    result = refine_shape([*views, empty], [*start, start[1]], resolution, CONFIG)
    for alone in (3, 6):
        assert np.array_equal(result.poses[alone], [*start, start[1]][alone])
        assert np.isnan(result.views[alone].residual_mr)
        assert not result.views[alone].constrained
        assert result.views[alone].stiffness == 0.0
        assert all(alone not in (e.source, e.target) for e in result.edges)
    assert result.views[2].constrained


def test_a_ball_is_shifted_but_does_not_turn_about_its_centre():
    views, truth, resolution = bumpy.views_of([[0, 0, 1], [0.6, 0, 1]], bumps=0.0, noise=0.1)
    still = refine_shape(views, truth, resolution, CONFIG)
    turns, _ = bumpy.errors(views, still.poses, truth, resolution)
    assert turns.max() < 0.1
    assert not still.views[1].constrained
    assert np.linalg.norm(still.views[1].weakest) == pytest.approx(1.0)
    start = bumpy.disturbed(views, truth, resolution, degrees=0.0)
    result = refine_shape(views, start, resolution, CONFIG)
    centres = [(pose @ np.linalg.inv(t))[:3, 3]
               for pose, t in zip(result.poses, truth, strict=True)]
    assert np.linalg.norm((start[1] @ np.linalg.inv(truth[1]))[:3, 3]) > resolution
    assert np.linalg.norm(centres[0] - centres[1]) < 0.1 * resolution


def test_a_plane_slides_nowhere():
    x, y = np.meshgrid(np.arange(40.0), np.arange(40.0))
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    rim = (points[:, :2].min(axis=1) == 0) | (points[:, :2].max(axis=1) == 39)
    view = FineView(points, np.broadcast_to([0.0, 0.0, 1.0], points.shape), rim)
    start = bumpy.rigid(Rotation.from_rotvec([0.01, 0.02, 0]), [1.3, -0.7, 0.6])
    result = refine_shape([view, view], [np.eye(4), start], 1.0, CONFIG)
    np.testing.assert_allclose(result.poses[1][2], [0, 0, 1, 0], atol=1e-3)
    np.testing.assert_allclose(result.poses[1][:2, 3], [1.3, -0.7], atol=0.02)
    assert not result.views[1].constrained


def test_a_wrong_view_stands_out(ring):
    views, truth, resolution = ring
    start = list(truth)
    middle = views[4].points.mean(axis=0)
    look = views[4].normals.mean(axis=0)
    flip = bumpy.rigid(Rotation.from_rotvec(np.pi * look / np.linalg.norm(look)), np.zeros(3))
    start[4] = start[4] @ bumpy.rigid(Rotation.identity(), middle) @ flip @ bumpy.rigid(
        Rotation.identity(), -middle)
    result = refine(ring, start)
    worst = [v.residual_mr for v in result.views]
    assert int(np.argmax(worst)) == 4
    assert worst[4] > 1.5 * sorted(worst)[-2]
    turns, _ = bumpy.errors(views, result.poses, truth, resolution)
    assert turns[[1, 2]].max() < 1.0


def test_williams_approaches_the_exact_poses(ring):
    views, truth, resolution = ring
    start = bumpy.disturbed(*ring)
    result = refine(ring, start, FineConfig(method='williams'))
    before = bumpy.errors(views, start, truth, resolution)
    turns, shifts = bumpy.errors(views, result.poses, truth, resolution)
    assert turns.mean() < 0.7 * before[0].mean()
    assert shifts.mean() < 0.7 * before[1].mean()


def test_williams_is_exact_for_exact_correspondences():
    rng = np.random.default_rng(5)
    truth = np.array([
        bumpy.rigid(Rotation.random(rng=rng), rng.normal(size=3) * 9) for _ in range(4)])
    table = {}
    for i, j in ((0, 1), (1, 2), (2, 3), (3, 0)):
        common = rng.normal(size=(30, 3)) * 4
        table[i, j] = williams.moments_of(*(
            (common - truth[v][:3, 3]) @ truth[v][:3, :3] for v in (i, j)))
    start = np.array([
        pose @ bumpy.rigid(Rotation.from_rotvec(rng.normal(size=3) * 0.05), rng.normal(size=3))
        for pose in truth])
    start[0] = truth[0]
    poses = williams.fit(table, start, np.zeros(4, np.int32))
    for _ in range(10):
        poses = williams.fit(table, poses, np.zeros(4, np.int32))
    np.testing.assert_allclose(poses, truth, atol=1e-3)


def test_no_round_leaves_the_poses_and_still_reports(ring):
    truth = ring[1]
    result = refine(ring, truth, FineConfig(iterations=0))
    assert all(np.array_equal(a, b) for a, b in zip(result.poses, truth, strict=True))
    assert result.iterations == 0
    assert not result.converged
    assert result.edges


def test_one_view():
    views, truth, resolution = bumpy.views_of([[0, 0, 1]], count=3000)
    result = refine_shape(views, truth, resolution, CONFIG)
    assert np.array_equal(result.poses[0], truth[0])
    assert result.edges == ()
    assert result.converged


def test_bad_arguments_are_named(ring):
    views, truth, resolution = ring
    two = views[:2]
    for poses, length, text in (
        (truth[:1], resolution, 'poses'),
        ([truth[0], np.eye(3)], resolution, r'poses\[1\]'),
        ([truth[0], np.full((4, 4), np.nan)], resolution, r'poses\[1\]'),
        ([np.diag([1.0, 1.0, -1.0, 1.0]), truth[1]], resolution, r'poses\[0\].*rigid'),
        ([np.diag([2.0, 2.0, 2.0, 1.0]), truth[1]], resolution, r'poses\[0\].*rigid'),
        (truth[:2], 0.0, 'resolution'),
        (truth[:2], float('inf'), 'resolution'),
    ):
        with pytest.raises(ShapeError, match=text):
            refine_shape(two, poses, length, CONFIG)
    with pytest.raises(ShapeError, match='at least one view'):
        refine_shape([], [], 1.0, CONFIG)
    with pytest.raises(ShapeError, match='boundary'):
        FineView(np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(2, bool))
    with pytest.raises(ShapeError, match='normals'):
        FineView(np.zeros((3, 3)), np.zeros((2, 3)), np.zeros(3, bool))
    with pytest.raises(ShapeError, match='finite'):
        FineView(np.full((3, 3), np.inf), np.zeros((3, 3)), np.zeros(3, bool))
