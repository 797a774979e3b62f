# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Local reference frames; truth: analytic surfaces and the NumPy twin."""

import numpy as np
import pytest
from reference.features_twin import frame, toldi_frame
from reference.surfaces import bumpy_mesh, height_view
from ros_rops.core.config import LrfConfig, MeshConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.lrf import compute_lrfs
from ros_rops.core.mesh import build_mesh
from ros_rops.core.types import RangeMesh
from ros_rops.kernels.features import features

RADIUS = 9.3


@pytest.fixture(scope='module')
def mesh():
    return bumpy_mesh()


@pytest.fixture(scope='module')
def keypoints(mesh):
    return np.arange(0, len(mesh.vertices), 97, dtype=np.int32)  # the rim included


@pytest.mark.parametrize('triangles', ['author', 'pcl'])
def test_equals_the_twin(mesh, keypoints, triangles):
    config = LrfConfig(method='rops', triangles=triangles)
    lrfs, values = compute_lrfs(mesh, keypoints, config, RADIUS)
    for k, vertex in enumerate(keypoints):
        expected, eigenvalues = frame(
            mesh.vertices, mesh.faces, mesh.vertices[vertex], RADIUS, triangles == 'pcl')
        assert np.allclose(lrfs[k], expected, atol=1e-7)
        assert np.allclose(values[k], eigenvalues, rtol=1e-9)


def test_toldi_equals_the_twin(mesh, keypoints):
    config = LrfConfig(method='toldi', normal_radius_mr=3.0)
    lrfs, _ = compute_lrfs(mesh, keypoints, config, RADIUS)
    for k, vertex in enumerate(keypoints):
        expected = toldi_frame(
            mesh.vertices, mesh.vertices[vertex], mesh.normals[vertex], RADIUS,
            3.0 * mesh.resolution)
        assert np.allclose(lrfs[k], expected, atol=1e-7)


@pytest.mark.parametrize('method', ['rops', 'toldi'])
def test_frames_are_rotations(mesh, keypoints, method):
    lrfs, _ = compute_lrfs(mesh, keypoints, LrfConfig(method=method), RADIUS)
    assert np.allclose(lrfs @ lrfs.transpose(0, 2, 1), np.eye(3), atol=1e-12)
    assert np.allclose(np.linalg.det(lrfs), 1.0)


def test_ridge_lies_along_x_and_rises_along_z():
    # A strip along x, longer on the right, with its edges bent down: heavier to +x and to -z.
    view = height_view(lambda x, y: -0.05 * (y - 4) ** 2, (9, 40))
    mesh = build_mesh(view, MeshConfig())
    middle = np.array([4 * 40 + 15], np.int32)
    lrfs, values = compute_lrfs(mesh, middle, LrfConfig(method='rops'), 22.0)
    assert np.allclose(lrfs[0], [[1, 0, 0], [0, -1, 0], [0, 0, -1]], atol=0.02)
    assert values[0, 0] > 4 * values[0, 1] > 4 * values[0, 2]


def test_toldi_z_faces_the_sensor_and_x_the_hill():
    mesh = build_mesh(
        height_view(lambda x, y: 4 * np.exp(-((x - 28) ** 2 + (y - 20) ** 2) / 4), (41, 41)),
        MeshConfig())
    config = LrfConfig(method='toldi', normal_radius_mr=2.0)
    lrfs, _ = compute_lrfs(mesh, np.array([20 * 41 + 20], np.int32), config, 12.0)
    assert np.allclose(lrfs[0], np.eye(3), atol=1e-3)


@pytest.mark.parametrize('method', ['rops', 'toldi'])
def test_no_triangle_within_reach_means_no_frame(method):
    vertices = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [50, 50, 0], [60, 0, 0.0]])
    mesh = RangeMesh(
        vertices, np.array([[0, 1, 2]], np.int32), np.tile([0, 0, 1.0], (5, 1)),
        np.ones(5, bool), 10.0)
    lrfs, values = compute_lrfs(mesh, np.array([0, 3], np.int32), LrfConfig(method=method), 5.0)
    assert not lrfs.any()
    assert not values.any()


def test_kernel_face_checks_its_arguments(mesh):
    v, f, n = mesh.vertices, mesh.faces, mesh.normals
    k = np.zeros(2, np.int32)
    for arguments, message in (
        ((v[:, :2], f, n, k, 1.0), 'vertices'),
        ((v, f[:, :2], n, k, 1.0), 'faces: expected'),
        ((v, f + 10**6, n, k, 1.0), 'faces: indices'),
        ((v, f, n[:5], k, 1.0), 'normals'),
        ((v, f, n, k[:, None], 1.0), 'keypoints: expected'),
        ((v, f, n, k - 1, 1.0), 'keypoints: indices'),
        ((v, f, n, k, 0.0), 'radius'),
    ):
        with pytest.raises(ShapeError, match=message):
            features(*arguments)
    with pytest.raises(ShapeError, match='lrfs'):
        features(v, f, n, k, 1.0, lrfs=np.zeros((3, 3, 3)))
