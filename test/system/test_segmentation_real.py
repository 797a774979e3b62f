# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Segmentation of a RealSense D435's frames. Truth: the station, which is known by eye."""

import os
from pathlib import Path

import numpy as np
import pytest
from ros_rops.core.config import SegmentationConfig
from ros_rops.recordings.frames import read_frames
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.segment import segment

DATA = os.environ.get('ROPS_DATA') or Path(__file__).resolve().parents[3] / 'shared' / 'data'
BEAR = Path(DATA).parent / 'recordings' / 'bear_d435'


@pytest.fixture(scope='module')
def cuts():
    if not BEAR.exists():
        pytest.skip(f'no recording at {BEAR}')
    return [segment(frame, SegmentationConfig()) for frame in read_frames(BEAR)]


def test_every_stop_gives_the_bear_alone(cuts):
    assert len(cuts) == 8
    for cut in cuts:
        assert len(cut.views) == 1
        assert 30000 < len(cut.views[0].points) < 52000
        assert cut.notes == ()
        view = cut.views[0]
        heights = view.points @ np.asarray(view.support.normal) - view.support.offset
        assert 0.0 <= heights.min() < 5e-4  # it keeps its feet
        assert 0.08 < heights.max() < 0.15  # and is 10 cm high: no background
        assert cut.counts[Label.PLANE] > 95000


def test_the_turntable_is_the_same_at_all_stops(cuts):
    normals = np.array([cut.plane.plane.normal for cut in cuts])
    mean = normals.mean(axis=0) / np.linalg.norm(normals.mean(axis=0))
    tilts = np.degrees(np.arccos(np.clip(normals @ mean, -1, 1)))
    assert tilts.max() < 0.2
    middle = np.mean([cut.views[0].points.mean(axis=0) for cut in cuts], axis=0)
    heights = [middle @ np.asarray(cut.plane.plane.normal) - cut.plane.plane.offset
               for cut in cuts]
    assert np.ptp(heights) < 0.001
    assert all(cut.plane.noise < 0.0006 for cut in cuts)
