# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Colours of a cloud and of a surface. Truth: a texture by position, each view's gain known."""

from dataclasses import replace

import numpy as np
import pytest
from ros_rops.core.config import Config
from ros_rops.core.groups_model import ModelConfig
from ros_rops.core.se3 import move
from ros_rops.modelling.cloud import assemble_cloud
from ros_rops.modelling.exposure import exposures
from ros_rops.modelling.posed import pose_views, resolution_of
from ros_rops.modelling.tint import tinted, UNSEEN
from ros_rops.recordings.procedural import blob, mesh_of
from ros_rops.recordings.synthetic import Model, synthetic_views

GRAIN = 4.0
"""Standard deviation of the cameras' own noise, of 255."""


def texture(points):
    """Return smooth colours between 70 and 190, their waves 3 cm long: 17 resolutions."""
    ways = np.array([[1, 0.3, 0.2], [-0.2, 1, 0.4], [0.3, -0.5, 1]]) * 2 * np.pi / 0.03
    return 130 + 60 * np.sin(points @ ways.T + np.arange(3))


@pytest.fixture(scope='module')
def captures():
    return synthetic_views(
        Model(*mesh_of(blob(), 0.003), name='blob'), count=10, pixels=100, noise_mr=0.2)


def painted(captures, gains, grain=GRAIN):
    rng = np.random.default_rng(5)
    views, poses = {}, []
    for capture, gain in zip(captures, gains, strict=True):
        shown = texture(move(capture.T_world_view, capture.view.points)) * gain
        shown += rng.normal(0, grain, shown.shape)
        views[capture.view.name] = replace(
            capture.view, colors=np.clip(np.rint(shown), 0, 255).astype(np.uint8))
        poses.append((capture.view.name, capture.T_world_view))
    return pose_views(poses, views, {name: k for k, name in enumerate(views)}, Config())


@pytest.fixture(scope='module')
def gains():
    rng = np.random.default_rng(2)
    return rng.uniform(0.7, 1.3, (10, 1)) * rng.uniform(0.95, 1.05, (10, 3))


def off(points, colors):
    """Return the errors of colours after one factor for all, each channel its own."""
    want, got = texture(points), colors.astype(float)
    return got * ((want * got).sum(axis=0) / np.square(got).sum(axis=0)) - want


def test_each_views_gain_is_found(captures, gains):
    views = painted(captures, gains)
    left = np.log(exposures(views, resolution_of(views)) * gains)
    assert np.abs(left - left.mean(axis=0)).max() < 0.02
    alike = painted(captures, np.ones((10, 3)))
    assert np.abs(np.log(exposures(alike, resolution_of(alike)))).max() < 0.02


def test_views_that_share_no_place_or_have_no_colours_stay_as_they_are(captures, gains):
    first, *others = painted(captures, gains)
    aside = first.T_object_view.copy()
    aside[:3, 3] += 1.0
    alone = [first, replace(first, T_object_view=aside)]
    np.testing.assert_array_equal(exposures(alone, 0.002), 1.0)
    bare = replace(others[0], view=replace(others[0].view, colors=None))
    found = exposures([first, bare, *others[1:]], 0.002)
    np.testing.assert_array_equal(found[1], 1.0)
    np.testing.assert_allclose(np.exp(np.log(np.delete(found, 1, 0)).mean(axis=0)), 1.0)
    assert exposures([], 0.002).shape == (0, 3)


def test_black_and_dazzled_pixels_tell_no_gain(captures):
    gains = np.where(np.arange(10)[:, None] == 3, 2.0, 1.0) * np.ones(3)
    views = painted(captures, gains, grain=0.0)
    found = exposures(views, resolution_of(views))
    np.testing.assert_allclose(found[3] / np.delete(found, 3, 0).mean(axis=0), 0.5, rtol=0.03)


@pytest.mark.parametrize('what', ['cloud', 'surface'])
def test_colours_are_those_of_the_place_without_seams(captures, gains, what):
    views = painted(captures, gains)
    cloud = assemble_cloud(views, ModelConfig(), resolution=resolution_of(views))
    colors = cloud.colors
    if what == 'surface':
        colors = tinted(cloud.points, cloud.normals, views, resolution=resolution_of(views),
                        far=0.0)
    errors = off(cloud.points, colors)
    # One view's pixel is off by its grain and, uncorrected, by up to 30% of 130.
    assert np.sqrt(np.mean(np.square(errors))) < 1.2 * GRAIN
    assert np.quantile(np.abs(errors), 0.999) < 20


def test_colours_of_every_point_stay_as_measured_where_nothing_is_merged(captures, gains):
    views = painted(captures, gains)
    cloud = assemble_cloud(views, ModelConfig(view_ids=True), resolution=0.002)
    np.testing.assert_array_equal(
        cloud.colors, np.concatenate([view.view.colors for view in views]))


def test_a_place_that_none_saw_is_grey_and_a_back_side_takes_no_colour(captures, gains):
    views = painted(captures, gains)
    cloud = assemble_cloud(views, ModelConfig(), resolution=0.002)
    for points, normals in ((cloud.points + 1.0, cloud.normals), (cloud.points, -cloud.normals)):
        colors = tinted(points, normals, views, resolution=0.002, far=0.0)
        assert np.mean((colors == UNSEEN).all(axis=1)) > 0.99
    bare = [replace(view, view=replace(view.view, colors=None)) for view in views]
    assert tinted(cloud.points, cloud.normals, bare, resolution=0.002, far=0.0) is None
