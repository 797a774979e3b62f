# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How far views lie apart. Truth: a plate of which each view saw one side (analytic)."""

import numpy as np
import pytest
from ros_rops.core.config import Config
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.modelling.agreement import spread_of
from ros_rops.modelling.posed import pose_views

TURNED = np.diag([1.0, -1.0, -1.0, 1.0])


def plate(name, lift=0.0):
    """Return a view of a square of 41 x 41 points, 1 apart, from above, `lift` off its place."""
    side = np.arange(-20.0, 21.0)
    x, y = (a.ravel() for a in np.meshgrid(side, side))
    grid = np.arange(41 * 41, dtype=np.int32).reshape(41, 41)
    sensor = SensorModel('orthographic', direction=(0.0, 0.0, -1.0))
    return RangeView(name, np.stack([x, y, 0 * x + 1.5 + lift], axis=1), grid, sensor)


def posed(front, back):
    """Return views of a plate 3 thick: from above with the lifts `front`, from below `back`."""
    views = {str(k): plate(str(k), lift) for k, lift in enumerate([*front, *back])}
    turns = [np.eye(4)] * len(front) + [TURNED] * len(back)
    return pose_views(
        zip(views, turns, strict=True), views, {name: int(name) for name in views}, Config())


def test_two_sides_of_a_plate_are_not_two_measurements_of_one():
    assert spread_of(posed([0.0], [0.0]), 1.0) == 0.0
    assert spread_of(posed([0.0, 0.0], [0.0, 0.0, 0.0]), 1.0) < 1e-6


def test_views_of_one_side_tell_how_far_apart_they_are():
    # All gaps are 0.4: the standard deviation of which 0.4 is the median difference.
    want = 0.4 * 1.4826 / np.sqrt(2)
    assert spread_of(posed([-0.2, 0.2], [0.2, -0.2]), 1.0) == pytest.approx(want, rel=1e-3)
    assert spread_of(posed([0.0], []), 1.0) == 0.0
