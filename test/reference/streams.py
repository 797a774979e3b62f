# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Small recordings of procedural objects, as a camera that never stops would record them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from reference.captures import arc
from ros_rops.core.frame import Frame
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.view_facts import organized

START_NS, PERIOD_NS = 1_700_000_000_000_000_000, 500_000_000
TOPIC = '/camera/points'
STILL = [
    '--set', 'selection.method=still', '--set', 'selection.still_frames=2',
    '--set', 'selection.still_s=0']


def frames(scenes=8, repeats=3, names=('blob', 'bracket')):
    """Return frames: each scene stands for some frames, then the next is there."""
    made = []
    captures = [c for both in zip(*(arc(name) for name in names), strict=True) for c in both]
    for capture in captures[:scenes]:
        points, _ = organized(capture.view)
        for _ in range(repeats):
            made.append(frame(points.astype(np.float32), len(made)))
    return made


def frame(points, number, topic=TOPIC):
    """Return one frame of a stream."""
    time = START_NS + number * PERIOD_NS
    return Frame(
        f'{topic}@{time}', points, stamp_ns=time, frame_id='camera_optical_frame', topic=topic,
        log_time_ns=time)


def record(path: Path, made) -> Path:
    """Write frames as a recording."""
    with create_mcap(path) as mcap:
        for item in made:
            mcap.add_cloud(
                item.points, topic=item.topic, stamp_ns=item.stamp_ns, frame_id=item.frame_id)
    return path


def views(count=3):
    """Return finished views."""
    return [replace(capture.view, stamp_ns=None) for capture in arc('bracket')[:count]]
