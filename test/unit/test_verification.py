# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Scoring, refining and examining poses. Truth: NumPy twins by brute force, exact poses."""

import numpy as np
import pytest
from reference import bumpy, evidence_twin as twin
from ros_rops.core.types import SensorModel
from ros_rops.kernels.verification import distinct, Evidence, examine, refine, score
from scipy.spatial.transform import Rotation

REACH = 7


@pytest.fixture(scope='module')
def views():
    return two_views(walled=False)


@pytest.fixture(scope='module')
def walled_views():
    return two_views(walled=True)


def two_views(walled):
    """Return views of a bumpy ball, with or without the wall behind it that each saw."""
    looks = np.array([[0.2, 0.1, 1.0], [0.7, -0.3, 0.8]])
    fine, poses, resolution = bumpy.views_of(looks, count=3000, noise=0.1)
    made = []
    for view, pose, look in zip(fine, poses, looks, strict=True):
        ray = tuple(-(look / np.linalg.norm(look)) @ pose[:3, :3])
        given = (view.points, view.normals, view.boundary, SensorModel(
            'orthographic', direction=ray))
        size = {'cell': 2 * resolution, 'reach': REACH}
        if walled:
            size['beyond'] = wall_behind(view.points, np.array(ray))
        made.append((Evidence.of(*given, **size), twin.EvidenceTwin(*given, **size)))
    return made, np.linalg.inv(poses[1]) @ poses[0], resolution


def wall_behind(points, ray):
    """Return rays that passed by the points and ended on a wall behind them."""
    side = np.linalg.svd(ray[None])[2][1:]
    flat, middle = (points - points.mean(axis=0)) @ side.T, points.mean(axis=0)
    places = np.random.default_rng(9).uniform(-70, 70, (1500, 2))
    past = np.linalg.norm(places[:, None] - flat[None], axis=2).min(axis=1) > 3.0
    return (middle + places[past] @ side + 40 * ray).astype(np.float32)


@pytest.fixture(scope='module')
def starts(views):
    """Poses from exact to far off."""
    (source, _), truth, mr = views[0][0], views[1], views[2]
    random, result = np.random.default_rng(3), []
    for degrees, shift in [(0, 0), (1, 0.5), (3, 1), (5, 3), (10, 5), (40, 10), (120, 20)]:
        axis, way = (v / np.linalg.norm(v) for v in random.normal(size=(2, 3)))
        turn = bumpy.rigid(Rotation.from_rotvec(np.radians(degrees) * axis), shift * mr * way)
        about = np.eye(4)
        about[:3, 3] = source.centre
        result.append(truth @ about @ turn @ np.linalg.inv(about))
    return np.stack(result)


def _moved(first, second, points):
    """Root mean square of what two poses make of the points."""
    gap = twin.placed(first, points) - twin.placed(second, points)
    return np.sqrt((gap ** 2).sum(axis=1).mean())


def test_score_equals_the_twin(views, starts):
    ((source, source_twin), (target, target_twin)), _, mr = views
    found = np.stack(score(source, target, starts, samples=200, tau=6 * mr, front=4 * mr), axis=2)
    for pose, values in zip(starts, found, strict=True):
        expected = twin.score(source_twin, target_twin, pose, 200, 6 * mr, 4 * mr)
        # The field's short cut may name a cell that is not quite the nearest.
        assert np.allclose(values[:, [0, 3]], expected[:, [0, 3]], atol=2e-3)
        assert np.allclose(values[:, 1:3], expected[:, 1:3], atol=1e-9)
    assert found[:, :, 1:].any(axis=(0, 1)).all()  # every kind of contradiction occurred


def test_what_was_seen_beyond_contradicts_as_the_twin_says(views, walled_views, starts):
    ((source, source_twin), (target, target_twin)), _, mr = walled_views
    limits = {'samples': 200, 'tau': 6 * mr, 'front': 4 * mr}
    found = np.stack(score(source, target, starts, **limits), axis=2)
    for pose, values in zip(starts, found, strict=True):
        expected = twin.score(source_twin, target_twin, pose, 200, 6 * mr, 4 * mr)
        assert np.allclose(values[:, 1:3], expected[:, 1:3], atol=1e-9)
    ((plain, _), (other, _)), _, _ = views
    without = np.stack(score(plain, other, starts, **limits), axis=2)
    assert found[0, :, 1].max() < 0.01  # the exact pose stands in front of nothing
    assert found[-1, :, 1].sum() > without[-1, :, 1].sum() + 0.3


def test_the_exact_pose_scores_best(views, starts):
    ((source, _), (target, _)), _, mr = views
    overlap = score(source, target, starts, samples=300, tau=3 * mr, front=4 * mr).overlap
    values = overlap.mean(axis=1)
    assert (np.diff(values[:4]) < 0).all()
    assert values[4:].max() < 0.3 * values[0]


@pytest.mark.parametrize('radius_mr', [3, 10])
def test_one_round_equals_the_twins_normal_equations(views, starts, radius_mr):
    ((source, source_twin), (target, target_twin)), _, mr = views
    radii = np.array([radius_mr * mr])
    moved = refine(source, target, starts[:5], radii, samples=150, agree=0.3)
    points = source_twin.means + source_twin.centre
    for pose, found in zip(starts, moved, strict=False):
        expected = twin.refine(source_twin, target_twin, pose, radii, 150, 0.3)
        # What is off is what the field's short cut mistakes: far cells, a few of a hundred.
        step = _moved(expected, pose, points)
        assert _moved(expected, found, points) <= 0.005 * mr + 0.03 * step


def test_rounds_come_home(views, starts):
    ((source, _), (target, _)), truth, mr = views
    moved = refine(
        source, target, starts[:5], mr * np.linspace(10, 3, 12), samples=400, agree=0.3)
    for pose in moved:
        assert np.linalg.norm((pose - truth)[:3] @ [*source.centre, 1]) < 0.2 * mr
        assert np.degrees(
            Rotation.from_matrix(pose[:3, :3].T @ truth[:3, :3]).magnitude()) < 0.5


def test_examine_equals_the_twin(views, starts):
    ((source, source_twin), (target, target_twin)), _, mr = views
    exams = examine(
        source, target, starts[:6], rounds=0, samples=300, radius=2 * mr, front=3 * mr)
    for pose, found in zip(starts, exams, strict=False):
        numbers, hessian = twin.examined(source_twin, target_twin, pose, 300, 2 * mr, 3 * mr)
        assert np.allclose(found.T_target_source, pose, atol=1e-9)
        assert np.allclose(found.numbers, numbers, rtol=1e-4, atol=1e-3)
        scale = np.sqrt(np.outer(np.diag(hessian), np.diag(hessian)))
        assert np.allclose(found.hessian / scale, hessian / scale, atol=1e-4)


def test_examine_refines_to_the_exact_pose(views, starts):
    ((source, _), (target, _)), truth, mr = views
    options = {'rounds': 8, 'samples': 2000, 'radius': 2 * mr, 'front': 3 * mr}
    found = examine(source, target, starts, **options)[2]
    for threads in (1, 3):  # alone, or among others, on any number of threads
        again, = examine(source, target, starts[[2]], threads=threads, **options)
        assert all(one.tobytes() == other.tobytes()
                   for one, other in zip(found, again, strict=True))
    error = found.T_target_source - truth
    assert np.linalg.norm(error[:3] @ [*source.centre, 1]) < 0.1 * mr


def test_swapped_sides_swap_the_columns(views, starts):
    ((source, _), (target, _)), _, mr = views
    limits = {'samples': 200, 'tau': 6 * mr, 'front': 4 * mr}
    there = score(source, target, starts, **limits)
    back = score(target, source, np.linalg.inv(starts), **limits)
    for a, b in zip(there, back, strict=True):
        assert np.allclose(a, b[:, ::-1], atol=1e-4)


@pytest.mark.parametrize('shift', [1e3, 1e6])
def test_far_from_the_origin_nothing_changes(views, starts, shift):
    ((source, _), (target, _)), _, mr = views
    looks = np.array([[0.2, 0.1, 1.0], [0.7, -0.3, 0.8]])
    fine, poses, _ = bumpy.views_of(looks, count=3000, noise=0.1)
    away = shift * np.array([1.0, -2.0, 0.5])
    look = looks[0] / np.linalg.norm(looks[0])
    far = Evidence.of(
        fine[0].points + away, fine[0].normals, fine[0].boundary,
        SensorModel('orthographic', direction=tuple(-look @ poses[0][:3, :3])),
        cell=2 * mr, reach=REACH)
    moved = starts.copy()
    moved[:, :3, 3] -= starts[:, :3, :3] @ away
    limits = {'samples': 200, 'tau': 6 * mr, 'front': 4 * mr}
    near = score(source, target, starts, **limits)
    for a, b in zip(near, score(far, target, moved, **limits), strict=True):
        assert np.allclose(a, b, atol=1e-3)


def test_threads_change_no_byte(views, starts):
    ((source, _), (target, _)), _, mr = views
    many = np.concatenate([starts] * 20)
    radii = mr * np.linspace(10, 3, 4)
    results = [
        (*score(source, target, many, samples=50, tau=6 * mr, front=4 * mr, threads=n),
         refine(source, target, many, radii, samples=50, agree=0.3, threads=n))
        for n in (1, 2, 3, 1)]
    for other in results[1:]:
        assert [a.tobytes() for a in results[0]] == [a.tobytes() for a in other]


def test_distinct_keeps_the_first_of_what_is_alike():
    def pose(degrees, shift):
        return bumpy.rigid(Rotation.from_rotvec([0, 0, np.radians(degrees)]), [shift, 0, 0])

    poses = np.stack([
        pose(0, 0), pose(4.9, 0.9), pose(5.1, 0), pose(0, 1.1), pose(5.2, 0.95), pose(180, 0)])
    limits = {'angle_rad': np.radians(5), 'distance': 1.0}
    assert distinct(poses, most=9, **limits).tolist() == [0, 2, 3, 5]
    assert distinct(poses, most=2, **limits).tolist() == [0, 2]
    assert distinct(poses[:0], most=2, **limits).tolist() == []
