# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Frames of running sensors. Truth: the frames that the same messages give as a recording.

And of the clock: the times at which the messages are said to have come.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from reference.bags import cloud, image, info, JAZZY, Record
from ros_rops.core.errors import ParameterError
from ros_rops.core.frame import Frame
from ros_rops.recordings import cdr
from ros_rops.recordings.frames import read_frames
from ros_rops.recordings.live_frames import live_plan, LiveFrames
from ros_rops.recordings.messages import Channel, RawMessage
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.view_facts import encode_facts, FACTS_TOPIC, ViewFacts

BAGS = Path(__file__).resolve().parents[2] / 'bags'
SHAPE = (6, 8)
DEPTH = np.arange(1000, 1048, dtype='<u2').reshape(SHAPE)
RGB = np.arange(6 * 8 * 3, dtype=np.uint8).reshape(*SHAPE, 3)
MS = 1_000_000


def raw(record: Record, *, at_ms: float) -> RawMessage:
    data = bytes(JAZZY.serialize_cdr(record.make(JAZZY), record.kind))
    return RawMessage(Channel(record.topic, record.kind, 'cdr'), int(at_ms * MS), data)


def depth(stamp: int, at_ms: float) -> RawMessage:
    return raw(image(stamp, DEPTH, '16UC1'), at_ms=at_ms)


def camera(stamp: int, at_ms: float) -> RawMessage:
    return raw(info(stamp, SHAPE), at_ms=at_ms)


def color(stamp: int, at_ms: float) -> RawMessage:
    return raw(image(stamp, RGB, 'rgb8', topic='color/image'), at_ms=at_ms)


def points(stamp: int, at_ms: float, frame: str = 'eye') -> RawMessage:
    xyz = np.full((*SHAPE, 3), 1 + stamp, np.float32)
    return raw(cloud(stamp, xyz, topic='views', frame=frame), at_ms=at_ms)


def facts(stamp: int, at_ms: float, name: str = 'given', frame: str = 'eye') -> RawMessage:
    text = encode_facts(ViewFacts(
        '/elsewhere', 'frame', name, 'm', None, stamp, frame, SHAPE)).decode()
    return RawMessage(Channel(FACTS_TOPIC, 'std_msgs/msg/String', 'cdr'), int(at_ms * MS),
                      cdr.string_message(text))


def canonical(message: RawMessage) -> RawMessage:
    """Return a message as the station would have it; those above are named as if recorded."""
    names = {'/depth/image': 'depth/image', '/depth/camera_info': 'depth/camera_info'}
    topic = message.channel.topic
    return replace(message, channel=replace(message.channel, topic=names.get(topic, topic)))


def given(frames: LiveFrames, *messages: RawMessage) -> list[Frame | BadView]:
    return [frame for message in messages for frame in frames.add(canonical(message))]


def depths() -> LiveFrames:
    return LiveFrames(live_plan('depth'))


def clouds() -> LiveFrames:
    return LiveFrames(live_plan('cloud'))


@pytest.mark.parametrize(('bag', 'kind'), [('demo', 'cloud'), ('turning', 'depth')])
def test_frames_are_those_of_the_recording(bag, kind):
    names = {
        '/camera/depth/points': 'views', '/camera/depth/image_rect_raw': 'depth/image',
        '/camera/depth/camera_info': 'depth/camera_info', '/camera/color/image_raw': 'color/image'}
    frames = LiveFrames(live_plan(kind))
    found: list[Frame | BadView] = []
    with open_storage(BAGS / f'{bag}.mcap') as storage:
        for message in storage.messages(frozenset(names)):
            topic = names[message.channel.topic]
            found += frames.add(replace(
                message, channel=Channel(topic, message.channel.kind, 'cdr')))
    found += frames.flush(2**62)
    truth = list(read_frames(BAGS / f'{bag}.mcap'))
    assert len(found) == len(truth) >= 20
    for one, other in zip(found, truth, strict=True):
        assert one.points.tobytes() == other.points.tobytes()
        assert (one.colors is None) == (other.colors is None)
        assert other.colors is None or one.colors.tobytes() == other.colors.tobytes()
        assert (one.sensor, one.units, one.stamp_ns, one.frame_id, one.notes) == (
            other.sensor, other.units, other.stamp_ns, other.frame_id, other.notes)
    assert found[3].name == f'{found[3].topic}@{truth[3].stamp_ns}'


def test_depth_waits_for_its_messages_in_any_order():
    for order in ([0, 1, 2], [2, 1, 0], [1, 2, 0]):
        frames = depths()
        messages = [depth(7, 1), camera(7, 1), color(7, 1)]
        outcomes = [given(frames, messages[k]) for k in order]
        assert [len(one) for one in outcomes] == [0, 0, 1]
        np.testing.assert_array_equal(outcomes[2][0].colors, RGB)
        assert outcomes[2][0].name == 'depth/image@7'
        assert frames.due_ns is None


def test_depth_goes_on_without_colour_after_its_time():
    frames = depths()
    assert given(frames, camera(7, 0), depth(7, 1)) == []
    assert list(frames.flush(201 * MS)) == []
    assert frames.due_ns == 201 * MS + 1
    frame, = frames.flush(frames.due_ns)
    assert frame.colors is None
    # What has not come is not waited for again...
    frame, = given(frames, camera(40, 240), depth(40, 241))
    assert frame.colors is None
    # ... until it comes in time: then its frame had it nearly.
    assert given(frames, color(40, 250), camera(70, 260), depth(70, 261)) == []
    frame, = given(frames, color(70, 270))
    np.testing.assert_array_equal(frame.colors, RGB)


def test_depth_without_camera_info_is_refused_with_its_stamp():
    frames = depths()
    assert given(frames, color(7, 0), depth(7, 1)) == []
    bad, = frames.flush(1000 * MS)
    assert 'no CameraInfo came on depth/camera_info' in bad.reason
    assert (bad.name, bad.stamp_ns, bad.frame_id) == ('depth/image@7', 7, 'eye')


def test_camera_info_sent_once_serves_all_and_costs_no_time():
    frames = LiveFrames(live_plan('depth', color=False))
    assert given(frames, camera(0, 0), depth(7, 1)) == []
    assert len(list(frames.flush(300 * MS))) == 1
    assert len(given(frames, depth(40, 333))) == 1
    assert len(given(frames, depth(73, 366))) == 1


def test_a_fast_camera_does_not_fill_the_memory():
    frames = depths()
    found = [len(given(frames, depth(k, k))) for k in range(20)]
    assert found == [0] * 8 + [9] + [1] * 11


def test_cloud_without_facts_waits_for_nothing():
    frames = clouds()
    frame, = given(frames, points(5, 1))
    assert (frame.name, frame.topic, frame.frame_id, frame.stamp_ns) == (
        'views@5', 'views', 'eye', 5)


def test_facts_belong_to_the_cloud_of_their_header():
    frames = clouds()
    assert given(frames, facts(5, 0, 'five'), facts(6, 0, 'six')) == []
    found = given(frames, points(6, 1), points(5, 2), points(5, 3, frame='other'))
    assert [frame.name for frame in found] == ['six', 'five']
    # The facts of that one may be on their way, since all others had theirs.
    late, = given(frames, facts(5, 4, 'other five', 'other'))
    assert (late.name, late.frame_id) == ('other five', 'other')
    assert given(frames, points(8, 5)) == []
    plain, = frames.flush(300 * MS)
    assert plain.name == 'views@8'
    assert [frame.name for frame in given(frames, points(9, 400))] == ['views@9']


def test_facts_of_a_view_without_stamp():
    frames = clouds()
    no_stamp = replace(facts(0, 0), data=cdr.string_message(encode_facts(ViewFacts(
        '/points', 'view', 'bun000.ply', 'mm', None, None, 'eye', SHAPE)).decode()))
    frame, = given(frames, no_stamp, points(0, 1))
    assert (frame.name, frame.view.units, frame.view.stamp_ns) == ('bun000.ply', 'mm', None)


def test_facts_that_contradict_their_cloud_and_facts_that_are_none():
    frames = clouds()
    wrong = replace(facts(0, 0), data=cdr.string_message(encode_facts(ViewFacts(
        '/points', 'view', 'bun000.ply', 'mm', None, 5, 'eye', (3, 3))).decode()))
    bad, = given(frames, wrong, points(5, 1))
    assert 'contradicts' in bad.reason
    assert (bad.stamp_ns, bad.frame_id) == (5, 'eye')
    frames = clouds()
    noise = replace(facts(5, 0), data=cdr.string_message('hello'))
    assert [frame.name for frame in given(frames, noise, points(5, 1))] == ['views@5']
    for k in range(100):
        given(frames, facts(k, k, str(k)))
    assert [frame.name for frame in given(frames, points(92, 200))] == ['92']
    # Facts are kept for a few clouds; these are of one that never came.
    assert given(frames, points(91, 201)) == []
    assert [frame.name for frame in frames.flush(900 * MS)] == ['views@91']


def test_messages_that_cannot_be_read_between_good_ones():
    frames = clouds()
    broken = replace(points(5, 1), data=points(5, 1).data[:70])
    found = given(frames, points(4, 0), broken, points(6, 2), points(3, 3))
    assert [type(one) for one in found] == [Frame, BadView, Frame, Frame]
    assert (found[1].name, found[1].stamp_ns) == ('views@0', 0)
    assert 'the order is that of arrival' in found[3].notes[-1]


def test_what_is_stated_is_used():
    frame, = given(LiveFrames(live_plan('cloud'), units='mm', sensor='pinhole'), points(5, 1))
    assert (frame.units, frame.sensor.kind) == ('mm', 'pinhole')
    with pytest.raises(ParameterError, match='units'):
        LiveFrames(live_plan('cloud'), units='inch')
    bent = raw(info(7, SHAPE, distortion=(0.2, 0, 0, 0, 0)), at_ms=0)
    found = {}
    for rectified in (None, False, True):
        frames = LiveFrames(live_plan('depth', color=False), rectified=rectified)
        found[rectified], = given(frames, bent, depth(7, 1))
    assert np.array_equal(found[None].points, found[False].points)
    assert not np.allclose(found[True].points, found[False].points)
