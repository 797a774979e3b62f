# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""RoPS; truth: the NumPy twin, the definition's norms, and what must not matter."""

import math

import numpy as np
import pytest
from reference.features_twin import descriptor
from reference.surfaces import bumpy_mesh, height_view
from ros_rops.core.config import Config, LrfConfig, MeshConfig, RopsConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.mesh import build_mesh
from ros_rops.core.rops import compute_features, describe, projections
from ros_rops.core.types import RangeMesh
from ros_rops.kernels.features import features, Projections

LRF = LrfConfig()


@pytest.fixture(scope='module')
def mesh():
    return bumpy_mesh()


@pytest.fixture(scope='module')
def keypoints(mesh):
    return np.arange(0, len(mesh.vertices), 131, dtype=np.int32)


@pytest.mark.parametrize('convention', ['author', 'pcl'])
@pytest.mark.parametrize(('rotations', 'bins'), [(3, 5), (1, 2), (4, 7), (2, 16)])
def test_equals_the_twin(mesh, keypoints, convention, rotations, bins):
    config = RopsConfig(radius_mr=7.0, rotations=rotations, bins=bins, convention=convention)
    found = describe(mesh, keypoints, LRF, config)
    assert found.descriptors.shape == (len(keypoints), 45 * rotations)
    for k, vertex in enumerate(keypoints):
        expected = descriptor(
            mesh.vertices, mesh.vertices[vertex], found.lrfs[k], 7.0 * mesh.resolution,
            projections(config))
        assert np.allclose(found.descriptors[k], expected, atol=1e-6)


def test_conventions_are_the_toolboxes():
    author, pcl = projections(RopsConfig()), projections(RopsConfig(convention='pcl'))
    assert np.degrees(author.angles) == pytest.approx([15, 45, 75] * 3)
    assert author.axes == (2, 2, 2, 1, 1, 1, 0, 0, 0)
    assert np.degrees(np.abs(pcl.angles)) == pytest.approx([22.5, 45, 67.5] * 3)
    assert pcl.axes == (0, 0, 0, 1, 1, 1, 2, 2, 2)
    assert author.log_unit == pytest.approx(1 / math.log(2))
    assert pcl.log_unit == 1


def test_descriptors_are_normalised(mesh, keypoints):
    author = describe(mesh, keypoints, LRF, RopsConfig()).descriptors
    pcl = describe(mesh, keypoints, LRF, RopsConfig(convention='pcl')).descriptors
    assert np.allclose(author.sum(axis=1), 1, atol=1e-5)
    assert np.allclose(np.abs(pcl).sum(axis=1), 1, atol=1e-5)


@pytest.mark.parametrize('method', ['rops', 'toldi'])
@pytest.mark.parametrize('triangles', ['author', 'pcl'])
def test_threads_do_not_change_a_byte(mesh, method, triangles):
    config = Config.from_flat({'lrf.method': method, 'lrf.triangles': triangles})
    once = compute_features(mesh, config, threads=1)
    assert len(once.indices) > 20
    for threads in (2, 3, 8, 0):
        again = compute_features(mesh, config, threads=threads)
        for name in ('indices', 'positions', 'lrfs', 'descriptors'):
            assert getattr(once, name).tobytes() == getattr(again, name).tobytes()


def test_stray_points_count_only_when_asked(mesh, keypoints):
    stray = mesh.vertices[::7] + np.array([0, 0, 2.0])
    dirty = RangeMesh(
        np.concatenate([mesh.vertices, stray]), mesh.faces,
        np.concatenate([mesh.normals, 0 * stray]),
        np.concatenate([mesh.boundary, np.ones(len(stray), bool)]), mesh.resolution)
    clean = describe(mesh, keypoints, LRF, RopsConfig()).descriptors
    without = describe(dirty, keypoints, LRF, RopsConfig()).descriptors
    counted = describe(dirty, keypoints, LRF, RopsConfig(loose_vertices=True)).descriptors
    assert np.array_equal(clean, without)
    assert np.abs(clean - counted).max(axis=1).min() > 1e-4


def test_resolution_sets_the_support(mesh):
    config = Config.from_flat({'rops.radius_mr': 5.0})
    double = compute_features(mesh, config, resolution=2 * mesh.resolution)
    lrf = LrfConfig(normal_radius_mr=2 * config.lrf.normal_radius_mr)
    wide = describe(mesh, double.indices, lrf, RopsConfig(radius_mr=10.0))
    assert np.array_equal(double.descriptors, wide.descriptors)


@pytest.mark.parametrize('method', ['rops', 'toldi'])
def test_plane_gives_finite_features(method):
    mesh = build_mesh(height_view(lambda x, y: 0 * x, (30, 30)), MeshConfig())
    found = compute_features(mesh, Config.from_flat({'lrf.method': method}))
    assert np.isfinite(found.lrfs).all()
    assert np.isfinite(found.descriptors).all()


def test_symmetric_supports_are_dropped_by_the_ratio_test():
    mesh = build_mesh(height_view(lambda x, y: 0 * x, (60, 60)), MeshConfig())
    papers = {
        'keypoints.boundary_mr': 16.0, 'rops.radius_mr': 15.0, 'lrf.method': 'rops'}
    every = compute_features(mesh, Config.from_flat(papers))
    kept = compute_features(mesh, Config.from_flat({**papers, 'keypoints.eigen_ratio': 1.02}))
    assert len(every.indices) > 20
    assert len(kept.indices) < 0.1 * len(every.indices)


def test_a_single_triangle_yields_no_feature():
    mesh = build_mesh(height_view(lambda x, y: 0 * x, (2, 2)), MeshConfig())
    assert compute_features(mesh, Config()).descriptors.shape == (0, 135)


def test_support_of_nothing_but_the_keypoint_is_zero(mesh):
    frames = np.eye(3)[None]
    found = features(
        mesh.vertices, mesh.faces, mesh.normals, np.array([500], np.int32), 1e-3, lrfs=frames,
        projections=projections(RopsConfig()))
    assert not found.descriptors.any()


def test_axes_and_angles_must_pair(mesh):
    with pytest.raises(ShapeError, match='axes'):
        features(
            mesh.vertices, mesh.faces, mesh.normals, np.zeros(1, np.int32), 1.0,
            projections=Projections(axes=(0, 1), angles=(0.1,)))


def test_frames_handed_in_must_fit(mesh):
    with pytest.raises(ShapeError, match='lrfs'):
        describe(mesh, np.zeros(2, np.int32), LRF, RopsConfig(), lrfs=np.eye(3))
