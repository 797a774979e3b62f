# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Matching, CCV and ICP; truth: what a rigid motion, a unit or an order must not change."""

from hypothesis import given, settings, strategies
import numpy as np
from reference.surfaces import bumpy_mesh
from ros_rops.core.ccv import ccv_transforms
from ros_rops.core.config import CcvConfig, IcpConfig, MatchingConfig
from ros_rops.core.icp import paper_icp, point_to_plane_icp
from ros_rops.core.matching import match, match_transforms
from ros_rops.core.se3 import fit_rigid, move, rigid
from ros_rops.core.types import Features
from scipy.spatial.transform import Rotation

MESH = bumpy_mesh()
SEEDS = strategies.integers(0, 2**32 - 1)
SCALES = strategies.sampled_from([1e-3, 1.0, 1e3])


def motion(random, size):
    turn = Rotation.from_quat(random.normal(size=4)).as_matrix()
    return rigid(turn, random.normal(size=3) * size)


def features(random, count):
    turns = Rotation.from_quat(random.normal(size=(count, 4))).as_matrix()
    return Features(
        np.arange(count, dtype=np.int32), random.normal(size=(count, 3)) * 30, turns,
        random.normal(size=(count, 9)).astype(np.float32))


def carried(one, by, scale=1.0):
    """Return the features of the view as `by` moves it, in other units."""
    return Features(
        one.indices, move(by, one.positions) * scale, one.lrfs @ by[:3, :3].T, one.descriptors)


def seen_from(transforms, source, target, scale=1.0):
    """Return what T_target_source becomes when both views are moved, in other units."""
    result = target @ transforms @ np.linalg.inv(source)
    result[..., :3, 3] *= scale
    return result


@settings(max_examples=25, deadline=None)
@given(SEEDS, SCALES)
def test_match_transforms_move_with_the_views(seed, scale):
    random = np.random.default_rng(seed)
    a, b = features(random, 20), features(random, 25)
    by_a, by_b = motion(random, 100), motion(random, 100)
    found = match(a, b, MatchingConfig())
    after = match_transforms(carried(a, by_a, scale), carried(b, by_b, scale), found)
    expected = seen_from(match_transforms(a, b, found), by_a, by_b, scale)
    assert np.allclose(after[:, :3, :3], expected[:, :3, :3], atol=1e-12)
    assert np.allclose(after[:, :3, 3], expected[:, :3, 3], atol=1e-9 * scale)


@settings(max_examples=25, deadline=None)
@given(SEEDS, SCALES)
def test_so3_groups_move_with_the_views(seed, scale):
    random = np.random.default_rng(seed)
    source, truth = random.normal(size=(40, 3)) * 20, motion(random, 50)
    shaken = Rotation.from_rotvec(random.normal(size=(40, 3)) * 0.1).as_matrix()
    transforms = truth @ rigid(shaken, random.normal(size=(40, 3)) * 4)
    target = np.einsum('mij,mj->mi', transforms[:, :3, :3], source) + transforms[:, :3, 3]
    centre = source.mean(axis=0)
    by_a, by_b = motion(random, 500), motion(random, 500)
    before = ccv_transforms(source, target, transforms, CcvConfig(), 1.0, centre)
    after = ccv_transforms(
        move(by_a, source) * scale, move(by_b, target) * scale,
        seen_from(transforms, by_a, by_b, scale), CcvConfig(), scale,
        move(by_a, centre[None])[0] * scale)
    assert after.support.tolist() == before.support.tolist()
    assert before.support.max() > 3
    expected = seen_from(before.transforms, by_a, by_b, scale)
    assert np.allclose(after.transforms[:, :3, 3], expected[:, :3, 3], atol=1e-7 * scale)
    assert np.allclose(after.transforms[:, :3, :3], expected[:, :3, :3], atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(SEEDS, strategies.sampled_from(['so3', 'euler']))
def test_groups_do_not_depend_on_the_order(seed, metric):
    random = np.random.default_rng(seed)
    source = random.normal(size=(50, 3)) * 20
    shaken = Rotation.from_rotvec(random.normal(size=(50, 3)) * 0.1).as_matrix()
    transforms = rigid(shaken, random.normal(size=(50, 3)) * 4)
    target = np.einsum('mij,mj->mi', transforms[:, :3, :3], source) + transforms[:, :3, 3]
    order = random.permutation(50)
    config, centre = CcvConfig(metric=metric), source.mean(axis=0)
    before = ccv_transforms(source, target, transforms, config, 1.0, centre)
    after = ccv_transforms(
        source[order], target[order], transforms[order], config, 1.0, centre)
    assert after.support.tolist() == before.support[order].tolist()
    assert np.allclose(after.transforms, before.transforms[order], atol=1e-9)


@settings(max_examples=10, deadline=None)
@given(SEEDS, SCALES, strategies.booleans())
def test_icp_recovers_any_motion_in_any_units(seed, scale, planes):
    random = np.random.default_rng(seed)
    truth = motion(random, 300)
    source, unit = MESH.vertices * scale, MESH.resolution * scale
    truth[:3, 3] *= scale
    target, normals = move(truth, source), MESH.normals @ truth[:3, :3].T
    about = source.mean(axis=0)
    turn = Rotation.from_rotvec(random.uniform(-0.01, 0.01, 3)).as_matrix()
    start = truth @ rigid(turn, about - turn @ about + random.uniform(-0.4, 0.4, 3) * unit)
    config = IcpConfig(n_min=300, n_max=1500)
    found = (
        point_to_plane_icp(source, target, normals, start, unit, config) if planes else
        paper_icp(source, target, start, unit, config))
    assert found.converged
    assert np.abs(move(found.T_target_source, source) - target).max() < 1e-4 * unit


@settings(max_examples=25, deadline=None)
@given(SEEDS, strategies.integers(3, 30))
def test_fit_is_exact_and_never_a_reflection(seed, count):
    random = np.random.default_rng(seed)
    truth, points = motion(random, 10), random.normal(size=(count, 3))
    for noise in (0.0, 3.0):
        there = move(truth, points) + noise * random.normal(size=(count, 3))
        found, determined = fit_rigid(
            np.array([float(count)]), points.sum(axis=0)[None], there.sum(axis=0)[None],
            (there.T @ points)[None])
        assert determined[0]
        assert np.isclose(np.linalg.det(found[0, :3, :3]), 1.0)
        if not noise:
            assert np.allclose(found[0], truth, atol=1e-7)
