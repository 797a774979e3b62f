# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Rival descriptors of ours and their exchange. Truth: analytic (planes, spheres, cylinders)."""

import numpy as np
import pytest
from reference.surfaces import bumps, bumpy_mesh, height_view, moved
from ros_rops.bench.rivals.descriptor import Descriptor, exchanged, rops, with_descriptor
from ros_rops.bench.rivals.fpfh import fpfh
from ros_rops.bench.rivals.lsp import BINS, lsp
from ros_rops.bench.rivals.pcl_descriptors import of_unit_length, standardised
from ros_rops.bench.rivals.supports import (
    curvatures, histograms, shape_indices, supports_of, window_normals)
from ros_rops.bench.rivals.thrift import thrift
from ros_rops.core.config import Config, MeshConfig
from ros_rops.core.mesh import build_mesh
from ros_rops.pipeline.prepare import prepare
from scipy.spatial.transform import Rotation

RADIUS = 60.0
MIDDLE = 12 * 25 + 12


def mesh_of(height):
    return build_mesh(height_view(height, (25, 25)), MeshConfig())


def sphere(x, y):
    return np.sqrt(RADIUS ** 2 - (x - 12) ** 2 - (y - 12) ** 2)


def described(descriptor, mesh, indices=(MIDDLE,)):
    indices = np.array(indices, np.int32)
    frames = np.tile(np.eye(3), (len(indices), 1, 1))
    return descriptor.describe(mesh, indices, frames, 1.0, 1)


@pytest.mark.parametrize(('height', 'expected'), [
    (sphere, 1.0), (lambda x, y: -sphere(x, y), 0.0),
    (lambda x, y: ((x - 12) ** 2 - (y - 12) ** 2) / 90, 0.5),
    (lambda x, y: -(x - 12) ** 2 / 60, 0.75), (lambda x, y: (x - 12) ** 2 / 60, 0.25)],
    ids=['cap', 'cup', 'saddle', 'ridge', 'rut'])
def test_shape_index_of_known_surfaces(height, expected):
    mesh = mesh_of(height)
    found = shape_indices(mesh.vertices, mesh.normals, 25, threads=1)
    assert found[MIDDLE] == pytest.approx(expected, abs=0.01)


def test_curvatures_of_a_parabolic_cylinder():
    mesh = mesh_of(lambda x, y: -(x - 12) ** 2 / 60)
    x = mesh.vertices[:, 0] - 12
    inner = (np.abs(mesh.vertices[:, :2] - 12) < 9).all(axis=1)
    found = curvatures(mesh.vertices, mesh.normals, 25, threads=1)[inner]
    expected = -(1 / 30) / (1 + (x[inner] / 30) ** 2) ** 1.5
    np.testing.assert_allclose(found[:, 0], expected, atol=2e-4)
    np.testing.assert_allclose(found[:, 1], 0.0, atol=2e-4)


def test_curvatures_scale_as_one_over_length():
    mesh = mesh_of(sphere)
    found = curvatures(1e-3 * mesh.vertices, mesh.normals, 25, threads=1)[MIDDLE]
    np.testing.assert_allclose(found, -1e3 / RADIUS, rtol=0.01)


def test_histograms_share_between_neighbouring_bins():
    owner = np.array([0, 0, 1])
    found = histograms(owner, np.array([[0.0], [0.125], [1.0]]), np.ones(3), 3, (5,))
    np.testing.assert_allclose(found, [[0.75, 0.25, 0, 0, 0], [0, 0, 0, 0, 1], [0] * 5])
    plane = histograms(owner[:1], np.array([[0.5, 0.25]]), np.ones(1), 1, (2, 3))
    np.testing.assert_allclose(plane.reshape(2, 3), [[0.25, 0.25, 0], [0.25, 0.25, 0]])


def test_supports_are_all_points_within_the_radius():
    points = np.random.default_rng(0).uniform(size=(200, 3))
    found = supports_of(points, points[:7], 0.4, threads=1)
    gap = np.linalg.norm(points[None] - points[:7, None], axis=2)
    owner, member = np.nonzero((gap <= 0.4) & (gap > 0))
    assert set(zip(found.owner, found.member, strict=True)) == set(
        zip(owner, member, strict=True))
    np.testing.assert_allclose(found.distance, gap[found.owner, found.member])


def test_a_window_of_a_plane_has_its_normal():
    mesh = mesh_of(lambda x, y: 0.3 * x - 0.1 * y)
    found = window_normals(mesh.vertices, mesh.normals, np.array([0, MIDDLE]), 5.0, threads=1)
    normal = np.array([-0.3, 0.1, 1.0])
    np.testing.assert_allclose(found, np.tile(normal / np.linalg.norm(normal), (2, 1)))


def test_lsp_of_a_plane_is_one_bin():
    row = described(lsp(8.0), mesh_of(lambda x, y: 0.0 * x))[0].reshape(BINS)
    assert row[BINS[0] // 2, -1] == pytest.approx(1.0, abs=1e-6)


def test_lsp_of_a_sphere_has_its_shape_and_its_mean_cosine():
    mesh = mesh_of(sphere)
    share = described(lsp(8.0), mesh)[0].reshape(BINS).astype(float) ** 2
    assert share[-1].sum() > 0.95
    offsets = mesh.vertices - mesh.vertices[MIDDLE]
    distance = np.linalg.norm(offsets, axis=1)
    near = (distance > 0) & (distance <= 8.0)
    # Of unit normals p / R: 1 - d^2 / (2 R^2). Sharing between bins keeps the mean.
    expected = np.mean(1 - 0.25 * (distance[near] / RADIUS) ** 2)
    assert share.sum(axis=0) @ np.linspace(0, 1, BINS[1]) == pytest.approx(expected, abs=1e-4)


def test_thrift_of_a_sphere_has_its_mean_angle():
    mesh = mesh_of(sphere)
    row = described(thrift(8.0), mesh)[0].astype(float)
    distance = np.linalg.norm(mesh.vertices - mesh.vertices[MIDDLE], axis=1)
    near = (distance > 0) & (distance <= 8.0)
    angle = 2 * np.arcsin(distance[near] / (2 * RADIUS))
    expected = np.average(angle, weights=1 - distance[near] / 8.0)
    assert row @ np.linspace(0, np.pi, 32) == pytest.approx(expected, rel=0.01)
    assert described(thrift(8.0), mesh_of(lambda x, y: x))[0][0] == pytest.approx(1.0, abs=1e-5)


# Open3D of PyPI warns where there is no graphics card.
@pytest.mark.filterwarnings('ignore::ImportWarning')
@pytest.mark.parametrize('make', [lsp, thrift, fpfh])
def test_descriptors_do_not_see_the_pose(make):
    if make(8.0).missing():
        pytest.skip(make(8.0).missing())
    mesh = bumpy_mesh()
    turned = moved(mesh, Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(), [9.0, -4.0, 2.0])
    indices = [700, 1000, 1300]
    np.testing.assert_allclose(
        described(make(8.0), turned, indices), described(make(8.0), mesh, indices),
        rtol=1e-3, atol=1e-3 * described(make(8.0), mesh, indices).max())


def test_the_exchange_leaves_keypoints_and_frames():
    config = Config()
    prepared = prepare(height_view(bumps, (45, 48), jitter=0.2), config, threads=1)
    flat = Descriptor(
        'flat', 'nobody', lambda mesh, indices, lrfs, unit, threads: np.ones(
            (len(indices), 2), np.float32))
    other = exchanged(prepared, flat, threads=1)
    ours, theirs = prepared.surface.features, other.surface.features
    assert (theirs.descriptors == 1).all() and theirs.descriptors.shape[1] == 2
    for name in ('indices', 'positions', 'lrfs'):
        assert getattr(theirs, name) is getattr(ours, name)
    assert other.surface.evidence is prepared.surface.evidence
    again = exchanged(other, rops(config), threads=1).surface.features
    assert again.descriptors.tobytes() == ours.descriptors.tobytes()
    contestant = with_descriptor(flat, config, threads=1)
    assert contestant.name == 'flat'
    assert (contestant.prepare(prepared.view).surface.features.descriptors == 1).all()


def test_euclidean_distance_of_standardised_rows_is_their_correlation():
    rows = np.random.default_rng(1).uniform(size=(2, 40)).astype(np.float32)
    a, b = standardised(rows)
    assert np.sum((a - b) ** 2) == pytest.approx(
        2 - 2 * np.corrcoef(rows)[0, 1], rel=1e-4)
    assert not standardised(np.ones((1, 5), np.float32)).any()
    assert not of_unit_length(np.zeros((1, 5), np.float32)).any()
