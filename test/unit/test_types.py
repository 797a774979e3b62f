# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Range views. Truth: the shapes that the docstrings state."""

import numpy as np
import pytest

from ros_rops.core.errors import ShapeError
from ros_rops.core.types import RangeView, SensorModel

POINTS = np.arange(12.0).reshape(4, 3)


@pytest.mark.parametrize(('arrays', 'message'), [
    ({'points': POINTS[:, :2]}, r"points of 'view': expected \(N, 3\), got \(4, 2\)"),
    ({'points': POINTS.ravel()}, 'expected'),
    ({'points': np.where(POINTS > 10, np.nan, POINTS)}, 'not finite'),
    ({'points': np.where(POINTS > 10, np.inf, POINTS)}, 'not finite'),
    ({'points': POINTS, 'grid': np.array([[0, 4]])}, 'indices < 4'),
    ({'points': POINTS, 'grid': np.array([0, 1])}, r'expected \(H, W\)'),
    ({'points': POINTS, 'colors': np.zeros((3, 3), np.uint8)}, 'colors'),
])
def test_wrong_arrays_are_named(arrays, message):
    with pytest.raises(ShapeError, match=message):
        RangeView('view', **arrays)


def test_arrays_are_read_only_and_the_callers_are_not_touched():
    points = POINTS.copy()
    view = RangeView('view', points, np.array([[0, -1], [2, 3]]), colors=np.zeros((4, 3), int))
    for array in (view.points, view.grid, view.colors):
        with pytest.raises(ValueError, match='read-only'):
            array[0, 0] = 1
    points[0, 0] = 5
    assert (view.points.dtype, view.grid.dtype, view.colors.dtype) == (
        np.float64, np.int32, np.uint8)


def test_rays_point_to_the_sensor():
    pinhole = SensorModel('pinhole', origin=(0.0, 0.0, 0.0)).to_sensor(np.array([[0, 0, 2.0]]))
    np.testing.assert_allclose(pinhole, [[0, 0, -1]])
    flat = SensorModel('orthographic', direction=(1.0, 0.0, 0.0)).to_sensor(POINTS)
    np.testing.assert_allclose(flat, np.tile([-1.0, 0, 0], (4, 1)))
