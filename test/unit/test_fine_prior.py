# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Refining with what the station knows; truth: an analytic body on an exact turntable."""

import numpy as np
import pytest
from reference import bumpy
from ros_rops.core.config import FineConfig
from ros_rops.core.fine import FineView, refine_shape
from ros_rops.core.fine_prior import FinePrior
from ros_rops.core.station import Axis
from ros_rops.core.station_axis import find_axis
from ros_rops.core.types import SupportPlane
from scipy.spatial.transform import Rotation

CONFIG = FineConfig()
SENSOR = bumpy.rigid(Rotation.from_rotvec([2.0, 0.3, -0.4]), np.array([4.0, -110.0, 60.0]))
UP = SENSOR[:3, :3].T @ [0.0, 0.0, 1.0]
ANGLES = np.radians([0.0, 40.0, 90.0, 150.0, 200.0, 260.0, 310.0])
FLOOR = -40.0


@pytest.fixture(scope='module', params=[0.12, 0.05])
def table(request):
    """Return views of a body (bumpy, or less so), poses and resolution; noise 0.5 mr."""
    turns = [bumpy.rigid(Rotation.from_rotvec([0, 0, a]), np.zeros(3)) for a in ANGLES]
    looks = [turn[:3, :3] @ [0.0, -0.87, 0.5] for turn in turns]
    views, poses, resolution = bumpy.views_of(looks, bumps=request.param, noise=0.5, count=9000)
    truth = [turn @ SENSOR for turn in turns]
    own = []
    for view, old, new in zip(views, poses, truth, strict=True):
        change = np.linalg.inv(new) @ old
        own.append(FineView(
            view.points @ change[:3, :3].T + change[:3, 3], view.normals @ change[:3, :3].T,
            view.boundary))
    return own, truth, resolution


def planes(truth):
    return [SupportPlane(
        tuple((pose[:3, :3].T @ [0.0, 0.0, 1.0]).tolist()), float(FLOOR - pose[2, 3]))
        for pose in truth]


def axis(tilt=0.0):
    """Return a first guess of the turntable's axis, tilted by `tilt` rad."""
    point = np.linalg.inv(SENSOR)[:3, 3] + tilt * 20.0
    direction = Rotation.from_rotvec([tilt, 0.0, 0.0]).apply(UP)
    return Axis(tuple(direction.tolist()), tuple(point.tolist()))


def lean(poses):
    """Return by how much (deg) the motions between views tilt the true axis, at most."""
    return max(np.degrees(np.arccos(np.clip(
        (np.linalg.inv(poses[0]) @ pose)[:3, :3] @ UP @ UP, -1.0, 1.0))) for pose in poses)


PRIORS = {
    'plane': lambda truth: FinePrior(planes(truth), None, 3.0),
    'axis': lambda truth: FinePrior([None] * len(truth), axis(0.05), 3.0),
    'both': lambda truth: FinePrior(planes(truth), axis(0.05), 3.0),
}


@pytest.mark.parametrize('kind', PRIORS)
def test_poses_obey_what_is_known_and_come_nearer_to_the_truth(table, kind):
    views, truth, resolution = table
    start = bumpy.disturbed(views, truth, resolution)
    free = refine_shape(views, start, resolution, CONFIG)
    bound = refine_shape(views, start, resolution, CONFIG, prior=PRIORS[kind](truth))
    assert find_axis([bound.poses], start[0][:3, 3], 0.1, 0.1 * resolution).share == 1.0 \
        or kind == 'plane'
    assert lean(bound.poses) < (0.8 if kind == 'axis' else 0.1)
    assert lean(bound.poses) < lean(free.poses)
    before, _ = bumpy.errors(views, free.poses, truth, resolution)
    after, _ = bumpy.errors(views, bound.poses, truth, resolution)
    assert after.mean() <= before.mean() + 0.02
    assert bound.residual_mr < 1.05 * free.residual_mr
    assert np.array_equal(bound.poses[0], start[0])


def test_heights_are_level(table):
    views, truth, resolution = table
    start = bumpy.disturbed(views, truth, resolution)
    bound = refine_shape(views, start, resolution, CONFIG, prior=PRIORS['plane'](truth))
    up = truth[0][:3, :3] @ UP
    heights = [
        (pose[:3, :3] @ (plane.offset * np.array(plane.normal)) + pose[:3, 3]) @ up
        for pose, plane in zip(bound.poses, planes(truth), strict=True)]
    assert np.ptp(heights) < 0.15 * resolution


def test_threads_and_units_change_nothing(table):
    views, truth, resolution = table
    start = bumpy.disturbed(views, truth, resolution)
    prior = PRIORS['axis'](truth)
    one, two = (
        refine_shape(views, start, resolution, CONFIG, threads=n, prior=prior) for n in (1, 2))
    assert all(np.array_equal(a, b) for a, b in zip(one.poses, two.poses, strict=True))
    scale = 1e-3
    small = [FineView(v.points * scale, v.normals, v.boundary) for v in views]
    shrunk = [pose.copy() for pose in start]
    for pose in shrunk:
        pose[:3, 3] *= scale
    guess = axis(0.05)
    prior = FinePrior(
        [None] * len(views), Axis(guess.direction, tuple(scale * c for c in guess.point)), 3.0)
    metres = refine_shape(small, shrunk, resolution * scale, CONFIG, prior=prior)
    for a, b in zip(one.poses, metres.poses, strict=True):
        assert np.allclose(a[:3, :3], b[:3, :3], atol=1e-4)
