# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A real depth camera before a turntable. Truth: the stickers on it (`reference.bear`)."""

import itertools

import numpy as np
import pytest
from reference import bear
from ros_rops.core.types import Status
from scipy.spatial.transform import Rotation


@pytest.mark.parametrize('prior', ['prior__plane', 'prior__axis'])
def test_with_a_prior_every_view_finds_its_place(prior):
    session, names = bear.register(**{prior: True})
    assert [report.status for report in session.reports] == [Status.PLACED] * 8
    placed, = bear.poses(session, names)
    up = bear.normal(session, names)
    turns = [bear.motion(placed, a, b) for a, b in bear.RING]
    assert np.abs(np.array([turn for turn, _ in turns]) - bear.STEPS).max() < 2.0
    assert sum(turn for turn, _ in turns) == pytest.approx(360.0, abs=2.0)
    common = np.mean([axis for _, axis in turns], axis=0)
    lean = np.degrees(np.arccos(abs(common @ up) / np.linalg.norm(common)))
    assert lean < 1.0
    residuals = [bear.residual_mm(session, names, placed, a, b) for a, b in bear.RING]
    assert np.median(residuals) < 0.7
    assert session.station['plane' if prior == 'prior__plane' else 'axis_found']


@pytest.mark.parametrize('order', [range(8), [6, 7, 2, 1, 4, 5, 3, 0], [1, 2, 0, 7, 4, 5, 3, 6]])
def test_without_a_prior_the_bear_is_not_folded(order):
    session, names = bear.register(order)
    objects = bear.poses(session, names)
    up = bear.normal(session, names)
    for group in ((2, 3, 4), (0, 5, 6, 7)):
        placed, = (one for one in objects if group[0] in one)
        for a, b in itertools.combinations(group, 2):
            found = Rotation.from_matrix((np.linalg.inv(placed[b]) @ placed[a])[:3, :3])
            wrong = bear.true_turn(a, b, up).inv() * found
            assert np.degrees(wrong.magnitude()) < 3.0
    # A flank laid on the other, as by the false match of 3 and 7, is off by far more.
    for placed in objects:
        for a, b in itertools.combinations(sorted(placed), 2):
            found = Rotation.from_matrix((np.linalg.inv(placed[b]) @ placed[a])[:3, :3])
            wrong = bear.true_turn(a, b, up).inv() * found
            assert np.degrees(wrong.magnitude()) < 6.0
    assert session.station == {}


def test_a_fold_is_found_and_mended():
    # Sampled this coarsely, and in this order, the flanks are taken for each other at first.
    session, names = bear.register([6, 7, 2, 1, 4, 5, 3, 0], mesh__depth_steps=2.0)
    up = bear.normal(session, names)
    for placed in bear.poses(session, names):
        for a, b in itertools.combinations(sorted(placed), 2):
            found = Rotation.from_matrix((np.linalg.inv(placed[b]) @ placed[a])[:3, :3])
            assert np.degrees((bear.true_turn(a, b, up).inv() * found).magnitude()) < 6.0
