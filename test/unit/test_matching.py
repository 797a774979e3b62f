# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Matching; truth: the twin in whole numbers, float64, and motions known beforehand."""

import math

import numpy as np
import pytest
from reference import matching_twin
from reference.surfaces import bumpy_mesh, moved
from ros_rops.core.config import Config, MatchingConfig
from ros_rops.core.errors import ParameterError, ShapeError
from ros_rops.core.matching import match, match_transforms
from ros_rops.core.rops import compute_features
from ros_rops.core.se3 import rigid
from ros_rops.core.types import Features
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

PAPER = MatchingConfig(neighbours=1, both_directions=False)


def features(descriptors):
    count = len(descriptors)
    return Features(
        np.arange(count, dtype=np.int32), np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1)),
        np.asarray(descriptors, dtype=np.float32))


def pairs(found):
    return list(zip(found.source.tolist(), found.target.tolist(), strict=True))


@pytest.mark.parametrize('k', [1, 5])
@pytest.mark.parametrize('both', [False, True])
def test_equals_the_twin_in_whole_numbers(k, both):
    random = np.random.default_rng(3)
    # A common part a thousand times as large as the differences: float32 products would fail.
    a, b = (features(1.0 + 1e-3 * random.normal(size=(n, 20))) for n in (150, 130))
    found = match(a, b, MatchingConfig(neighbours=k, both_directions=both))
    whole_a, whole_b, step = matching_twin.quantised(a.descriptors, b.descriptors)
    expected, squared = matching_twin.matches(whole_a, whole_b, k, both, 10 ** 6)
    assert pairs(found) == expected
    assert np.allclose(found.distance, np.sqrt(squared) * step, rtol=1e-6)


@pytest.mark.parametrize('spread', [1e-3, 1.0])
def test_agrees_with_float64_up_to_the_step(spread):
    random = np.random.default_rng(7)
    length = 135
    a, b = (features(random.normal(0.3, spread, (n, length))) for n in (80, 120))
    nearest = match(a, b, PAPER)
    distance = cdist(a.descriptors.astype(float), b.descriptors.astype(float))
    _, _, step = matching_twin.quantised(a.descriptors, b.descriptors)
    # Every entry of a difference is off by at most one step.
    worst = step * math.sqrt(length)
    assert (np.abs(nearest.distance - distance[nearest.source, nearest.target]) <= worst).all()
    chosen = np.empty(len(a.indices))
    chosen[nearest.source] = distance[nearest.source, nearest.target]
    assert (chosen - distance.min(axis=1) <= 2 * worst).all()
    if spread == 1.0:  # the differences are far above the step: the very same matches
        assert dict(pairs(nearest)) == dict(enumerate(distance.argmin(axis=1).tolist()))


def test_most_takes_nearest_neighbours_first_then_by_distance():
    random = np.random.default_rng(8)
    a, b = features(random.normal(size=(40, 12))), features(random.normal(size=(60, 12)))
    whole = matching_twin.quantised(a.descriptors, b.descriptors)[:2]
    every = match(a, b, MatchingConfig(neighbours=3))
    for most in (10, 50, 110, len(every)):
        found = match(a, b, MatchingConfig(neighbours=3, most=most))
        assert pairs(found) == matching_twin.matches(*whole, 3, True, most)[0]
        assert len(found) == most
    assert match(a, b, MatchingConfig(neighbours=3, most=len(every) + 5)).source.tobytes() == (
        every.source.tobytes())


def test_threads_change_no_byte():
    random = np.random.default_rng(9)
    a, b = features(random.normal(size=(90, 135))), features(random.normal(size=(70, 135)))
    one, two, again = (match(a, b, MatchingConfig(), threads=n) for n in (1, 2, 1))
    for name in ('source', 'target', 'distance'):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()
        assert getattr(one, name).tobytes() == getattr(again, name).tobytes()


def test_both_directions_is_symmetric():
    random = np.random.default_rng(4)
    a, b = features(random.normal(size=(40, 12))), features(random.normal(size=(60, 12)))
    there, back = match(a, b, MatchingConfig()), match(b, a, MatchingConfig())
    assert sorted(pairs(there)) == sorted((j, i) for i, j in pairs(back))


@pytest.mark.parametrize('value', [0.0, 1 / 135])
def test_equal_descriptors_go_to_the_lower_index(value):
    a, b = features(np.full((30, 135), value)), features(np.full((400, 135), value))
    found = match(a, b, MatchingConfig(neighbours=2, both_directions=False))
    assert pairs(found) == [(i, j) for i in range(30) for j in (0, 1)]
    assert not found.distance.any()


def test_few_different_descriptors_equal_brute_force():
    random = np.random.default_rng(5)
    kinds = random.normal(size=(3, 7)).astype(np.float32)
    a, b = (features(kinds[random.integers(3, size=size)]) for size in (50, 300))
    found = match(a, b, MatchingConfig(neighbours=4, both_directions=False))
    ranked = matching_twin.nearest(cdist(a.descriptors, b.descriptors), 4)
    assert set(pairs(found)) == {(i, int(j)) for i, row in enumerate(ranked) for j in row}


@pytest.mark.parametrize('shape', [(0, 5), (5, 0), (0, 0)])
def test_no_features_no_matches(shape):
    a, b = (features(np.ones((n, 135))) for n in shape)
    found = match(a, b, MatchingConfig())
    assert len(found) == 0
    assert match_transforms(a, b, found).shape == (0, 4, 4)


def test_one_feature_each():
    assert pairs(match(features([[1, 2]]), features([[3, 4]]), MatchingConfig())) == [(0, 0)]


def test_descriptors_that_do_not_fit():
    with pytest.raises(ShapeError, match='descriptors'):
        match(features(np.ones((3, 4))), features(np.ones((3, 5))), MatchingConfig())


@pytest.mark.parametrize('change', [{'neighbours': 0}, {'both_directions': 1}])
def test_wrong_parameters(change):
    with pytest.raises(ParameterError, match=next(iter(change))):
        MatchingConfig(**change)


def test_a_moved_mesh_gives_its_motion():
    mesh = bumpy_mesh()
    motion = rigid(Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(), np.array([30.0, -8, 5]))
    config = Config.from_flat({'rops.radius_mr': 8.0})
    source = compute_features(mesh, config)
    target = compute_features(moved(mesh, motion[:3, :3], motion[:3, 3]), config)
    found = match(source, target, PAPER)
    assert len(found) == len(source.indices) > 30
    assert (source.indices[found.source] == target.indices[found.target]).mean() > 0.99
    right = source.indices[found.source] == target.indices[found.target]
    assert np.allclose(match_transforms(source, target, found)[right], motion, atol=1e-6)
