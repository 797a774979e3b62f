# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Truth: planes and spheres whose distances are known, and the published poses of the bunny."""

import numpy as np
import pytest
from ros_rops.bench.residual import pair_residuals, residual
from ros_rops.core.errors import ShapeError


def grid(n=40):
    """Return a flat grid of spacing 1."""
    x, y = np.meshgrid(np.arange(n, dtype=float), np.arange(n, dtype=float))
    return np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)


def shift(x, y, z):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def test_distance_between_planes_is_measured_along_the_normal_in_dres():
    plane = grid()
    value = residual([plane, plane], [np.eye(4), shift(0.3, 0.2, 0.5)], 2.0)
    assert value == pytest.approx(0.25, abs=1e-9)


def test_pairs_with_little_overlap_do_not_count():
    plane = grid()
    poses = [np.eye(4), shift(0, 0, 0.1), shift(30, 0, 0.3)]
    pairs = pair_residuals([plane, plane, plane], poses, 1.0)
    assert set(pairs) == {(0, 1), (1, 0)}


def test_nothing_to_measure_is_nan():
    assert np.isnan(residual([grid(), grid()], [np.eye(4), shift(0, 0, 99)], 1.0))
    assert np.isnan(residual([grid()], [np.eye(4)], 1.0))
    assert np.isnan(residual([grid(), np.zeros((0, 3))], [np.eye(4)] * 2, 1.0))


def test_common_frame_is_free():
    rng = np.random.default_rng(3)
    sphere = rng.normal(size=(4000, 3))
    sphere *= 20 / np.linalg.norm(sphere, axis=1, keepdims=True)
    poses = [np.eye(4), shift(0.2, 0.1, 0.3)]
    turn = np.eye(4)
    turn[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn[:3, 3] = 5, 6, 7
    first = residual([sphere, sphere], poses, 1.0)
    second = residual([sphere, sphere], [turn @ pose for pose in poses], 1.0)
    assert first == pytest.approx(second, rel=1e-9)
    # The mean of |d . n| over a sphere is |d| / 2.
    assert first == pytest.approx(np.sqrt(0.14) / 2, rel=0.05)


@pytest.mark.parametrize(('poses', 'dres'), [
    ([np.eye(4)], 1.0), ([np.eye(4), np.eye(3)], 1.0), ([np.eye(4)] * 2, 0.0),
    ([np.eye(4)] * 2, float('nan')),
])
def test_bad_arguments_are_named(poses, dres):
    with pytest.raises(ShapeError, match='poses|dres'):
        residual([grid(4), grid(4)], poses, dres)
