# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Truth: the NumPy twin, brute force, and what cannot depend on the number of threads."""

import numpy as np
import pytest
from reference import bumpy, fine_twin
from ros_rops.core.errors import ShapeError
from ros_rops.kernels.fine import Surfaces

RADIUS, MIN_COS, SOFT = 2.2, 0.8, 0.3


@pytest.fixture(scope='module')
def scene():
    views, poses, resolution = bumpy.views_of([[0, 0, 1], [0.6, 0, 1]], noise=0.2, count=3000)
    return views, bumpy.disturbed(views, poses, resolution), resolution


def prepared(views, resolution, threads=1, cell=2.0):
    return Surfaces(
        [v.points for v in views], [v.normals for v in views], [v.boundary for v in views],
        cell=cell * resolution, support=3 * resolution, threads=threads)


@pytest.mark.parametrize('cell', [0.7, 2.0, 5.0])
def test_planes_equal_the_twin(scene, cell):
    views, _, resolution = scene
    found = prepared(views, resolution, cell=cell).planes(1)
    normals, thickness, usable = fine_twin.planes(
        views[1].points, views[1].normals, views[1].boundary, 3 * resolution)
    assert np.array_equal(found.usable, usable)
    assert 0.5 < usable.mean() < 1.0
    np.testing.assert_allclose(found.normals[usable], normals[usable], atol=1e-6)
    np.testing.assert_allclose(found.thickness, thickness, atol=1e-6 * resolution)


@pytest.mark.parametrize('radius', [0.3, 1.0, 4.0])
def test_matches_equal_the_twin(scene, radius):
    views, poses, resolution = scene
    surfaces = prepared(views, resolution)
    samples = np.arange(0, len(views[0].points), 3, dtype=np.int32)
    sides = [placed(surfaces, views, poses, v) for v in (0, 1)]
    source, target, _ = fine_twin.match(*sides, samples, radius * resolution, MIN_COS)
    found = surfaces.match(
        0, 1, samples, poses[0], poses[1], radius=radius * resolution, min_cos=MIN_COS)
    assert len(source) > 10
    assert np.array_equal(found[0], source)
    assert np.array_equal(found[1], target)


def placed(surfaces, views, poses, v):
    planes = surfaces.planes(v)
    return (
        fine_twin.placed(poses[v], views[v].points), planes.normals @ poses[v][:3, :3].T,
        planes.usable)


def sums(surfaces, poses, samples, resolution, threads=1, centre=(1.0, 2.0, 3.0)):
    return surfaces.normal_equations(
        [[0, 1], [1, 0]], samples, np.array(poses), np.array(centre),
        radius=RADIUS * resolution, min_cos=MIN_COS, soft=SOFT * resolution, threads=threads)


def test_normal_equations_equal_the_twin(scene):
    views, poses, resolution = scene
    surfaces = prepared(views, resolution)
    samples = [np.arange(0, len(v.points), 2, dtype=np.int32) for v in views]
    found = sums(surfaces, poses, samples, resolution)
    sides = [placed(surfaces, views, poses, v) for v in (0, 1)]
    for p, (i, j) in enumerate([(0, 1), (1, 0)]):
        hessian, gradient, stats = fine_twin.normal_equations(
            sides[i], sides[j], samples[i], np.array([1.0, 2.0, 3.0]), RADIUS * resolution,
            MIN_COS, SOFT * resolution)
        np.testing.assert_allclose(found.hessian[p], hessian, rtol=1e-9, atol=1e-7)
        np.testing.assert_allclose(found.gradient[p], gradient, rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose([part[p] for part in found[2:]], stats, rtol=1e-9)


@pytest.mark.parametrize('threads', [2, 5])
def test_threads_change_nothing(scene, threads):
    views, poses, resolution = scene
    samples = [np.arange(len(v.points), dtype=np.int32) for v in views]
    one = prepared(views, resolution, 1)
    more = prepared(views, resolution, threads)
    for a, b in zip(one.planes(0), more.planes(0), strict=True):
        assert a.tobytes() == b.tobytes()
    alone = sums(one, poses, samples, resolution, 1)
    for a, b in zip(alone, sums(more, poses, samples, resolution, threads), strict=True):
        assert a.tobytes() == b.tobytes()


def test_far_scattered_points_cost_nothing_and_are_found():
    rng = np.random.default_rng(0)
    cloud = np.concatenate([rng.normal(size=(500, 3)), rng.normal(size=(50, 3)) * 1e9])
    surfaces = Surfaces(
        [cloud, cloud], [np.ones((550, 3))] * 2, [np.zeros(550, bool)] * 2, cell=0.5, support=1.0)
    samples = np.arange(500, dtype=np.int32)
    usable = surfaces.planes(0).usable[:500]
    source, target = surfaces.match(
        0, 1, samples, np.eye(4), np.eye(4), radius=0.1, min_cos=-1.0)
    assert usable.sum() > 300
    assert np.array_equal(source, samples[usable])
    assert np.array_equal(target, source)


def test_degenerate_views():
    same = np.zeros((20, 3))
    line = np.arange(20.0)[:, None] * [1, 0, 0]
    empty = np.zeros((0, 3))
    clouds = [same, line, empty]
    surfaces = Surfaces(
        clouds, [np.ones_like(c) for c in clouds], [np.zeros(len(c), bool) for c in clouds],
        cell=1.0, support=3.0)
    assert not surfaces.planes(0).usable.any()
    assert np.isfinite(surfaces.planes(1).normals).all()
    assert len(surfaces.planes(2).usable) == 0


def test_bad_arguments_are_named(scene):
    views, poses, resolution = scene
    surfaces = prepared(views, resolution)
    samples = [np.zeros(1, np.int32)] * 2
    with pytest.raises(ShapeError, match='view'):
        surfaces.planes(2)
    with pytest.raises(ShapeError, match='samples of view 0'):
        sums(surfaces, poses, [np.array([10 ** 6], np.int32), samples[1]], resolution)
    with pytest.raises(ShapeError, match='poses, samples'):
        sums(surfaces, poses[:1], samples, resolution)
    with pytest.raises(ShapeError, match='pairs'):
        surfaces.normal_equations(
            [[0, 2]], samples, np.array(poses), np.zeros(3), radius=1.0, min_cos=0, soft=1.0)
    with pytest.raises(ShapeError, match='cell'):
        prepared(views, resolution, cell=0.0)
    with pytest.raises(ShapeError, match='view 0'):
        Surfaces([np.zeros((3, 2))], [np.zeros((3, 2))], [np.zeros(3, bool)], cell=1, support=1)
