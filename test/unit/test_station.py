# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a station knows; truth: turntables, planes and poses made by hand."""

import math

import numpy as np
import pytest
from reference.captures import arc
from ros_rops.core.config import Config, PriorConfig
from ros_rops.core.se3 import rigid
from ros_rops.core.station import Axis, Known, standing_transforms
from ros_rops.core.station_axis import find_axis
from ros_rops.core.surface import Surface
from ros_rops.core.types import SupportPlane
from ros_rops.pipeline.prepare import prepare
from scipy.spatial.transform import Rotation

UP = np.array([0.1, -0.8, -0.59])
UP = UP / np.linalg.norm(UP)
CENTRE = np.array([0.01, 0.03, 0.25])
AXIS = Axis(tuple(UP.tolist()), tuple(CENTRE.tolist()))


def turned(degrees):
    return AXIS.turn(np.radians(np.atleast_1d(degrees)))


def test_turns_keep_the_axis_where_it_is():
    poses = turned([0.0, 30.0, -120.0])
    assert np.allclose(poses[0], np.eye(4))
    for pose, degrees in zip(poses, (0.0, 30.0, -120.0), strict=True):
        assert np.allclose(pose[:3, :3] @ (CENTRE + UP) + pose[:3, 3], CENTRE + UP)
        assert math.degrees(AXIS.angle(pose)) == pytest.approx(degrees)


def views_seen(degrees, noise=0.0):
    """Return T_object_view of a turntable's stops; the sensor stands still."""
    random = np.random.default_rng(7)
    first = rigid(Rotation.from_rotvec([0.3, 0.2, -0.5]).as_matrix(), np.array([0.1, 0.0, 0.4]))
    shaken = rigid(
        Rotation.from_rotvec(random.normal(0.0, noise, (len(degrees), 3))).as_matrix(),
        random.normal(0.0, noise * 0.1, (len(degrees), 3)))
    return [first @ pose @ shake for pose, shake in zip(turned(degrees), shaken, strict=True)]


def test_the_axis_is_found():
    fit = find_axis([views_seen([0, 50, 95, 150])], np.array([0.0, 0.0, 0.3]), 3.0, 0.005)
    assert fit.share == 1.0
    assert abs(np.dot(fit.axis.direction, UP)) == pytest.approx(1.0, abs=1e-9)
    beside = np.array(fit.axis.point) - CENTRE
    assert np.linalg.norm(beside - beside @ UP * UP) < 1e-9


def test_the_axis_is_found_despite_noise_and_one_wrong_view():
    poses = views_seen([0, 50, 95, 150, 200], noise=0.003)
    poses[2] = poses[2] @ rigid(Rotation.from_rotvec([1.0, 0.4, 0.0]).as_matrix(), np.zeros(3))
    fit = find_axis([poses], CENTRE, 3.0, 0.005)
    assert fit.share == pytest.approx(6 / 10)
    assert math.degrees(math.acos(abs(np.dot(fit.axis.direction, UP)))) < 1.0


def test_objects_share_the_axis():
    fit = find_axis([views_seen([0, 70]), views_seen([0, 100, 160])], CENTRE, 3.0, 0.005)
    assert fit.share == 1.0


@pytest.mark.parametrize('poses', [
    [], views_seen([0, 60]), views_seen([0, 1, 2, 3]),
    [rigid(Rotation.random(random_state=k).as_matrix(), np.ones(3) * k) for k in range(6)]])
def test_no_axis_where_none_is(poses):
    assert find_axis([poses], CENTRE, 3.0, 0.005) is None


@pytest.fixture(scope='module')
def sides():
    """Return two captures of the blob, each with the plane z = -0.1 of the world as seen."""
    result = []
    for capture in arc('blob', 2):
        up = capture.T_world_view[2, :3]
        plane = SupportPlane(tuple(up.tolist()), float(-0.1 - capture.T_world_view[2, 3]))
        surface = prepare(capture.view, Config(), threads=2).surface
        result.append((Surface(
            surface.name, surface.features, surface.evidence, surface.resolution, plane),
            capture.T_world_view))
    return result


def test_standing_starts_map_plane_to_plane(sides):
    (source, T_source), (target, T_target) = sides
    poses = standing_transforms(source, target, 500, np.random.default_rng(0))
    assert len(poses) == 500
    normal = np.array(source.support.normal)
    assert np.allclose(poses[:, :3, :3] @ normal, target.support.normal, atol=1e-9)
    foot = source.support.offset * normal
    heights = (poses[:, :3, :3] @ foot + poses[:, :3, 3]) @ np.array(target.support.normal)
    assert np.allclose(heights, target.support.offset, atol=1e-9)
    truth = np.linalg.inv(T_target) @ T_source
    away = Rotation.from_matrix(truth[:3, :3].T @ poses[:, :3, :3]).magnitude()
    assert np.degrees(away.min()) < 5.0


def test_the_plane_objects_to_tilt_and_height(sides):
    (source, T_source), (target, T_target) = sides
    known = Known(PriorConfig(plane=True))
    truth = np.linalg.inv(T_target) @ T_source
    assert known.objection(truth, source, target) == ''
    tilted = truth.copy()
    tilted[:3, :3] = Rotation.from_rotvec([0.4, 0.0, 0.0]).as_matrix() @ truth[:3, :3]
    assert 'supporting plane' in known.objection(tilted, source, target)
    raised = truth.copy()
    raised[:3, 3] += 20.0 * target.resolution * np.array(target.support.normal)
    assert 'mr' in known.objection(raised, source, target)
    assert Known(PriorConfig()).objection(tilted, source, target) == ''


def test_the_axis_objects_to_other_turns(sides):
    (source, _), (target, _) = sides
    known = Known(PriorConfig(axis=True), AXIS)
    good, other = turned([40.0, 40.0])
    assert known.objection(good, source, target) == ''
    other[:3, 3] += 20.0 * target.resolution
    assert "turntable's axis" in known.objection(other, source, target)
    assert len(known.starts(source, target, 10, np.random.default_rng(0))) == 180


def test_known_turns_and_order_object(sides):
    (source, _), (target, _) = sides
    forward, back, far = turned([40.0, -40.0, 70.0])
    step = Known(PriorConfig(axis=True, step_deg=40.0), AXIS, (math.radians(40.0),))
    assert step.objection(forward, source, target) == ''
    assert 'known turn' in step.objection(back, source, target)
    assert 'known turn' in step.objection(far, source, target)
    assert len(step.starts(source, target, 10, np.random.default_rng(0))) == 1
    order = Known(PriorConfig(axis=True, order=True), AXIS, None, -1)
    assert 'order of the views' in order.objection(forward, source, target)
    assert order.objection(back, source, target) == ''


def test_an_amount_is_known_before_the_axis_is(sides):
    (source, _), (target, _) = sides
    step = Known(PriorConfig(axis=True, step_deg=40.0), None, (math.radians(40.0),))
    forward, back, far = turned([40.0, -40.0, 70.0])
    assert step.admits(np.stack([forward, back, far]), source, target).tolist() == [
        True, True, False]
