# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Descriptors of PCL. Truth: NumPy after the articles; another implementation for FPFH."""

import os

import numpy as np
import pytest
from reference.surfaces import bumpy_mesh, height_view, moved
from ros_rops.bench.rivals import pcl
from ros_rops.bench.rivals.fpfh import fpfh
from ros_rops.bench.rivals.pcl_descriptors import shot, spin_image, usc
from ros_rops.core.config import LrfConfig, MeshConfig
from ros_rops.core.errors import InputError
from ros_rops.core.lrf import compute_lrfs
from ros_rops.core.mesh import build_mesh
from scipy.spatial.transform import Rotation

KEYPOINTS = np.array([700, 1000, 1300], np.int32)
RADIUS = 8.0


@pytest.fixture(scope='module')
def scene():
    """Return a mesh and the frames of `KEYPOINTS`."""
    if missing := pcl.pcl_missing():
        pytest.skip(missing)
    mesh = bumpy_mesh()
    return mesh, compute_lrfs(mesh, KEYPOINTS, LrfConfig(), RADIUS, threads=1)[0]


def raw(name, scene):
    return pcl.pcl_features(name, *scene[:1], KEYPOINTS, scene[1], RADIUS, 1.0).descriptors


def neighbours(mesh, keypoint):
    offsets = mesh.vertices - mesh.vertices[keypoint]
    distance = np.linalg.norm(offsets, axis=1)
    near = (distance > 0) & (distance <= RADIUS)
    return offsets[near], distance[near], np.flatnonzero(near)


def spin_reference(mesh, keypoint, width=15):
    offsets, distance, _ = neighbours(mesh, keypoint)
    size = RADIUS / width / np.sqrt(2)
    beta = offsets @ mesh.normals[keypoint]
    alpha = np.sqrt(np.maximum(distance ** 2 - beta ** 2, 0))
    inside = (np.abs(beta) < size * width) & (alpha < size * width)
    place = np.stack([alpha[inside] / size, beta[inside] / size + width], axis=1)
    low, image = np.floor(place).astype(int), np.zeros((width + 1, 2 * width + 1))
    part = place - low
    for i, j in np.ndindex(2, 2):
        share = np.abs(1 - i - part[:, 0]) * np.abs(1 - j - part[:, 1])
        np.add.at(image, (low[:, 0] + i, low[:, 1] + j), share)
    return (image / image.sum()).ravel()


def usc_reference(mesh, keypoint, frame):
    offsets, distance, members = neighbours(mesh, keypoint)
    x, y, z = frame @ offsets.T
    edges = 0.1 * RADIUS * 10 ** (np.arange(11) / 10)
    angles = np.linspace(0, 180, 15)
    shell = np.searchsorted(edges[1:], distance)
    tilt = np.searchsorted(angles[1:], np.degrees(np.arccos(z / distance)))
    turn = np.searchsorted(2 * angles[1:], np.degrees(np.arctan2(y, x)) % 360)
    gaps = np.linalg.norm(mesh.vertices[members][:, None] - mesh.vertices[None], axis=2)
    density = (gaps <= 0.2 * RADIUS).sum(axis=1)
    volume = (
        (edges[shell + 1] ** 3 - edges[shell] ** 3) / 3 * 2 * np.pi / 14
        * (np.cos(np.radians(angles[tilt])) - np.cos(np.radians(angles[tilt + 1]))))
    row = np.zeros(1960)
    np.add.at(row, turn * 140 + tilt * 10 + shell, 1 / density / np.cbrt(volume))
    return row


def alike(a, b):
    """Correlate rows: float32 moves a point over the edge of a bin now and then."""
    return np.corrcoef(a, b)[0, 1]


def test_spin_images_are_those_of_the_article(scene):
    for row, keypoint in zip(raw('spin', scene), KEYPOINTS, strict=True):
        np.testing.assert_allclose(row, spin_reference(scene[0], keypoint), atol=1e-5)


def test_usc_is_that_of_the_article(scene):
    for row, keypoint, frame in zip(raw('usc', scene), KEYPOINTS, scene[1], strict=True):
        assert alike(row, usc_reference(scene[0], keypoint, frame)) > 0.99


def test_shot_of_a_plane_has_one_cosine():
    if missing := pcl.pcl_missing():
        pytest.skip(missing)
    mesh = build_mesh(height_view(lambda x, y: 0 * x, (25, 25)), MeshConfig())
    row = shot(RADIUS).describe(mesh, np.array([312], np.int32), np.eye(3)[None], 1.0, 1)[0]
    assert np.linalg.norm(row) == pytest.approx(1.0)
    cosines = row.reshape(32, 11)  # the last bin: normals parallel to the frame's z
    np.testing.assert_allclose(cosines[:, :10], 0.0, atol=1e-5)
    assert (cosines[:, 10] > 0).sum() >= 16


# Open3D of PyPI warns where there is no graphics card.
@pytest.mark.filterwarnings('ignore::ImportWarning')
def test_fpfh_of_both_libraries_agree(scene):
    if missing := fpfh(RADIUS).missing():
        pytest.skip(missing)
    other = fpfh(RADIUS).describe(scene[0], KEYPOINTS, scene[1], 1.0, 1)
    for a, b in zip(raw('fpfh', scene), other, strict=True):
        assert alike(a, b) > 0.95


@pytest.mark.parametrize('make', [spin_image, shot, usc])
def test_descriptors_follow_the_frames(scene, make):
    mesh, frames = scene
    rotation = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    turned = moved(mesh, rotation, [9.0, -4.0, 2.0], 0.001)
    here = make(RADIUS).describe(mesh, KEYPOINTS, frames, 1.0, 1)
    there = make(RADIUS).describe(turned, KEYPOINTS, frames @ rotation.T, 0.001, 1)
    for a, b in zip(here, there, strict=True):
        assert alike(a, b) > 0.99


def test_a_refusal_of_the_program_is_reported(scene):
    with pytest.raises(InputError, match='no descriptor nothing'):
        raw('nothing', scene)


def test_what_is_not_installed_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv('PATH', str(tmp_path))
    pcl.program.cache_clear()
    assert 'g++ is not installed (apt install g++ pkg-config libpcl-dev)' in pcl.pcl_missing()
    for tool in ('g++', 'pkg-config'):
        (tmp_path / tool).write_text('#!/bin/sh\nexit 1\n')
        os.chmod(tmp_path / tool, 0o755)
    assert pcl.pcl_missing() == 'PCL is not installed (apt install libpcl-dev)'


def test_a_compiler_that_refuses_is_reported(tmp_path, monkeypatch):
    (tmp_path / 'pkg-config').write_text('#!/bin/sh\necho 1.13\n')
    (tmp_path / 'g++').write_text('#!/bin/sh\necho "error: no header" >&2\nexit 1\n')
    for tool in ('g++', 'pkg-config'):
        os.chmod(tmp_path / tool, 0o755)
    monkeypatch.setenv('PATH', str(tmp_path))
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    pcl.program.cache_clear()
    assert pcl.pcl_missing() == 'pcl_features.cpp does not compile: error: no header'
    assert not list((tmp_path / 'cache' / 'ros_rops').iterdir())
