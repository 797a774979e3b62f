# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The assembled cloud. Truth: rendered views of a body that a formula gives, exact poses."""

from dataclasses import replace

import numpy as np
import pytest
from ros_rops.core.config import Config
from ros_rops.core.groups_model import ModelConfig
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.modelling.cloud import assemble_cloud
from ros_rops.modelling.posed import pose_views, resolution_of
from ros_rops.recordings.procedural import blob, mesh_of
from ros_rops.recordings.synthetic import Model, synthetic_views
from scipy.spatial import cKDTree

NOISE, SLIP = 0.3, 0.3


@pytest.fixture(scope='module')
def captures():
    vertices, faces = mesh_of(blob(), 0.003)
    colors = np.full(vertices.shape, (200, 100, 50), np.uint8)
    return synthetic_views(
        Model(vertices, faces, colors, 'blob'), count=10, pixels=100, noise_mr=NOISE)


def placed(captures, slip=SLIP, change=None):
    """Return the captures as posed views; each pose is off by `slip` mesh resolutions."""
    rng = np.random.default_rng(3)
    poses = []
    for capture in captures:
        T = capture.T_world_view.copy()
        way = rng.normal(size=3)
        T[:3, 3] += slip * 0.0017 * way / np.linalg.norm(way)
        poses.append((capture.view.name, T))
    views = {one.view.name: one.view for one in captures}
    if change is not None:
        change(poses, views)
    numbers = {name: 10 + k for k, (name, _) in enumerate(poses)}
    return pose_views(poses, views, numbers, Config())


def assembled(views, **parameters):
    return assemble_cloud(views, ModelConfig(**parameters), resolution=resolution_of(views))


def errors(points, resolution):
    return np.abs(blob()(points)) / resolution


def raw(views):
    return np.concatenate([view.points[view.weights > 0] for view in views])


def test_points_come_nearer_to_the_surface_and_all_of_it_stays(captures):
    views = placed(captures)
    cloud, resolution = assembled(views), resolution_of(views)
    before, after = (errors(points, resolution) for points in (raw(views), cloud.points))
    assert np.quantile(after, 0.9) < 0.65 * np.quantile(before, 0.9)
    away, _ = cKDTree(cloud.points).query(raw(views))
    assert np.mean(away < resolution) > 0.995


def test_points_at_the_same_place_are_one(captures):
    views = placed(captures)
    cloud, resolution = assembled(views, cloud_mr=0.7), resolution_of(views)
    away, _ = cKDTree(cloud.points).query(cloud.points, k=2)
    assert away[:, 1].min() >= 0.7 * resolution
    assert len(cloud.points) < len(raw(views)) / 2
    assert len(assembled(views, cloud_mr=0.0).points) > 0.99 * len(raw(views))


def test_normals_point_outwards_and_follow_the_surface(captures):
    cloud = assembled(placed(captures))
    step = 1e-5
    truth = np.stack([
        blob()(cloud.points + step * axis) - blob()(cloud.points - step * axis)
        for axis in np.eye(3)], axis=1)
    truth /= np.linalg.norm(truth, axis=1, keepdims=True)
    angles = np.degrees(np.arccos(np.clip((truth * cloud.normals).sum(axis=1), -1, 1)))
    assert np.median(angles) < 8
    assert np.mean(angles > 90) < 0.001
    np.testing.assert_allclose(np.linalg.norm(cloud.normals, axis=1), 1, atol=1e-5)


def test_what_floats_where_others_see_through_goes_and_what_one_view_saw_stays(captures):
    def change(poses, views):
        name = poses[0][0]
        points = views[name].points.copy()
        middle = points[np.argmin(points[:, 2])]
        patch = np.linalg.norm(points - middle, axis=1) < 0.014
        points[patch] *= 0.93
        views[name] = replace(views[name], points=points)
        for name, view in views.items():
            # A wall far behind: what the body does not hide of it ends the rays that pass by.
            row, column = np.nonzero(view.grid < 0)
            wall = np.stack([(column - 49.5) / 105, (row - 49.5) / 105, np.ones(len(row))], axis=1)
            views[name] = replace(view, beyond=wall.astype(np.float32))

    views = placed(captures, change=change)
    cloud, resolution = assembled(views), resolution_of(views)
    floating = errors(raw(views), resolution) > 4
    assert floating.sum() > 50
    assert np.sum(errors(cloud.points, resolution) > 4) < 0.1 * floating.sum()
    alone = assembled(views[1:2])
    assert set(alone.directions) == {1}
    away, _ = cKDTree(alone.points).query(raw(views[1:2]))
    assert np.mean(away < resolution) > 0.98


def test_on_request_every_point_stays_under_its_views_id(captures):
    views = placed(captures)
    cloud = assembled(views, view_ids=True)
    np.testing.assert_array_equal(cloud.points, np.concatenate([v.points for v in views]))
    np.testing.assert_array_equal(
        cloud.view_ids, np.repeat(np.arange(10, 20), [len(v.view.points) for v in views]))
    assert cloud.directions.max() > 2
    np.testing.assert_array_equal(cloud.colors, (200, 100, 50) + 0 * cloud.points)


def test_colours_come_from_the_views_that_have_them(captures):
    def change(poses, views):
        for name, _ in poses[::2]:
            views[name] = replace(views[name], colors=None)

    cloud = assembled(placed(captures, change=change))
    coloured = (cloud.colors == (200, 100, 50)).all(axis=1)
    assert np.mean(coloured) > 0.9
    bare = placed([replace(one, view=replace(one.view, colors=None)) for one in captures])
    assert assembled(bare).colors is None


def test_any_sensor_and_no_view_at_all(captures):
    def change(poses, views):
        for name in views:
            views[name] = replace(views[name], sensor=SensorModel('unknown'), grid=None)

    views = placed(captures, change=change)
    assert np.quantile(errors(assembled(views).points, resolution_of(views)), 0.9) < 1.0
    nothing = assemble_cloud((), ModelConfig(), resolution=1.0)
    assert nothing.points.shape == (0, 3) and nothing.view_ids.shape == (0,)
    line = RangeView('line', np.array([[0, 0, 1.0], [0, 0, 2], [0, 0, 3]]))
    assert pose_views([('line', np.eye(4))], {'line': line}, {'line': 0}, Config()) == ()


def test_any_number_of_threads_gives_the_same_bytes(captures):
    views = placed(captures)
    one, four = (
        assemble_cloud(views, ModelConfig(), resolution=0.002, threads=threads)
        for threads in (1, 4))
    for name in ('points', 'normals', 'colors', 'weights', 'view_ids', 'directions'):
        assert getattr(one, name).tobytes() == getattr(four, name).tobytes()
