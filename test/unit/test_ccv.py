# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""CCV; truth: a twin that compares every pair of transforms, and motions known beforehand."""

import numpy as np
import pytest
from reference import ccv_twin
from ros_rops.core.ccv import best_by_count, ccv_transforms, count_inliers, euler_angles
from ros_rops.core.config import CcvConfig
from ros_rops.core.errors import ParameterError, ShapeError
from ros_rops.core.se3 import rigid
from ros_rops.core.simplify import simplify
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

CENTRE = np.array([3.0, -5.0, 40.0])
METRICS = pytest.mark.parametrize('metric', ['so3', 'euler'])


def motion(vector=(0.3, -0.9, 0.5), shift=(12.0, 3.0, -7.0)):
    return rigid(Rotation.from_rotvec(vector).as_matrix(), np.array(shift))


def applied(transforms, points):
    return np.einsum('mij,mj->mi', transforms[:, :3, :3], points) + transforms[:, :3, 3]


def noisy(truth, count, seed, angle=0.1, shift=3.0):
    """Return matches of points about CENTRE whose transforms scatter about the truth there."""
    random = np.random.default_rng(seed)
    points = CENTRE + random.normal(scale=10.0, size=(count, 3))
    turn = Rotation.from_rotvec(random.normal(scale=angle, size=(count, 3))).as_matrix()
    rotations = turn @ truth[:3, :3]
    there = truth[:3, :3] @ CENTRE + truth[:3, 3] + random.normal(scale=shift, size=(count, 3))
    return points, rigid(rotations, there - rotations @ CENTRE)


@METRICS
@pytest.mark.parametrize('seed', [1, 2])
def test_equals_the_twin(metric, seed, monkeypatch):
    monkeypatch.setattr('ros_rops.core.ccv._PAIRS', 500)  # several blocks
    parts = [noisy(motion(), 60, seed), noisy(motion((2, 2, 0.5)), 30, seed + 9, 0.2, 8.0)]
    points = np.concatenate([points for points, _ in parts])
    transforms = np.concatenate([transforms for _, transforms in parts])
    target = applied(transforms, points)
    config = CcvConfig(metric=metric, distance_mr=4.0)
    found = ccv_transforms(points, target, transforms, config, 1.5, CENTRE)
    expected, support = ccv_twin.groups(
        points, target, transforms, metric, config.angle_rad, 6.0, CENTRE)
    assert found.support.tolist() == support.tolist()
    # All kinds of groups occur: alone, averaged, fitted.
    assert {1, 2} <= set(support) and support.max() > 5
    assert np.allclose(found.transforms, expected, atol=1e-9)


@METRICS
def test_right_matches_among_random_ones_give_the_motion(metric):
    truth, random = motion(), np.random.default_rng(8)
    right, single = noisy(truth, 40, 5, angle=0.03, shift=1.0)
    wrong = rigid(Rotation.random(200, random_state=6).as_matrix(), random.normal(size=(200, 3)))
    points = np.concatenate([right, CENTRE + random.normal(scale=10.0, size=(200, 3))])
    target = np.concatenate([right @ truth[:3, :3].T + truth[:3, 3],
                             random.normal(scale=10.0, size=(200, 3))])
    transforms = np.concatenate([single, wrong])
    found = ccv_transforms(points, target, transforms, CcvConfig(metric=metric), 1.0, CENTRE)
    best = found.support.argmax()
    assert best < 40 and found.support[best] > 20 and found.support[40:].max() < 10
    assert np.allclose(found.transforms[best], truth, atol=1e-9)
    surface = random.normal(scale=10.0, size=(500, 3)) + CENTRE
    other = surface @ truth[:3, :3].T + truth[:3, 3]
    counts = count_inliers(surface, other, found.transforms, 0.5)
    assert counts.max() == 500
    chosen = best_by_count(counts, found.support)
    assert np.allclose(found.transforms[chosen], truth, atol=1e-6)


def test_a_far_sensor_hides_consistency_from_the_paper_metric_only():
    # The known weak point: 0.05 rad about a point 1000 mr away move the translation by 50 mr.
    far = np.array([0.0, 0.0, 1000.0])
    turns = Rotation.from_rotvec([[0, 0, 0], [0.05, 0, 0], [0, 0.05, 0]]).as_matrix()
    transforms = rigid(turns, far - turns @ far)
    points = far + np.array([[10.0, 0, 0], [0, 10, 0], [0, 0, 10]])
    for metric, size in (('so3', 3), ('euler', 1)):
        found = ccv_transforms(
            points, applied(transforms, points), transforms, CcvConfig(metric=metric), 1.0, far)
        assert found.support.tolist() == [size] * 3


def test_half_turns_are_close_where_their_quaternions_are_opposite():
    turns = Rotation.from_rotvec([[0, 0, np.pi - 0.05], [0, 0, np.pi + 0.05]]).as_matrix()
    points = np.eye(3)[:2]
    transforms = rigid(turns, np.zeros((2, 3)))
    found = ccv_transforms(
        points, applied(transforms, points), transforms, CcvConfig(), 1.0, np.zeros(3))
    assert found.support.tolist() == [2, 2]
    half = rigid(Rotation.from_rotvec([0, 0, np.pi]).as_matrix(), np.zeros(3))
    assert np.allclose(found.transforms, half, atol=1e-9)


@METRICS
@pytest.mark.parametrize('count', [0, 1])
def test_none_and_one(metric, count):
    transforms = np.tile(motion(), (count, 1, 1))
    points = np.ones((count, 3))
    found = ccv_transforms(
        points, applied(transforms, points), transforms, CcvConfig(metric=metric), 1.0, CENTRE)
    assert found.transforms.tolist() == transforms.tolist()
    assert found.support.tolist() == [1] * count


@METRICS
@pytest.mark.parametrize('shape', ['coincident', 'line'])
def test_points_that_leave_the_rotation_open_are_averaged(metric, shape):
    transforms = np.tile(motion(), (6, 1, 1))
    points = 100 + np.outer(np.arange(6.0) if shape == 'line' else np.zeros(6), [1, 2, 3])
    found = ccv_transforms(
        points, applied(transforms, points), transforms, CcvConfig(metric=metric), 1.0, CENTRE)
    assert found.support.tolist() == [6] * 6
    assert np.allclose(found.transforms, motion(), atol=1e-9)


def test_euler_angles_are_scipys():
    turns = Rotation.random(50, random_state=2)
    assert np.allclose(euler_angles(turns.as_matrix()), turns.as_euler('xyz'))


def test_counts_equal_brute_force_and_threads_do_not_matter():
    random = np.random.default_rng(2)
    source, target = random.normal(size=(80, 3)), random.normal(size=(90, 3))
    transforms = rigid(Rotation.random(7, random_state=3).as_matrix(), np.zeros((7, 3)))
    counts = count_inliers(source, target, transforms, 0.4)
    expected = [
        (cdist(source @ t[:3, :3].T, target).min(axis=1) < 0.4).sum() for t in transforms]
    assert counts.tolist() == expected and max(expected) > min(expected) > 0
    assert count_inliers(source, target, transforms, 0.4, threads=2).tolist() == expected


def test_counting_nothing():
    nothing, one = np.zeros((0, 3)), np.zeros((1, 3))
    assert count_inliers(nothing, one, np.eye(4)[None], 1.0).tolist() == [0]
    assert count_inliers(one, nothing, np.eye(4)[None], 1.0).tolist() == [0]
    assert len(count_inliers(one, one, np.zeros((0, 4, 4)), 1.0)) == 0


@pytest.mark.parametrize(('counts', 'support', 'best'), [
    ([], [], None),
    ([0, 0], [5, 9], None),
    ([3, 7, 5], [9, 1, 9], 1),
    ([7, 7, 7], [2, 4, 4], 1),
])
def test_best_by_count(counts, support, best):
    assert best_by_count(np.array(counts, np.int32), np.array(support, np.int32)) == best


def test_simplified_points_are_the_means_of_cells():
    random = np.random.default_rng(1)
    points = random.uniform(-9, 9, size=(300, 3))
    cells = {}
    for point in points:
        cells.setdefault(tuple(np.floor((point - points.min(axis=0)) / 4.0)), []).append(point)
    expected = [np.mean(cells[cell], axis=0) for cell in sorted(cells)]
    assert np.allclose(simplify(points, 4.0), expected)
    assert simplify(np.zeros((0, 3)), 1.0).shape == (0, 3)


def test_callers_mistakes():
    ones, transforms = np.ones((2, 3)), np.tile(np.eye(4), (2, 1, 1))
    with pytest.raises(ShapeError, match='source_positions'):
        ccv_transforms(ones[:1], ones, transforms, CcvConfig(), 1.0, CENTRE)
    with pytest.raises(ShapeError, match='transforms'):
        ccv_transforms(ones, ones, transforms[:, :3], CcvConfig(), 1.0, CENTRE)
    with pytest.raises(ShapeError, match='centre'):
        ccv_transforms(ones, ones, transforms, CcvConfig(), 1.0, np.zeros(2))
    for wrong in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ParameterError, match='resolution'):
            ccv_transforms(ones, ones, transforms, CcvConfig(), wrong, CENTRE)
        with pytest.raises(ParameterError, match='radius'):
            count_inliers(ones, ones, transforms, wrong)
    with pytest.raises(ParameterError, match='metric'):
        CcvConfig(metric='quaternion')
