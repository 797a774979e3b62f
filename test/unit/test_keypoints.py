# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Feature points; truth: the definition, checked by brute force."""

import numpy as np
import pytest
from reference.surfaces import bumpy_mesh, height_view
from ros_rops.core.config import KeypointConfig, MeshConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.keypoints import candidate_keypoints, detect_keypoints
from ros_rops.core.mesh import build_mesh
from ros_rops.core.types import RangeMesh
from ros_rops.kernels.features import thin
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist, pdist


@pytest.fixture(scope='module')
def mesh():
    return bumpy_mesh()


@pytest.mark.parametrize('method', ['uniform', 'paper'])
def test_spacing_and_margin_hold(mesh, method):
    config = KeypointConfig(method=method, spacing_mr=2.5, boundary_mr=4.0)
    found = candidate_keypoints(mesh, config)
    points = mesh.vertices[found]
    assert len(found) > 30
    assert (np.diff(found) > 0).all()
    assert pdist(points).min() >= 2.5 * mesh.resolution
    assert cdist(points, mesh.vertices[mesh.boundary]).min() > 4.0 * mesh.resolution


def test_uniform_leaves_no_gap(mesh):
    found = candidate_keypoints(mesh, KeypointConfig(boundary_mr=0.0))
    inner = mesh.vertices[~mesh.boundary]
    distance, _ = cKDTree(mesh.vertices[found]).query(inner)
    assert distance.max() < 3.0 * mesh.resolution


def test_paper_candidates_are_near_the_simplified_mesh(mesh):
    config = KeypointConfig(method='paper', spacing_mr=0.5, cluster_mr=3.0, boundary_mr=0.0)
    uniform = KeypointConfig(spacing_mr=0.5, boundary_mr=0.0)
    cells = np.unique(np.floor(
        (mesh.vertices - mesh.vertices.min(axis=0)) / (3.0 * mesh.resolution)), axis=0)
    found = candidate_keypoints(mesh, config)
    assert 0.3 * len(cells) < len(found) <= len(cells)
    assert len(found) < 0.5 * len(candidate_keypoints(mesh, uniform))


def test_no_more_than_most(mesh):
    every = candidate_keypoints(mesh, KeypointConfig(spacing_mr=1.0))
    few = candidate_keypoints(mesh, KeypointConfig(spacing_mr=1.0, most=60))
    assert len(every) > 300
    assert 30 < len(few) <= 60


def test_ratio_test_uses_the_support():
    mesh = build_mesh(height_view(lambda x, y: 0 * x, (60, 60)), MeshConfig())
    wide = KeypointConfig(boundary_mr=16.0)
    strict = KeypointConfig(boundary_mr=16.0, eigen_ratio=1.05)
    radius = 15 * mesh.resolution
    assert len(detect_keypoints(mesh, wide, radius)) > 20
    assert len(detect_keypoints(mesh, strict, radius)) == 0


def test_closed_mesh_has_no_margin(mesh):
    closed = RangeMesh(mesh.vertices, mesh.faces, mesh.normals,
                       np.zeros(len(mesh.vertices), bool), mesh.resolution)
    assert len(candidate_keypoints(closed, KeypointConfig())) > len(
        candidate_keypoints(mesh, KeypointConfig()))


def test_thinning_prefers_the_earlier():
    points = np.array([[0, 0, 0], [0.5, 0, 0], [1.2, 0, 0], [0, 0, 0]])
    assert thin(points, np.array([1, 0, 2, 3], np.int32), 1.0).tolist() == [1]
    assert thin(points, np.array([0, 1, 2, 3], np.int32), 1.0).tolist() == [0, 2]


def test_thinning_equals_brute_force():
    points = np.random.default_rng(1).normal(size=(400, 3))
    kept = []
    for i in range(400):
        if not kept or cdist(points[[i]], points[kept]).min() >= 0.4:
            kept.append(i)
    assert thin(points, np.arange(400, dtype=np.int32), 0.4).tolist() == kept


def test_thinning_survives_outliers_and_nothing():
    points = np.array([[0, 0, 0], [1e9, 0, 0], [1e-3, 0, 0], [1e9, 1, 0]])
    every = np.arange(4, dtype=np.int32)
    assert thin(points, every, 0.5).tolist() == [0, 1, 3]
    assert thin(points, every[:0], 0.5).tolist() == []


def test_thinning_checks_its_arguments():
    points = np.zeros((4, 3))
    with pytest.raises(ShapeError, match='points'):
        thin(points[:, :2], np.zeros(1, np.int32), 1.0)
    with pytest.raises(ShapeError, match='candidates: expected'):
        thin(points, np.zeros((1, 1), np.int32), 1.0)
    with pytest.raises(ShapeError, match='candidates: indices'):
        thin(points, np.array([4], np.int32), 1.0)
    with pytest.raises(ShapeError, match='spacing'):
        thin(points, np.zeros(1, np.int32), 0.0)
