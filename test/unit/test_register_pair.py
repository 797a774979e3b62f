# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The public face: names at the top, two views to one answer.

Truth: exact poses of the synthetic captures.
"""

from dataclasses import replace

import numpy as np
import pytest
import ros_rops
from ros_rops.core.errors import ViewError
from ros_rops.recordings.procedural import blob, mesh_of
from ros_rops.recordings.synthetic import Model, synthetic_views


def test_every_public_name_is_there() -> None:
    assert all(getattr(ros_rops, name) is not None for name in ros_rops.__all__)
    with pytest.raises(AttributeError, match='nothing'):
        _ = ros_rops.nothing


def test_two_views_in_different_units() -> None:
    model = Model(*mesh_of(blob(), 0.003), name='blob', units='m')
    a, *others = synthetic_views(model, count=24, seed=3, pixels=160)
    b = max(others, key=lambda one: one.T_world_view[:3, 2] @ a.T_world_view[:3, 2])
    exact = np.linalg.inv(b.T_world_view) @ a.T_world_view
    scaled = replace(
        a.view, points=a.view.points * 1000.0, units='mm',
        sensor=replace(a.view.sensor, origin=tuple(1000.0 * x for x in a.view.sensor.origin)))
    result = ros_rops.register_pair(scaled, b.view)
    assert result.status is ros_rops.Status.PLACED, result.reason
    # A twentieth of a degree over an object of 0.1 m is a tenth of a millimetre.
    np.testing.assert_allclose(result.T_target_source, exact, atol=5e-3)


def test_an_empty_view_is_the_callers_error() -> None:
    empty = ros_rops.RangeView('empty', np.empty((0, 3)))
    with pytest.raises(ViewError, match='empty'):
        ros_rops.register_pair(empty, empty)
