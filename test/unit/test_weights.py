# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How far points are trusted. Truth: a plane seen by a pinhole (analytic)."""

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.modelling.posed import pose_views
from ros_rops.modelling.weights import RAMP_MR


def plane(distance, tilt_deg=0.0, kind='pinhole'):
    """Return a view of a square plane of 41 x 41 points, 1 apart, and its grid."""
    side = np.arange(-20.0, 21.0)
    x, y = (a.ravel() for a in np.meshgrid(side, side))
    z = distance + np.tan(np.deg2rad(tilt_deg)) * x
    grid = np.arange(41 * 41, dtype=np.int32).reshape(41, 41)
    return RangeView('v', np.stack([x, y, z], axis=1), grid, SensorModel(kind))


def weights_of(*views):
    named = {str(k): view for k, view in enumerate(views)}
    numbers = {name: k for k, name in enumerate(named)}
    posed = pose_views([(name, np.eye(4)) for name in named], named, numbers, Config())
    return [one.weights.reshape(41, 41) for one in posed]


def test_half_as_far_weighs_four_times_as_much():
    near, far = weights_of(plane(1000.0), plane(2000.0))
    np.testing.assert_allclose(near[20, 20] / far[20, 20], 4.0, rtol=1e-3)
    assert 0.99 < near[20, 20] <= 1.0


def test_weight_falls_with_the_angle():
    flat, steep = weights_of(plane(1000.0, kind='orthographic'),
                             plane(1000.0, 60.0, kind='orthographic'))
    np.testing.assert_allclose(steep[20, 20] / flat[20, 20], 0.5, rtol=1e-3)


def test_weight_rises_from_the_border():
    [weights] = weights_of(plane(1000.0, kind='orthographic'))
    row = weights[20, :8]
    assert row[0] < 0.01 and (np.diff(row[:int(RAMP_MR)]) > 0.2).all()
    np.testing.assert_allclose(row[5:], 1.0, rtol=1e-3)


def test_points_without_a_face_weigh_nothing():
    view = plane(1000.0, kind='orthographic')
    points = view.points.copy()
    points[0] = (-20, -20, 500.0)
    [weights] = weights_of(RangeView('v', points, view.grid, view.sensor))
    assert weights[0, 0] == 0 and (weights.ravel()[1:] > 0).all()
