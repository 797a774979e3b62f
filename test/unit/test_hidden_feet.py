# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Objects whose contact is not seen, and what only reaches in; truth: analytic scenes."""

from dataclasses import replace

import numpy as np
import pytest
from reference.stations import Ball, Box, FIRST_BODY, Post, scores, shoot
from ros_rops.core.config import SegmentationConfig
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.segment import segment

ALWAYS = SegmentationConfig(when='always')
NOISY = {'noise': 0.004, 'step': 0.001, 'flying': 0.5, 'lost': 0.01}
ARM = Box((0.03, -0.03, 0.06), (0.5, 0.02, 0.1))


@pytest.mark.parametrize('speck', [[], [Box((-0.1, -0.1, 0), (-0.09, -0.09, 0.012))]])
def test_an_object_that_hides_its_own_foot(speck):
    # A ball on a thin post, seen from above: the post is hidden.
    shot = shoot(
        [Ball((0, 0, 0.065), 0.05), Post(0, 0, 0.008, 0.03), *speck], **NOISY,
        eye=(0, -0.32, 0.45), size=(640, 480))
    assert not (shot.body == FIRST_BODY + 1).any()
    result = segment(shot.frame, ALWAYS)
    assert len(result.views) == 1
    precision, recall = scores(result.labels == Label.KEPT, shot.body == FIRST_BODY)
    assert precision > 0.98
    assert recall > 0.98


def test_an_object_whose_foot_another_hides_is_a_view_of_its_own():
    shot = shoot(
        [Box((-0.06, -0.14, 0), (0.06, -0.1, 0.1)), Post(0, 0.06, 0.035, 0.13)], **NOISY,
        eye=(0, -0.6, 0.3), target=(0, 0, 0.04), size=(640, 480))
    assert shot.height[shot.body == FIRST_BODY + 1].min() > 0.02
    result = segment(shot.frame, ALWAYS)
    assert len(result.views) == 2
    for k in range(2):
        assert scores(result.objects == k, shot.body == FIRST_BODY + k)[0] > 0.99


def test_a_hand_over_the_plane_is_no_object():
    shot = shoot([Post(-0.12, 0, 0.04, 0.1), ARM], **NOISY, table=9, size=(640, 480))
    result = segment(shot.frame, ALWAYS)
    assert len(result.views) == 1
    assert scores(result.labels == Label.KEPT, shot.body == FIRST_BODY)[0] > 0.99
    assert any('reaches into the image' in note for note in result.notes)


def test_an_object_cut_by_the_border_is_taken_and_said():
    shot = shoot([Box((0.1, -0.05, 0), (0.5, 0.05, 0.1))], **NOISY, table=9, size=(640, 480))
    result = segment(shot.frame, ALWAYS)
    assert scores(result.labels == Label.KEPT, shot.body == FIRST_BODY)[1] > 0.95
    assert 'an object reaches out of the image' in result.notes


def test_an_empty_frame_says_why():
    plane = segment(shoot([], noise=0.002).frame, ALWAYS)
    assert 'points on the supporting plane' in plane.why_empty
    beside = segment(shoot([]).frame, replace(ALWAYS, box_low_z_m=5.0))
    assert 'points outside of the crop box' in beside.why_empty
    frame = shoot([]).frame
    nothing = segment(replace(frame, points=np.full_like(frame.points, np.nan)), ALWAYS)
    assert nothing.why_empty.endswith('nothing is measured')


def test_a_tower_over_its_base_is_no_object_of_its_own():
    # Seen from above the tower's shaft is hidden.
    base, shaft, top = Box((-0.1, -0.06, 0), (0.1, 0.06, 0.02)), Post(0.05, 0, 0.01, 0.1), Box(
        (0.03, -0.025, 0.1), (0.08, 0.025, 0.13))
    shot = shoot([base, shaft, top], **NOISY, eye=(0, -0.1, 0.55), size=(640, 480))
    result = segment(shot.frame, ALWAYS)
    assert len(result.views) == 1
    assert scores(result.labels == Label.KEPT, shot.body >= FIRST_BODY)[1] > 0.95
