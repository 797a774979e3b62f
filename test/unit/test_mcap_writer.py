# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings as we write them. Truth: what went in, and mcap's own decoder."""

from dataclasses import replace
import io
import json
from pathlib import Path

from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from msg_adapters import point_cloud2
import numpy as np
import pytest
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.types import RangeView, SensorModel, SupportPlane
from ros_rops.recordings.cdr import Transform
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.mcap_writer import McapStream
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.view_facts import decode_facts, FACTS_TOPIC, with_facts
from rosbags.highlevel import AnyReader

FULL_VIEW = RangeView(
    'scan 1.ply', np.array([[0.1, 0.2, 1 / 3], [-0.0, 2.0, 1e-300], [5.0, 1.0, 1e200]]),
    np.array([[-1, 0, 1], [2, -1, -1]]), SensorModel('orthographic', direction=(0.6, 0.0, -0.8)),
    np.array([[1, 2, 3], [4, 5, 6], [255, 0, 9]], np.uint8), 'mm', 1_700_000_000_123_456_789,
    'left eye', SupportPlane((0.0, 0.6, 0.8), 1 / 7))


def read_back(data: bytes) -> list[Frame]:
    """Decode by mcap's means and put the facts to the clouds."""
    frames, facts = [], None
    factory = DecoderFactory()
    for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages():
        if channel.topic == FACTS_TOPIC:
            facts = decode_facts(message.data)
        elif schema.name == 'sensor_msgs/msg/PointCloud2':
            cloud = factory.decoder_for('cdr', schema)(message.data)
            points, colors = point_cloud2.decode(cloud)
            frame = Frame('', points, colors, topic=channel.topic,
                          log_time_ns=message.log_time, frame_id=cloud.header.frame_id)
            frames.append(with_facts(frame, facts) if facts else frame)
            facts = None
    return frames


def stored(*views: RangeView, **options) -> list[RangeView]:
    stream = io.BytesIO()
    mcap = McapStream(stream, **options)
    for view in views:
        mcap.add_view(view)
    mcap.finish()
    return [frame.view for frame in read_back(stream.getvalue())]


def assert_same_view(a: RangeView, b: RangeView) -> None:
    for name in ('name', 'sensor', 'units', 'stamp_ns', 'frame_id', 'support'):
        assert getattr(a, name) == getattr(b, name), name
    for name in ('points', 'grid', 'colors'):
        left, right = getattr(a, name), getattr(b, name)
        assert (left is None) == (right is None), name
        if left is not None:
            assert (left.shape, left.dtype) == (right.shape, right.dtype), name
            assert left.tobytes() == right.tobytes(), name


@pytest.mark.parametrize('keep', ['buffered', 'flushed'])
def test_a_view_comes_back_bit_by_bit(keep):
    views = [
        FULL_VIEW,
        replace(FULL_VIEW, name='no colours', colors=None, support=None, stamp_ns=None),
        replace(FULL_VIEW, name='no grid', grid=None, units='unknown', sensor=SensorModel()),
        replace(FULL_VIEW, name='one row', grid=np.array([[0, -1, 1, 2]])),
        replace(FULL_VIEW, name='other order', grid=np.array([[2, -1], [0, 1]])),
        replace(FULL_VIEW, name='a pixel twice, a point without', grid=np.array([[2], [2]])),
        RangeView('nothing', np.zeros((0, 3))),
        RangeView('all holes', np.zeros((0, 3)), np.full((2, 3), -1),
                  colors=np.zeros((0, 3), np.uint8)),
        RangeView('no pixel', np.zeros((0, 3)), np.zeros((0, 4), np.int32)),
        replace(FULL_VIEW, name='before the epoch', stamp_ns=-5),
    ]
    for view, back in zip(views, stored(*views, keep=keep), strict=True):
        assert_same_view(view, back)


finite = st.floats(allow_nan=False, allow_infinity=False)
triple = st.tuples(finite, finite, finite)


@st.composite
def any_view(draw) -> RangeView:
    points = draw(hnp.arrays(np.float64, st.tuples(st.integers(0, 12), st.just(3)),
                             elements=finite))
    cells = st.integers(-1, len(points) - 1)
    return RangeView(
        draw(st.text(st.characters(), max_size=12)), points,
        draw(st.none() | hnp.arrays(np.int32, hnp.array_shapes(min_dims=2, max_dims=2),
                                    elements=cells)),
        SensorModel(draw(st.sampled_from(['pinhole', 'orthographic', 'unknown'])),
                    draw(triple), draw(triple)),
        draw(st.none() | hnp.arrays(np.uint8, points.shape)),
        draw(st.sampled_from(['m', 'mm', 'unknown'])),
        draw(st.none() | st.integers(0, 2**63 - 1)), draw(st.text(max_size=12)),
        draw(st.none() | st.builds(SupportPlane, triple, finite)))


@settings(max_examples=150, deadline=None)
@given(any_view())
def test_any_view_comes_back(view):
    back, = stored(view)
    assert_same_view(view, back)


@pytest.mark.parametrize('dtype', [np.float32, np.float64])
@pytest.mark.parametrize('shape', [(4, 5), (1, 5), (7,), (0,), (0, 3)])
def test_a_frame_comes_back(dtype, shape):
    rng = np.random.default_rng(1)
    points = rng.normal(size=(*shape, 3)).astype(dtype)
    points[rng.random(shape) < 0.3, 2] = np.nan
    colors = rng.integers(0, 255, points.shape).astype(np.uint8)
    frame = Frame('/cam@7', points, colors, SensorModel('pinhole'), 'mm', None, 'eye', '/cam', 7,
                  ('assumed something',))
    stream = io.BytesIO()
    mcap = McapStream(stream)
    mcap.add_frame(frame)
    mcap.finish()
    back, = read_back(stream.getvalue())
    for name in ('name', 'sensor', 'units', 'stamp_ns', 'frame_id', 'topic', 'log_time_ns',
                 'notes', 'view'):
        assert getattr(back, name) == getattr(frame, name), name
    np.testing.assert_array_equal(back.points, points)
    np.testing.assert_array_equal(back.colors, colors)


def count_whole(data: bytes) -> int:
    """Clouds that can be read of a file that breaks off."""
    count, topics = 0, {}
    try:
        for record in StreamReader(io.BytesIO(data)).records:
            if type(record).__name__ == 'Channel':
                topics[record.id] = record.topic
            elif type(record).__name__ == 'Message':
                count += topics[record.channel_id] == '/points'
    except Exception:
        return count
    return count


@pytest.mark.parametrize('compressed', [True, False])
def test_a_cut_file_loses_at_most_its_last_message(compressed):
    stream, ends = io.BytesIO(), []
    mcap = McapStream(stream, keep='flushed', compressed=compressed)
    for k in range(4):
        mcap.add_view(replace(FULL_VIEW, name=str(k)))
        ends.append(stream.tell())
    data = stream.getvalue()
    for cut in range(0, len(data) + 1, 7):
        assert count_whole(data[:cut]) >= sum(end <= cut for end in ends)
    assert count_whole(data) == 4


def test_depth_and_transforms_by_another_decoder():
    stream = io.BytesIO()
    mcap = McapStream(stream)
    depth = np.arange(12, dtype=np.uint16).reshape(3, 4)
    camera = Camera(4, 3, 5.0, 6.0, 1.5, 1.25)
    mcap.add_depth(depth, camera, topic='/d', info_topic='/i', stamp_ns=3_000_000_007,
                   frame_id='eye')
    T = np.eye(4)
    T[:3, 3] = 1, 2, 3
    mcap.add_transforms([Transform(T, 'a', 'b'), Transform(np.eye(4), 'a', 'c')], stamp_ns=4,
                        topic='/tf_static')
    mcap.finish()
    stream.seek(0)
    reader = make_reader(stream, decoder_factories=[DecoderFactory()])
    found = {c.topic: (c, m) for _, c, _, m in reader.iter_decoded_messages()}
    image, info = found['/d'][1], found['/i'][1]
    assert (image.encoding, image.step, image.header.stamp.nanosec) == ('16UC1', 8, 7)
    np.testing.assert_array_equal(np.frombuffer(image.data, '<u2').reshape(3, 4), depth)
    assert (info.height, info.width, list(info.d)) == (3, 4, [0.0] * 5)
    assert list(info.k) == [5, 0, 1.5, 0, 6, 1.25, 0, 0, 1]
    assert list(info.p) == [5, 0, 1.5, 0, 0, 6, 1.25, 0, 0, 0, 1, 0]
    channel, message = found['/tf_static']
    assert [t.child_frame_id for t in message.transforms] == ['b', 'c']
    assert message.transforms[0].transform.translation.z == 3
    assert 'transient_local' in channel.metadata['offered_qos_profiles']


class Full(io.BytesIO):
    """A disk that is full after some bytes."""

    def write(self, data):
        if self.tell() + len(data) > 3000:
            raise OSError(28, 'No space left on device')
        return super().write(data)


def test_a_full_disk_is_said():
    mcap = McapStream(Full(), name='run/journal.mcap', keep='flushed')
    view = replace(FULL_VIEW, points=np.random.default_rng(2).normal(size=(900, 3)), grid=None,
                   colors=None)
    with pytest.raises(InputError, match=r'run/journal.mcap: cannot be written \(No space'):
        mcap.add_view(view)


def test_nothing_is_left_of_a_failed_file(tmp_path):
    path = tmp_path / 'a.mcap'
    path.write_bytes(b'old')
    nameless = replace(FULL_VIEW, colors=np.zeros((3, 3), np.uint8))
    object.__setattr__(nameless, 'units', object())  # what no writer can write
    with pytest.raises(TypeError), create_mcap(path) as mcap:
        mcap.add_view(nameless)
    assert path.read_bytes() == b'old'
    assert list(tmp_path.iterdir()) == [path]
    # A folder that is missing, a file in its place, a device that is full.
    for bad in (tmp_path / 'x' / 'y', path / 'y', Path('/dev/full')):
        with pytest.raises(InputError, match='cannot be written'), create_mcap(bad) as mcap:
            mcap.add_view(FULL_VIEW)


@pytest.mark.parametrize('data', [
    b'', b'{', b'[]', b'{}', b'{"topic":"/p","kind":"view","name":"n","units":"inch"}',
    b'{"topic":"/p","kind":"view","name":"n","sensor":{"kind":"eye"}}',
    b'{"topic":"/p","kind":"view","name":"n","grid":{"shape":[9,9],"zlib_base64":"eJw="}}'])
def test_bad_facts_are_refused(data):
    with pytest.raises(InputError, match='facts that cannot be read'):
        decode_facts(data)


def test_facts_of_another_message_are_refused():
    stream = io.BytesIO()
    mcap = McapStream(stream)
    mcap.add_view(FULL_VIEW)
    mcap.finish()
    stream.seek(0)
    _, _, message = next(make_reader(stream).iter_messages(topics=FACTS_TOPIC))
    with pytest.raises(InputError, match='contradicts'):
        with_facts(Frame('', np.zeros((5, 5, 3))), decode_facts(message.data))


def test_rosbags_reads_what_we_write(tmp_path):
    with create_mcap(tmp_path / 'a.mcap') as mcap:
        mcap.add_view(FULL_VIEW)
        mcap.add_transforms([Transform(np.eye(4), 'a', 'b')], stamp_ns=4)
        mcap.add_depth(np.ones((3, 4), np.float32), Camera(4, 3, 5.0, 6.0, 1.5, 1.25), topic='/d',
                       info_topic='/i', stamp_ns=5, frame_id='eye')
    with AnyReader([tmp_path / 'a.mcap']) as reader:
        found = {c.topic: reader.deserialize(data, c.msgtype)
                 for c, _, data in reader.messages()}
    assert found.keys() == {FACTS_TOPIC, '/points', '/tf', '/i', '/d'}
    assert json.loads(found[FACTS_TOPIC].data)['name'] == FULL_VIEW.name
    points, _ = point_cloud2.decode(found['/points'])
    assert np.isin(FULL_VIEW.points, points).all()
    assert found['/d'].encoding == '32FC1'
    assert found['/i'].k[4] == 6.0
