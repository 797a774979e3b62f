# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Watertight surfaces of clouds. Truth: the ball that the points lie on."""

from dataclasses import replace
import sys

import numpy as np
import pytest
from ros_rops.core.config import ModelConfig
from ros_rops.core.errors import ModelError
from ros_rops.modelling.poisson import poisson_surface
from ros_rops.modelling.products import ModelCloud

RESOLUTION = 0.05


def ball_cloud(least_z=-2.0, count=8000):
    """Points spread evenly over the part of the unit ball above `least_z`."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, k * np.pi * (3 - np.sqrt(5))
    flat = np.sqrt(1 - z * z)
    points = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
    points = points[z >= least_z]
    ones = np.ones(len(points))
    colors = np.rint((points + 1) * 127).astype(np.uint8)
    return ModelCloud(
        points + 5.0, points.astype(np.float32), colors, ones.astype(np.float32),
        ones.astype(np.int32), ones.astype(np.uint8))


def made(cloud, **changes):
    pytest.importorskip('open3d', reason='no Open3D here')
    return poisson_surface(cloud, replace(ModelConfig(), **changes), resolution=RESOLUTION)


def radii(surface):
    return np.linalg.norm(surface.vertices - 5.0, axis=1)


def test_a_ball_is_closed_and_in_its_place():
    surface = made(ball_cloud())
    assert surface.facts['closed'] and surface.facts['manifold'] and not surface.filled.any()
    assert np.abs(radii(surface) - 1).max() < 0.1 * RESOLUTION
    assert surface.facts['volume'] == pytest.approx(4.18879, rel=0.005)
    outward = np.einsum('ij,ij->i', surface.normals, surface.vertices - 5.0)
    assert outward.min() > 0.95
    # Points of the cloud are a voxel apart, over which the colour changes by 8.
    assert np.abs(surface.colors - (surface.vertices - 4.0) * 127).max() < 9


def test_what_was_not_seen_is_filled_and_marked():
    surface = made(ball_cloud(-0.8))
    assert surface.facts['closed']
    low = surface.vertices[surface.faces].mean(axis=1)[:, 2] - 5.0
    assert surface.filled[low < -0.92].all() and not surface.filled[low > -0.75].any()
    assert surface.filled.any()


def test_one_side_alone_grows_no_skirt():
    surface = made(ball_cloud(0.3))
    assert not surface.facts['closed'] and surface.facts['components'] == 1
    assert surface.vertices[:, 2].min() > 5.3 - 3 * RESOLUTION
    assert np.abs(radii(surface) - 1).max() < 3 * RESOLUTION


def test_the_same_every_time():
    one, other = made(ball_cloud()), made(ball_cloud())
    assert one.vertices.tobytes() == other.vertices.tobytes()
    assert one.faces.tobytes() == other.faces.tobytes()


def test_voxel_grows_until_it_fits_the_memory():
    assert made(ball_cloud(), voxel_mr=1.0).facts['voxel'] == RESOLUTION
    coarser = made(ball_cloud(count=40_000), voxel_mr=0.3, memory_mb=16)
    assert coarser.facts['voxel'] > 0.3 * RESOLUTION
    assert coarser.facts['closed']


def test_without_open3d_the_error_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, 'open3d', None)
    with pytest.raises(ModelError, match=r'ros_rops\[poisson\]'):
        poisson_surface(ball_cloud(), ModelConfig(), resolution=RESOLUTION)


@pytest.mark.parametrize('count', [0, 5])
def test_too_few_points_are_refused(count):
    cloud = ball_cloud()
    part = ModelCloud(
        cloud.points[:count], cloud.normals[:count], None, cloud.weights[:count],
        cloud.view_ids[:count], cloud.directions[:count])
    with pytest.raises(ModelError, match='too few'):
        made(part)


def test_points_without_normals_or_extent_are_refused():
    cloud = ball_cloud()
    with pytest.raises(ModelError, match='normal'):
        made(replace(cloud, normals=np.zeros_like(cloud.normals)))
    with pytest.raises(ModelError, match='coincide'):
        made(replace(cloud, points=np.ones_like(cloud.points)))
