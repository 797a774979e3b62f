# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Segmentation of many stations; truth: analytic scenes, in which every pixel is known."""

import numpy as np
import pytest
from reference.stations import Ball, Box, FIRST_BODY, Post, scores, shoot
from ros_rops.core.config import SegmentationConfig
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.segment import segment

NOISY = {'noise': 0.004, 'step': 0.001, 'flying': 0.5, 'lost': 0.01, 'size': (640, 480)}
POST = Post(0, 0, 0.04, 0.1)
BOX = Box((-0.06, -0.05, 0), (0.06, 0.05, 0.08))


def seen(degrees, distance, height=0.03):
    """Return a camera above the horizon, at this distance from a point over the table."""
    angle = np.deg2rad(degrees)
    eye = (1e-3, -distance * np.cos(angle), distance * np.sin(angle) + height)
    return {'eye': eye, 'target': (0, 0, height)}


SCENES = {
    'a wide flat top': (Box((-0.15, -0.12, 0), (0.15, 0.12, 0.08)), {'table': 9}),
    'a large plate 6 mm high': (Box((-0.12, -0.1, 0), (0.12, 0.1, 0.006)), {'table': 9}),
    'a thin stick': (Post(0, 0, 0.005, 0.15), seen(35, 0.5, 0.07)),
    'seen flat': (POST, seen(15, 0.5)),
    'seen flat before a wall': (POST, {'wall': 0.4, **seen(15, 0.5)}),
    'seen from above': (BOX, seen(80, 0.5)),
    'a ball from above': (Ball((0, 0, 0.05), 0.05), seen(80, 0.5)),
    'the table in the lower quarter': (
        POST, {'eye': (0, -0.5, 0.12), 'target': (0, 0, 0.14), 'table': 0.2, 'wall': 0.6}),
    'a round table before a wall': (POST, {'wall': 0.5, **seen(30, 0.6)}),
    'a small table before a wall': (POST, {'wall': 0.3, 'table': 0.15, **seen(25, 0.6)}),
    'near': (Post(0, 0, 0.03, 0.06), seen(40, 0.3)),
    'far': (Post(0, 0, 0.08, 0.2), {'table': 0.6, **seen(40, 1.5)}),
    'out at the bottom': (Box((-0.05, -0.5, 0), (0.05, -0.1, 0.06)), {'table': 9})}


@pytest.mark.parametrize('rolled', [False, True], ids=['upright', 'rolled'])
@pytest.mark.parametrize('scene', SCENES)
def test_the_object_alone_and_all_of_it(scene, rolled):
    body, station = SCENES[scene]
    shot = shoot([body], **NOISY, **station)
    frame, truth = shot.frame, shot.body == FIRST_BODY
    if rolled:
        frame = turned(frame)
        truth = np.rot90(truth)
    result = segment(frame, SegmentationConfig())
    precision, recall = scores(result.labels == Label.KEPT, truth)
    assert len(result.views) == 1
    assert precision > 0.99
    assert recall > 0.93


def turned(frame):
    """Return the frame of a camera rolled by a quarter turn."""
    x, y, z = np.moveaxis(np.rot90(frame.points), -1, 0)
    return type(frame)(
        frame.name, np.stack([y, -x, z], axis=-1), sensor=frame.sensor, frame_id=frame.frame_id)
