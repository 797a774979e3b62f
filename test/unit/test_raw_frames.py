# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Which frames are raw; truth: frames of a station, their borders lost as cameras lose them."""

from dataclasses import replace

import numpy as np
import pytest
from reference.stations import FIRST_BODY, Post, shoot
from ros_rops.core.config import SegmentationConfig
from ros_rops.segmentation.segment import segment

POST = [Post(0, 0, 0.04, 0.1)]
LOST = {
    'nothing': (0, 0, 0, 0), 'a band at the left': (0, 0, 60, 0), 'a rim': (10, 10, 10, 10),
    'both': (10, 10, 60, 10), 'two columns': (0, 0, 2, 2)}


@pytest.mark.parametrize('table', [9, 0.3])
@pytest.mark.parametrize('lost', LOST)
def test_a_frame_with_a_lost_border_is_raw(lost, table):
    frame = shoot(POST, size=(640, 480), table=table, noise=0.002).frame
    top, bottom, left, right = LOST[lost]
    points = np.full_like(frame.points, np.nan)
    inside = slice(top, 480 - bottom), slice(left, 640 - right)
    points[inside] = frame.points[inside]
    result = segment(replace(frame, points=points), SegmentationConfig())
    assert result.segmented
    assert len(result.views) == 1


def test_what_was_cut_out_is_not_raw():
    shot = shoot(POST, size=(640, 480))
    points = shot.frame.points.copy()
    points[shot.body != FIRST_BODY] = np.nan
    whole = segment(replace(shot.frame, points=points), SegmentationConfig())
    assert whole.untouched
    # Near to one border, and wide.
    low = shoot(POST, size=(640, 480), eye=(0, -0.25, 0.2), target=(0, 0, 0.07))
    points = low.frame.points.copy()
    points[low.body != FIRST_BODY] = np.nan
    assert segment(replace(low.frame, points=points), SegmentationConfig()).untouched
