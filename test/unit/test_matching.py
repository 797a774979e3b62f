# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Matching; truth: every distance in float64, and motions known beforehand."""

import numpy as np
import pytest
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


def nearest(distance, k):
    """All (row, column) where the column is among the k nearest, ties to the lower index."""
    order = np.argsort(distance, axis=1, kind='stable')[:, :k]
    return {(i, int(j)) for i, row in enumerate(order) for j in row}


@pytest.mark.parametrize('k', [1, 5])
@pytest.mark.parametrize('both', [False, True])
def test_equals_brute_force(k, both, monkeypatch):
    monkeypatch.setattr('ros_rops.core.matching._BLOCK', 1000)  # several blocks
    random = np.random.default_rng(3)
    # A common part a thousand times as large as the differences: float32 alone would fail.
    a, b = (features(1.0 + 1e-3 * random.normal(size=(n, 20))) for n in (150, 130))
    found = match(a, b, MatchingConfig(neighbours=k, both_directions=both))
    distance = cdist(a.descriptors.astype(float), b.descriptors.astype(float))
    expected = nearest(distance, k)
    if both:
        expected |= {(i, j) for j, i in nearest(distance.T, k)}
    assert len(found) == len(expected)
    assert {(i, j) for i, j in pairs(found)} == expected
    assert np.allclose(found.distance, distance[found.source, found.target], rtol=1e-6)
    assert (np.diff(found.distance) >= 0).all()


def test_differences_below_the_rounding_of_the_product():
    random = np.random.default_rng(6)
    # Two groups far apart: no common part to take away.
    a, b = (
        features(random.choice([-1, 1], (n, 1)) + 1e-4 * random.normal(size=(n, 20)))
        for n in (90, 400))
    distance = cdist(a.descriptors.astype(float), b.descriptors.astype(float))
    assert set(pairs(match(a, b, PAPER))) == nearest(distance, 1)


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
    assert set(pairs(found)) == nearest(cdist(a.descriptors, b.descriptors), 4)


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
