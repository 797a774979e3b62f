# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Frames and descriptors; truth: what a rigid motion, a unit or an order must not change."""

from hypothesis import given, settings, strategies
import numpy as np
import pytest
from reference.surfaces import bumpy_mesh, moved
from ros_rops.core.config import LrfConfig, RopsConfig
from ros_rops.core.rops import describe
from ros_rops.core.types import RangeMesh
from scipy.spatial.transform import Rotation

MESH = bumpy_mesh()
KEYPOINTS = np.arange(60, len(MESH.vertices), 173, dtype=np.int32)
ROPS = RopsConfig(radius_mr=8.3)
METHODS = strategies.sampled_from(['rops', 'toldi'])
SEEDS = strategies.integers(0, 2**32 - 1)


def found(mesh, method, keypoints=KEYPOINTS):
    return describe(mesh, keypoints, LrfConfig(method=method), ROPS)


@settings(max_examples=15, deadline=None)
@given(SEEDS, METHODS, strategies.sampled_from([1e-3, 1.0, 1e3]))
def test_rigid_motion_and_units(seed, method, scale):
    random = np.random.default_rng(seed)
    rotation = Rotation.random(random_state=seed).as_matrix()
    shifted = moved(MESH, rotation, random.normal(size=3) * 100 * scale, scale)
    before, after = found(MESH, method), found(shifted, method)
    assert np.allclose(after.lrfs, before.lrfs @ rotation.T, atol=1e-6)
    assert np.allclose(after.descriptors, before.descriptors, atol=1e-6)


@settings(max_examples=15, deadline=None)
@given(SEEDS, METHODS)
def test_order_of_vertices_and_faces(seed, method):
    random = np.random.default_rng(seed)
    order = random.permutation(len(MESH.vertices))
    place = np.argsort(order).astype(np.int32)
    shuffled = RangeMesh(
        MESH.vertices[order], random.permutation(place[MESH.faces]), MESH.normals[order],
        MESH.boundary[order], MESH.resolution)
    before, after = found(MESH, method), found(shuffled, method, place[KEYPOINTS])
    assert np.allclose(after.lrfs, before.lrfs, atol=1e-9)
    assert np.allclose(after.descriptors, before.descriptors, atol=1e-7)


@pytest.mark.parametrize('method', ['rops', 'toldi'])
def test_coordinates_around_a_million(method):
    far = found(moved(MESH, np.eye(3), np.array([1e6, -1e6, 2e6])), method)
    near = found(MESH, method)
    assert np.allclose(far.lrfs, near.lrfs, atol=1e-6)
    assert np.median(np.abs(far.descriptors - near.descriptors)) < 1e-6
