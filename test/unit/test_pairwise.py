# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Search and verdict. Truth: synthetic views with exact poses, and bodies without one answer."""

from dataclasses import replace

import numpy as np
import pytest
from reference.captures import error, model, neighbours, of_field
from ros_rops.core.config import Config
from ros_rops.core.pairwise import register
from ros_rops.core.types import SensorModel, Status
from ros_rops.pipeline.prepare import prepare
from ros_rops.recordings.synthetic import Model, synthetic_views

CONFIG = Config()


def surface(capture, **changes):
    return prepare(replace(capture.view, **changes), CONFIG).surface


@pytest.fixture(scope='module', params=['blob', 'bracket'])
def pair(request):
    """Two neighbouring captures, their surfaces and the registration of the second."""
    first, second = neighbours(request.param)
    target, source = surface(first), surface(second)
    return first, second, target, source, register(source, target, CONFIG)


def test_finds_the_exact_pose(pair):
    first, second, target, _, found = pair
    assert found.status is Status.PLACED, found.reason
    degrees, shift = error(found.T_target_source, first, second)
    assert degrees < 0.5
    assert shift < 0.2 * target.resolution


def test_tells_what_the_verdict_rests_on(pair):
    found = pair[-1]
    assert (found.source, found.target) == (pair[1].view.name, pair[0].view.name)
    assert found.numbers['matches'] > 0
    assert found.numbers['score'] > CONFIG.verdict.score_least
    assert found.numbers['residual_mr'] < found.numbers['residual_most_mr']
    assert found.numbers['stiffness'] > CONFIG.verdict.stiffness


def test_swapped_sides_invert_the_pose(pair):
    _, second, target, source, found = pair
    back = register(target, source, CONFIG)
    assert back.status is Status.PLACED, back.reason
    again = np.linalg.inv(back.T_target_source) - found.T_target_source
    middle = second.view.points.mean(axis=0)
    assert np.linalg.norm(again[:3] @ [*middle, 1]) < 0.1 * target.resolution
    assert np.abs(again[:3, :3]).max() < 2e-3


def test_far_away_the_pose_is_the_same(pair):
    _, second, target, _, found = pair
    # A thousand kilometres, the points a tenth of a millimetre rounded.
    away = np.array([1.0e6, -2.0e6, 0.5e6])
    far = surface(second, points=second.view.points + away, sensor=SensorModel(
        'pinhole', origin=tuple(away), direction=(0.0, 0.0, 1.0)))
    moved = register(far, target, CONFIG)
    assert moved.status is found.status
    pose = moved.T_target_source.copy()
    pose[:3, 3] += pose[:3, :3] @ away
    gap = pose - found.T_target_source
    assert np.abs(gap[:3, :3]).max() < 2e-3
    assert np.linalg.norm(gap[:3] @ [*second.view.points.mean(axis=0), 1]) < 0.1 * far.resolution


def test_a_view_registers_to_itself(pair):
    target = pair[2]
    found = register(target, target, CONFIG)
    assert found.status is Status.PLACED, found.reason
    assert np.allclose(found.T_target_source, np.eye(4), atol=1e-4)


def test_threads_and_repetition_change_no_byte(pair):
    _, _, target, source, found = pair
    for threads in (1, 2):
        again = register(source, target, CONFIG, threads=threads)
        assert again.T_target_source.tobytes() == found.T_target_source.tobytes()
        assert again.numbers == found.numbers


def test_laps_come_in_order(pair):
    _, _, target, source, _ = pair
    stages = []
    register(source, target, CONFIG, lap=stages.append)
    first, more = ['match', 'glance'], ['match', 'quick', 'thorough']
    assert stages in [[*first, *more[:k], 'settle'] for k in (0, 2, 3)]


def test_other_objects_are_refused():
    blob, bracket = (surface(neighbours(name)[0]) for name in ('blob', 'bracket'))
    found = register(blob, bracket, CONFIG)
    assert found.status is Status.REFUSED
    assert found.T_target_source is None


@pytest.mark.parametrize(('of_body', 'of_mirrored'), [(0, 1), (3, 3)])
def test_rays_that_contradict_outweigh_much_overlap(of_body, of_mirrored):
    body = model('bracket')
    mirrored = Model(body.vertices * [-1, 1, 1], body.faces[:, ::-1], name='mirrored')
    source = surface(synthetic_views(body, count=8, seed=0, pixels=110)[of_body])
    target = surface(synthetic_views(mirrored, count=8, seed=1, pixels=110)[of_mirrored])
    lenient = replace(CONFIG, verdict=replace(CONFIG.verdict, contradiction=100.0))
    assert register(source, target, lenient).status is Status.PLACED
    found = register(source, target, CONFIG)
    assert found.status is Status.REFUSED
    assert 'contradict' in found.reason


def _plane(points):
    # Wider than the image: no rim is seen.
    return np.maximum(np.abs(points[..., 2]) - 0.01, np.abs(points[..., :2]).max(axis=-1) - 0.3)


def _sphere(points):
    return np.linalg.norm(points, axis=-1) - 0.05


def _cylinder(points):
    return np.maximum(
        np.linalg.norm(points[..., :2], axis=-1) - 0.03, np.abs(points[..., 2]) - 0.06)


def _twofold(points):
    """Two equal bumps on a ball, opposite each other: half a turn changes nothing."""
    length = np.linalg.norm(points, axis=-1)
    unit = points / np.maximum(length, 1e-9)[..., None]
    radius = np.full(length.shape, 0.045)
    for axis in ([0.8, 0.0, 0.6], [-0.8, 0.0, 0.6]):
        radius += 0.012 * np.exp(20 * (unit @ np.array(axis) - 1))
    for axis in ([0.3, 0.5, 0.81], [-0.3, -0.5, 0.81]):
        radius += 0.009 * np.exp(30 * (unit @ np.array(axis) - 1))
    return length - radius


@pytest.mark.parametrize('body', [_plane, _sphere, _cylinder])
def test_a_surface_that_slides_on_itself_is_ambiguous(body):
    first, second = of_field(body)
    found = register(surface(second), surface(first), CONFIG)
    assert found.status is Status.AMBIGUOUS, found.reason
    assert found.T_target_source is None


@pytest.mark.parametrize('quick', [0, 20])
def test_two_poses_that_fit_alike_are_ambiguous(quick):
    first, second = (surface(capture) for capture in of_field(_twofold))
    found = register(second, first, Config.from_flat({'pairwise.quick': quick}))
    assert found.status is Status.AMBIGUOUS, found.reason
    assert found.T_target_source is None


def test_without_features_nothing_is_registered(pair):
    _, _, target, source, _ = pair
    config = Config.from_flat({'pairwise.random_starts': 0, 'pairwise.matches': False})
    found = register(source, target, config)
    assert found.status is Status.REFUSED
    assert 'no hypothesis' in found.reason
