# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Recordings as messages for a station. Truth: the frames that `read_frames` makes of them.

What is sent is heard by `LiveFrames`, as it would be by a station.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest
from reference.bags import (
    cloud, FORMATS, image, info, Record, SECOND, transform, write_bag)
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.types import RangeView
from ros_rops.recordings.frames import read_frames
from ros_rops.recordings.live_frames import live_plan, LiveFrames
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.messages import Channel, RawMessage
from ros_rops.recordings.playback import open_playback, Piece, Playback

SHAPE = (6, 8)
DEPTH = np.arange(1000, 1048, dtype='<u2').reshape(SHAPE)
RGB = np.arange(6 * 8 * 3, dtype=np.uint8).reshape(*SHAPE, 3)
POINTS = np.ones((*SHAPE, 3), np.float32)
KINDS = {
    'views': 'sensor_msgs/msg/PointCloud2', 'depth/image': 'sensor_msgs/msg/Image',
    'depth/camera_info': 'sensor_msgs/msg/CameraInfo', 'color/image': 'sensor_msgs/msg/Image',
    '/view_facts': 'std_msgs/msg/String'}


def in_step(playback: Playback) -> Iterator[Piece]:
    for shot in playback.shots():
        assert not shot.frame.fault
        yield from (*([shot.facts] if shot.facts else []), *shot.beside, shot.frame)


def heard(playback: Playback, pieces: Iterable[Piece]) -> list[Frame]:
    frames = LiveFrames(live_plan(playback.kind, color=playback.color))
    found = []
    for piece in pieces:
        raw = RawMessage(
            Channel(piece.topic, KINDS[piece.topic], 'cdr'), piece.log_time_ns, piece.data)
        found += frames.add(raw)
    return [*found, *frames.flush(2**62)]


def check(path: Path, *topics: str) -> list[Frame]:
    truth = list(read_frames(path, topics=topics))
    with open_playback(path, topics) as playback:
        for pieces in (in_step(playback), playback.pieces()):
            found = heard(playback, pieces)
            assert len(found) == len(truth)
            for one, other in zip(found, truth, strict=True):
                np.testing.assert_array_equal(one.points, other.points)
                np.testing.assert_array_equal(one.colors, other.colors)
                assert (one.stamp_ns, one.frame_id, one.sensor, one.units) == (
                    other.stamp_ns, other.frame_id, other.sensor, other.units)
    return found


def depth_records(topic: str = '/depth/image', **lens: object) -> list[Record]:
    where = topic.rpartition('/')[0] + '/camera_info'
    records = []
    for k in range(1, 4):
        stamp = k * SECOND
        records += [info(stamp, SHAPE, topic=where, **lens),
                    image(stamp, DEPTH + k, '16UC1', topic=topic),
                    image(stamp, RGB + k, 'bgr8', topic='/color')]
    return records


@pytest.mark.parametrize('kind', FORMATS)
def test_clouds_and_depth_images_of_every_kind_of_recording(tmp_path, kind):
    (tmp_path / 'depth').mkdir()
    check(write_bag(tmp_path, kind, [cloud(k, POINTS * k) for k in range(1, 4)]))
    found = check(write_bag(tmp_path / 'depth', kind, depth_records()))
    assert all(frame.colors is not None for frame in found)


@pytest.mark.parametrize('kind', ['mcap', 'bag'])
@pytest.mark.parametrize('topic', ['/depth/image_rect_raw', '/depth/image_raw'])
def test_the_lens_is_taken_out_once(tmp_path, kind, topic):
    path = write_bag(tmp_path, kind, depth_records(topic, distortion=(0.2, 0, 0, 0, 0)))
    check(path)
    with open_playback(path) as playback:
        assert playback.rectified == ('rect' in topic)


def test_camera_info_that_was_recorded_once_and_late(tmp_path):
    records = [image(k, DEPTH + k, '16UC1') for k in (1, 2, 3)]
    check(write_bag(tmp_path, 'mcap', [*records, info(4, SHAPE)]))


def test_views_with_facts(tmp_path):
    path = tmp_path / 'views.mcap'
    xyz = np.arange(30.0).reshape(-1, 3)
    with create_mcap(path) as mcap:
        for k in range(3):
            mcap.add_view(RangeView(f'{k}.ply', xyz + k, units='mm'), topic='/there')
    found = check(path)
    assert [frame.name for frame in found] == ['0.ply', '1.ply', '2.ply']
    assert [frame.view.units for frame in found] == ['mm'] * 3


def test_begins_where_it_is_told_to(tmp_path):
    records = [cloud(k * SECOND, POINTS * k) for k in range(1, 6)]
    records += [transform(k * SECOND, 'world', 'eye') for k in range(1, 6)]
    records += [transform(SECOND, 'world', 'table', topic='/tf_static')]
    path = write_bag(tmp_path, 'mcap', records)
    with open_playback(path, start_offset_s=2.5) as playback:
        assert playback.start_ns == 3_500_000_000
        assert [shot.stamp_ns // SECOND for shot in playback.shots()] == [4, 5]
        assert [piece.log_time_ns // SECOND for piece in playback.pieces()] == [4, 5]
        assert [piece.topic for piece in playback.moving_transforms()] == ['/tf'] * 2
        assert [piece.topic for piece in playback.static_transforms()] == ['/tf_static']
        assert playback.has_transforms
    late = pytest.raises(InputError, match='start_offset_s: no frame 5 s after the first one')
    with late, open_playback(path, start_offset_s=5.0):
        pass


def test_what_no_station_can_hear(tmp_path):
    records = [*depth_records('/left/image'), *depth_records('/right/image'), cloud(1, POINTS)]
    path = write_bag(tmp_path, 'mcap', records)
    for topics in (['/left/image', '/right/image'], ['/points', '/left/image']):
        several = pytest.raises(InputError, match='takes point clouds, or one depth camera; name')
        with several, open_playback(path, topics):
            pass
    check(path, '/left/image')


def test_messages_that_cannot_be_sent_are_told(tmp_path):
    whole = write_bag(tmp_path, 'mcap plain', [cloud(k, POINTS * k) for k in range(1, 20)])
    torn = tmp_path / 'torn.mcap'
    torn.write_bytes(whole.read_bytes()[:whole.stat().st_size // 2])
    with open_playback(torn) as playback:
        shots = list(playback.shots())
        assert [bool(shot.frame.fault) for shot in shots] == [False] * (len(shots) - 1) + [True]
        assert 'truncated or damaged' in shots[-1].frame.fault
        assert 'truncated or damaged' in list(playback.pieces())[-1].fault
    broken = tmp_path / 'broken.mcap'
    with create_mcap(broken) as mcap:
        mcap.add_cloud(POINTS, topic='/points', stamp_ns=1, frame_id='eye')
        mcap.add('/points', 'sensor_msgs/msg/PointCloud2', b'\0\1\0\0nonsense', 2)
        mcap.add_cloud(POINTS, topic='/points', stamp_ns=3, frame_id='eye')
    with open_playback(broken) as playback:
        faults = [shot.frame.fault for shot in playback.shots()]
    assert [bool(fault) for fault in faults] == [False, True, False]
    assert 'cannot be decoded' in faults[1]
