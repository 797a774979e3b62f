# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Quality of matches. Truth: analytic (features copied, exchanged and moved by hand)."""

import numpy as np
import pytest
from reference.bench_sets import random_pose
from ros_rops.bench.feature_quality import (
    area_under_precision_recall, joined, match, Matches, quality)
from ros_rops.core.types import Features


def features(positions, descriptors):
    count = len(positions)
    return Features(
        np.arange(count, dtype=np.int32), np.asarray(positions, float),
        np.broadcast_to(np.eye(3), (count, 3, 3)), np.asarray(descriptors, np.float32))


def line(count):
    return np.array([[10.0 * k, 0.0, 0.0] for k in range(count)])


def matches_of(order, T, shift=0.0):
    """Match five features with copies moved by `T`, whose descriptors are taken in `order`."""
    positions, descriptors = line(5), np.eye(5)
    moved = (positions + np.array([shift, 0.0, 0.0])) @ T[:3, :3].T + T[:3, 3]
    return match(features(positions, descriptors), features(moved, descriptors[order]), T, 1.0)


def test_copies_are_all_right():
    found = quality(matches_of([0, 1, 2, 3, 4], random_pose(np.random.default_rng(1))))
    assert (found['keypoints'], found['possible'], found['right']) == (5, 5, 5)
    assert (found['right_of_all'], found['area_under_precision_recall']) == (1.0, 1.0)


def test_exchanged_descriptors_are_wrong():
    found = quality(matches_of([1, 0, 2, 3, 4], np.eye(4)))
    assert (found['possible'], found['right']) == (5, 3)
    assert found['right_of_possible'] == pytest.approx(0.6)


@pytest.mark.parametrize(('shift', 'right'), [(2.9, 5), (3.1, 0)])
def test_right_is_within_3_dres(shift, right):
    found = quality(matches_of([0, 1, 2, 3, 4], np.eye(4), shift))
    assert (found['right'], found['possible']) == (right, right)


def test_area_of_a_known_order():
    # Right, wrong, right by rising ratio, two possible: (1/1 + 2/3) / 2.
    matches = Matches(
        np.array([True, True, False]), np.array([True, True, False]), np.array([0.9, 0.1, 0.5]))
    assert area_under_precision_recall(matches) == pytest.approx((1 + 2 / 3) / 2)


def test_nothing_possible_has_no_shares():
    found = quality(joined([]))
    assert found['keypoints'] == 0
    for name in ('right_of_all', 'right_of_possible', 'area_under_precision_recall'):
        assert found[name] is None
