# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Counting inliers of many poses; truth: SciPy's tree, and cases by hand."""

import numpy as np
import pytest
from reference.inliers_twin import count_near as twin
from ros_rops.core.errors import ParameterError, ShapeError
from ros_rops.core.se3 import rigid
from ros_rops.kernels.inliers import count_near
from scipy.spatial.transform import Rotation


def poses(count, size, seed):
    shifts = np.random.default_rng(seed).normal(0.0, size, (count, 3))
    return rigid(Rotation.random(count, random_state=seed).as_matrix(), shifts)


@pytest.mark.parametrize('radius', [1e-3, 0.02, 0.3, 5.0])
@pytest.mark.parametrize('far', [0.0, 1000.0])
def test_counts_are_the_trees_for_any_threads(radius, far):
    random = np.random.default_rng(1)
    target = random.normal(size=(600, 3)) * [1.0, 0.3, 2.0] + far
    source = target[:200] + random.normal(0.0, 0.7 * radius, (200, 3))
    many = np.concatenate([np.eye(4)[None], rigid(np.eye(3)[None], np.full((1, 3), 0.3 * radius)),
                           poses(40, 0.5, 2)])
    counts = count_near(source, target, many, radius, threads=1)
    assert counts.tolist() == twin(source, target, many, radius).tolist()
    assert counts.max() > counts.min()
    assert np.array_equal(counts, count_near(source, target, many, radius, threads=3))


def test_a_wide_target_with_a_small_radius_gets_larger_cells():
    target = np.array([[0.0, 0, 0], [5000.0, 4000, 3000], [1.0, 1, 1]])
    source = target + np.array([0.0, 0.0, 0.9e-3])
    assert count_near(source, target, np.eye(4)[None], 1e-3).tolist() == [3]
    assert count_near(source, target, np.eye(4)[None], 0.8e-3).tolist() == [0]


def test_exactly_the_radius_away_is_outside():
    source, target = np.array([[0.5, 0, 0], [0.0, 0, 0]]), np.array([[0.0, 0, 0]])
    assert count_near(source, target, np.eye(4)[None], 0.5).tolist() == [1]
    assert count_near(source, target, np.eye(4)[None], np.nextafter(0.5, 1)).tolist() == [2]


def test_poses_that_are_not_finite_have_no_inlier():
    points = np.zeros((2, 3))
    bad = np.full((3, 4, 4), [[[np.nan]], [[np.inf]], [[1e300]]])
    assert count_near(points + 1, points, bad, 1.0).tolist() == [0, 0, 0]


def test_what_does_not_fit_is_named():
    good = np.zeros((2, 3))
    for source, target, name in (
            (np.zeros((2, 2)), good, 'source'), (good, np.zeros(3), 'target'),
            (good, np.full((1, 3), np.nan), 'target')):
        with pytest.raises(ShapeError, match=name):
            count_near(source, target, np.eye(4)[None], 1.0)
    with pytest.raises(ShapeError, match='transforms'):
        count_near(good, good, np.eye(4), 1.0)
    for radius in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ParameterError, match='radius'):
            count_near(good, good, np.eye(4)[None], radius)
