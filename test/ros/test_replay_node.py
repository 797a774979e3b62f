# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The replay node, heard by a real node in another process.

Truth: the bytes and times of the recordings, which rosbags' writers made or the project itself.
"""

from pathlib import Path
import signal

import numpy as np
import pytest
from reference.bags import cloud, image, info, SECOND, transform, write_bag

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros.listener import Listener, replay  # noqa: E402, I100
from ros_rops.core.types import RangeView  # noqa: E402
from ros_rops.recordings.mcap_files import create_mcap  # noqa: E402
from ros_rops.recordings.messages import Channel, Decoder, RawMessage  # noqa: E402
from ros_rops.recordings.storage import open_storage  # noqa: E402
from ros_rops.recordings.view_facts import decode_facts  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402, I100

DEPTH_TOPICS = ('depth/image', 'depth/camera_info', 'color/image')
SHAPE = (6, 8)
DEPTH = np.arange(1000, 1048, dtype='<u2').reshape(SHAPE)
RGB = np.arange(6 * 8 * 3, dtype=np.uint8).reshape(*SHAPE, 3)
POINTS = np.ones((*SHAPE, 3), np.float32)


def clouds(count: int, spacing_ns: int = SECOND) -> list:
    return [cloud(k * spacing_ns, POINTS * (k + 1)) for k in range(1, count + 1)]


def recorded(path: Path, topic: str) -> list[bytes]:
    with open_storage(path) as storage:
        return [bytes(raw.data) for raw in storage.messages(frozenset({topic}))]


def unpadded(found: list[bytes], sent: list[bytes]) -> list[bytes]:
    """Return what was found without the zeros by which the middleware fills up four bytes."""
    lengths = [len(data) for data in sent] + [0] * len(found)
    return [data[:n] if len(data) - n < 4 and not any(data[n:]) else data
            for data, n in zip(found, lengths, strict=False)]


def assert_same(found: list[bytes], sent: list[bytes]) -> None:
    assert unpadded(found, sent) == sent


def test_lock_step_sends_what_was_recorded_and_calls_the_station(tmp_path):
    path = write_bag(tmp_path, 'mcap', clouds(4))
    with Listener('/lock_step') as station:
        station.serve('finish')
        station.serve('save')
        with replay('/lock_step', recording=path, start_offset_s=1, loops=2, finish=True,
                    save=True) as node:
            said = station.until_end_of(node)
    assert_same(station.on('views'), recorded(path, '/points')[1:] * 2)
    assert station.called == ['finish', 'save']
    assert '6 frames sent' in said


def test_a_frame_waits_for_the_word_on_the_last_one(tmp_path):
    path = write_bag(tmp_path, 'mcap', clouds(3))
    # Somebody else's word on another frame is none on this one.
    with Listener('/silent', answers=False) as station:
        other = Listener('/silent', topics=())
        with other, replay('/silent', code=1, recording=path, reply_timeout_s=2.0) as node:
            assert station.until(lambda: len(station.on('views')) == 1)
            said = station.until_end_of(node)
    assert len(station.on('views')) == 1
    assert 'the station has no word on the frame of 1.000000000 s within reply_timeout_s' in said


def test_depth_images_come_after_what_belongs_to_them(tmp_path):
    records = [info(SECOND // 2, SHAPE)]
    for k in (1, 2, 3):
        stamp = k * SECOND
        records += [image(stamp, DEPTH + k, '16UC1'),
                    image(stamp + 1, RGB, 'bgr8', topic='/color/image', stamp_ns=stamp)]
    path = write_bag(tmp_path, 'mcap', records)
    with Listener('/depth', DEPTH_TOPICS) as station, replay('/depth', recording=path) as node:
        station.until_end_of(node)
    assert [topic for topic, _ in station.messages] == [
        'depth/camera_info', *['color/image', 'depth/image'] * 3]
    assert_same(station.on('depth/image'), recorded(path, '/depth/image'))
    assert_same(station.on('color/image'), recorded(path, '/color/image'))


def test_facts_go_before_their_view(tmp_path):
    path = tmp_path / 'views.mcap'
    views = [RangeView(f'view{k}.ply', POINTS.reshape(-1, 3).astype(float) * k, units='mm')
             for k in (1, 2)]
    with create_mcap(path) as mcap:
        for view in views:
            mcap.add_view(view)
    with Listener('/facts') as station, replay('/facts', recording=path) as node:
        station.until_end_of(node)
    assert [topic for topic, _ in station.messages] == ['view_facts', 'views'] * 2
    facts = [decode_facts(data) for data in station.on('view_facts')]
    assert [(one.name, one.units, one.stamp_ns) for one in facts] == [
        ('view1.ply', 'mm', None), ('view2.ply', 'mm', None)]


@pytest.mark.alone
def test_by_the_clock_with_transforms_from_a_ros1_bag(tmp_path):
    tf2 = pytest.importorskip('tf2_msgs.msg', reason='no tf2_msgs')
    spacing = SECOND // 5
    records = [transform(SECOND, 'world', 'eye', (1, 2, 3), topic='/tf_static')]
    for record in clouds(6, spacing):
        records += [transform(record.time_ns, 'world', 'table'), record]
    bag = write_bag(tmp_path, 'bag', records)
    same = write_bag(tmp_path, 'mcap', records)
    others = {'/tf': tf2.TFMessage, '/tf_static': tf2.TFMessage, '/clock': Clock}
    station = Listener('/clock_mode', answers=False, others=others)
    with station, replay('/clock_mode', recording=bag, mode='clock', rate=2) as node:
        station.until_end_of(node)
    # What ROS 1 recorded is sent as ROS 2 would have recorded it.
    assert_same(station.on('views'), recorded(same, '/points'))
    assert_same(station.on('/tf'), recorded(same, '/tf'))
    assert_same(station.on('/tf_static'), recorded(same, '/tf_static'))
    at = [time for (topic, _), time in zip(station.messages, station.arrived, strict=True)
          if topic == 'views']
    # A loaded machine may deliver late; it never delivers early.
    assert at[-1] - at[0] > 5 * spacing / 1e9 / 2 - 0.1
    kind = 'rosgraph_msgs/msg/Clock'
    clock = [Decoder().decode(RawMessage(Channel('', kind, 'cdr'), 0, data)).clock
             for data in station.on('/clock')]
    told = [one.sec * SECOND + one.nanosec for one in clock]
    assert told == sorted(told)
    assert told[0] >= spacing
    assert told[-1] == 6 * spacing
    assert len(told) >= 10


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM], ids=['SIGINT', 'SIGTERM'])
def test_it_ends_without_a_traceback_when_told_to(tmp_path, number):
    path = write_bag(tmp_path, 'mcap', clouds(3))
    with Listener('/ended') as station, replay('/ended', recording=path, loops=0) as node:
        assert station.until(lambda: len(station.on('views')) > 4)
        node.send(number)
        station.until_end_of(node)


def test_mistakes_are_said(tmp_path):
    path = write_bag(tmp_path, 'mcap', clouds(1))
    torn = tmp_path / 'torn.mcap'
    torn.write_bytes(b'no recording at all')
    cases = [
        ({}, 2, 'recording: must be given'),
        ({'recording': tmp_path / 'gone.mcap'}, 2, 'gone.mcap: cannot be read (No such file'),
        ({'recording': torn}, 2, 'torn.mcap: is not an MCAP file'),
        ({'recording': path, 'topics': '/other'}, 2, "there is no '/other' in the recording"),
        ({'recording': path, 'mode': 'fast'}, 2, "mode: 'fast' is none of lock_step, clock"),
        ({'recording': path, 'topic': '/other', 'wait_s': 0}, 1, 'did you mean topics?'),
        ({'recording': path, 'rate': 0}, 2, 'rate: 0.0 is below 0.001'),
        ({'recording': path, 'start_offset_s': 60}, 2, 'no frame 60 s after the first one'),
        ({'recording': path, 'wait_s': 0.5}, 1, 'nobody listens on /alone/views'),
    ]
    for parameters, code, text in cases:
        with replay('/alone', code=code, **parameters) as node:
            node.wait()
        assert text in node.output


def test_a_station_that_refuses_or_lacks_what_is_asked_for(tmp_path):
    path = write_bag(tmp_path, 'mcap', clouds(1))
    with Listener('/refusing') as station:
        station.serve('finish', success=False)
        with replay('/refusing', code=1, recording=path, finish=True) as node:
            assert 'rops_registration/finish: finish done' in station.until_end_of(node)
        with replay('/refusing', code=1, recording=path, save=True, wait_s=5.0) as node:
            assert 'save: there is no such service' in station.until_end_of(node)
    station = Listener('/mute', answers=False)
    with station, replay('/mute', code=1, recording=path, wait_s=5.0) as node:
        assert 'nobody publishes /mute/handled' in station.until_end_of(node)
    assert station.messages == []


def test_a_recording_that_breaks_off_is_played_to_there(tmp_path):
    whole = write_bag(tmp_path, 'mcap plain', clouds(20))
    torn = tmp_path / 'torn.mcap'
    torn.write_bytes(whole.read_bytes()[:whole.stat().st_size // 2])
    with Listener('/torn') as station, replay('/torn', recording=torn) as node:
        said = station.until_end_of(node)
    assert 'truncated or damaged' in said
    assert 0 < len(station.on('views')) < 20
    assert_same(station.on('views'), recorded(whole, '/points')[:len(station.on('views'))])
