# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The recording of a plush bear on a turntable (RealSense D435), and what is known of it.

Truth: the steps between its eight stops, read off stickers on the turntable to about a degree.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from ros_rops.core.config import Config
from ros_rops.intake.intake import Intake
from ros_rops.pipeline.session import Session
from ros_rops.recordings.frames import read_frames
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
RECORDING = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data')).parent \
    / 'recordings' / 'bear_d435'
STEPS = (56.5, 44.2, 54.6, 37.6, 44.0, 31.0, 37.1, 55.0)
RING = [(k, (k + 1) % 8) for k in range(8)]


def frames():
    """Return the eight frames, or skip the test."""
    if not RECORDING.is_dir():
        pytest.skip(f'no real recording: {RECORDING} is missing (set ROPS_DATA)')
    return list(read_frames(RECORDING))


def register(order=range(8), **parameters):
    """Return the finished session over the frames in that order, and their views' names."""
    config = Config.from_flat({k.replace('__', '.'): v for k, v in parameters.items()})
    session = Session(config, threads=2)
    intake = Intake(session, config, threads=2)
    seen = frames()
    for k in order:
        intake.take(seen[k])
    intake.finish()
    return session, [frame.name for frame in seen]


def poses(session, names):
    """Return T_object_view by stop for each object."""
    return [
        {names.index(view.name): view.T_object_view for view in model.views}
        for model in session.objects]


def motion(placed, a, b):
    """Return by how many degrees the table turned from stop `a` to `b`, and about what."""
    turn = Rotation.from_matrix((np.linalg.inv(placed[b]) @ placed[a])[:3, :3]).as_rotvec()
    return np.degrees(np.linalg.norm(turn)), turn / np.linalg.norm(turn)


def true_angle(a, b):
    """Return the turn from stop `a` to stop `b` by the stickers, 0 to 360 degrees."""
    return sum(STEPS[k % 8] for k in range(a, b if b > a else b + 8))


def true_turn(a, b, up):
    """Return the rotation from view `a` to view `b` by the stickers, about the plane's normal."""
    return Rotation.from_rotvec(-np.radians(true_angle(a, b)) * up)


def normal(session, names):
    """Return the mean normal of the supporting planes as the views show them."""
    mean = np.mean([session.views[name].support.normal for name in names], axis=0)
    return mean / np.linalg.norm(mean)


def residual_mm(session, names, placed, a, b):
    """
    Return the mean distance, in mm, of stop `a`'s points to the surface of `b`.

    As the residual of the evaluation, with lengths for this sensor: every 11th point within 3 mm,
    to the plane of its nearest neighbour, normals from the neighbours within 5 mm.
    """
    here, there = (session.views[names[k]].points for k in (a, b))
    moved = np.linalg.inv(placed[b]) @ placed[a]
    points = here[::11] @ moved[:3, :3].T + moved[:3, 3]
    tree = cKDTree(there)
    distance, nearest = tree.query(points)
    points, nearest = points[distance < 0.003], there[nearest[distance < 0.003]]
    total = []
    for point, near in zip(points, nearest, strict=True):
        support = there[tree.query_ball_point(near, 0.005)]
        normal = np.linalg.svd(support - support.mean(axis=0), full_matrices=False)[2][2]
        total.append(abs((point - near) @ normal))
    return 1e3 * float(np.mean(total))
