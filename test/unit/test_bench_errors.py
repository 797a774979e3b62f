# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Pair errors and overlap. Truth: analytic (poses moved by known amounts, points on a line)."""

import numpy as np
import pytest
from ros_rops.bench.errors import pair_errors, rotation_error_deg
from ros_rops.bench.evaluation import evaluate_pairs, overlap, overlap_bin
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.types import RangeView
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation


def transform(axis=(0, 0, 1), deg=0.0, shift=(0, 0, 0)):
    result = np.eye(4)
    axis = np.asarray(axis) / np.linalg.norm(axis)
    result[:3, :3] = Rotation.from_rotvec(np.radians(deg) * axis).as_matrix()
    result[:3, 3] = shift
    return result


@pytest.mark.parametrize('deg', [0.0, 1e-6, 0.01, 4.9999, 90.0, 179.9999, 180.0])
def test_known_angle_is_found(deg):
    reference = transform((1, 2, 3), 77.0)[:3, :3]
    estimate = transform((3, -1, 2), deg)[:3, :3] @ reference
    assert rotation_error_deg(estimate, reference) == pytest.approx(deg, abs=1e-6)


def test_translation_is_measured_at_the_centroid():
    # A turn about the centroid moves the centroid nowhere, the origin far.
    centroid = np.array([0.0, 0.0, 100.0])
    turn = transform((1, 0, 0), 2.0)
    turn[:3, 3] = centroid - turn[:3, :3] @ centroid
    errors = pair_errors(turn, np.eye(4), centroid, dres=0.5)
    assert errors.rotation_deg == pytest.approx(2.0)
    assert errors.translation_dres == pytest.approx(0.0, abs=1e-9)
    lever = 2 * 100 * np.sin(np.radians(1.0)) / 0.5
    assert errors.raw_translation_dres == pytest.approx(lever)
    assert errors.correct


def test_translation_is_in_dres():
    errors = pair_errors(transform(shift=(3, 0, 4)), np.eye(4), np.zeros(3), dres=2.0)
    assert errors.translation_dres == pytest.approx(2.5)
    assert errors.raw_translation_dres == pytest.approx(2.5)


@pytest.mark.parametrize(('deg', 'shift', 'correct'), [
    (4.99, 4.99, True), (5.01, 0.0, False), (0.0, 5.01, False)])
def test_correct_is_below_both_limits(deg, shift, correct):
    errors = pair_errors(transform(deg=deg, shift=(shift, 0, 0)), np.eye(4), np.zeros(3), 1.0)
    assert errors.correct is correct


def line(first, last):
    return np.array([[x, 0.0, 0.0] for x in range(first, last)])


def test_overlap_of_lines_is_counted_point_by_point():
    # 0..9 and 6..15, radius 2: 4..9 of the first (6) and 6..11 of the second (6) of 20.
    found = overlap(cKDTree(line(0, 10)), cKDTree(line(6, 16)), np.eye(4), 2.0)
    assert found == 12 / 20


def test_overlap_counts_points_exactly_at_the_radius():
    found = overlap(cKDTree(line(0, 1)), cKDTree(line(2, 3)), np.eye(4), 2.0)
    assert found == 1.0


def test_overlap_is_taken_under_the_pose():
    T_j_i = transform((0, 0, 1), 90, (1, 2, 3))
    i = line(0, 10)
    j = i @ T_j_i[:3, :3].T + T_j_i[:3, 3]
    assert overlap(cKDTree(i), cKDTree(j), T_j_i, 1e-6) == 1.0
    assert overlap(cKDTree(i), cKDTree(j), np.eye(4), 1e-6) == 0.0


def test_overlap_equals_brute_force():
    rng = np.random.default_rng(3)
    i, j = rng.normal(size=(300, 3)), rng.normal(size=(200, 3)) + 0.7
    close = np.linalg.norm(i[:, None] - j[None], axis=2) <= 0.3
    truth = (close.any(1).sum() + close.any(0).sum()) / 500
    assert overlap(cKDTree(i), cKDTree(j), np.eye(4), 0.3) == truth
    assert 0.05 < truth < 0.95


def test_pairs_in_order_with_their_reference():
    views = {n: RangeView(n, line(0, 10)) for n in ('b', 'a', 'c')}
    poses = {'b': np.eye(4), 'a': transform(shift=(9, 0, 0)), 'c': transform(shift=(50, 0, 0))}
    pairs = evaluate_pairs(ReferenceSet('set', 'm', 'exact', views, poses, dres=1.0))
    assert [(p.name_i, p.name_j) for p in pairs] == [('b', 'a'), ('b', 'c'), ('a', 'c')]
    name_i, name_j, shared, T_j_i = pairs[0]
    # 7, 8, 9 of b near a's 9; by symmetry as many of a.
    assert (name_i, name_j, shared) == ('b', 'a', 6 / 20)
    np.testing.assert_allclose(T_j_i, transform(shift=(-9, 0, 0)))
    assert [p.evaluated for p in pairs] == [True, False, False]


def test_views_of_two_objects_share_nothing():
    views = {n: RangeView(n, line(0, 10)) for n in ('a', 'b')}
    poses = {n: np.eye(4) for n in views}
    mixed = ReferenceSet('set', 'm', 'exact', views, poses, 1.0, {'a': 'cat', 'b': 'dog'})
    pair, = evaluate_pairs(mixed)
    assert (pair.T_j_i, pair.overlap, pair.evaluated) == (None, 0.0, False)


@pytest.mark.parametrize(('value', 'key'), [
    (0.0999, None), (0.1, '0.1-0.3'), (0.2999, '0.1-0.3'), (0.3, '0.3-0.6'), (0.6, '0.6-1.0'),
    (1.0, '0.6-1.0')])
def test_overlap_bins_hold_their_lower_bound(value, key):
    assert overlap_bin(value) == key
