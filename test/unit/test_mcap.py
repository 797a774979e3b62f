# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""MCAP recordings; truth: what the tests write, mcap's own decoder, and known recordings."""

from dataclasses import replace
import os
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from msg_adapters import point_cloud2
import numpy as np
import pytest
from ros_rops.core.errors import InputError
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.recordings import cdr
from ros_rops.recordings.frames import frame_view, read_frames
from ros_rops.recordings.mcap_files import write_mcap
from ros_rops.recordings.reader import BadView, NotedView
from ros_rops.recordings.sources import find_views, Recording
from ros_rops.recordings.synthetic import Capture, look_at
from ros_rops.recordings.view_facts import organized
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))
RECORDINGS = DATA.parent / 'recordings'
needs_recordings = pytest.mark.skipif(
    not RECORDINGS.is_dir(), reason=f'no recordings at {RECORDINGS}')


def read_views(path: Path, **stated: str):
    for frame in read_frames(path, **stated):
        yield frame if isinstance(frame, BadView) else frame_view(frame)


def captures(count: int) -> list[Capture]:
    rng = np.random.default_rng(8)
    result = []
    for k in range(count):
        grid = np.where(rng.random((12, 17)) < 0.3, -1, 0).astype(np.int32)
        rows, columns = np.nonzero(grid == 0)
        grid[rows, columns] = np.arange(len(rows))
        z = rng.uniform(1, 2, len(rows)).astype(np.float32).astype(float)
        points = np.stack([(columns - 8) / 16 * z, (rows - 6) / 16 * z, z], axis=1)
        points = points.astype(np.float32).astype(float)
        stamp = 1_700_000_000_123_456_789 + k * 1_000_000_000
        view = RangeView(
            f'/cloud@{stamp}', points, grid, SensorModel('pinhole'),
            rng.integers(0, 256, points.shape).astype(np.uint8), 'm', stamp, 'eye')
        pose = look_at(rng.normal(size=3), np.zeros(3), 0.3 * k)
        result.append(Capture(view, pose, 'cup'))
    return result


def write(path: Path, count: int = 3) -> list[Capture]:
    written = captures(count)
    write_mcap(path, written, topic='/cloud')
    return written


def test_round_trip(tmp_path):
    written = write(tmp_path / 'a.mcap')
    assert Recording(tmp_path / 'a.mcap').count() == 3
    back = list(read_views(tmp_path / 'a.mcap'))
    for capture, noted in zip(written, back, strict=True):
        assert isinstance(noted, NotedView)
        for name in ('name', 'sensor', 'units', 'stamp_ns', 'frame_id'):
            assert getattr(noted.view, name) == getattr(capture.view, name), name
        for name in ('points', 'grid', 'colors'):
            np.testing.assert_array_equal(getattr(noted.view, name), getattr(capture.view, name))


def test_poses_by_another_decoder(tmp_path):
    written = write(tmp_path / 'a.mcap')
    with (tmp_path / 'a.mcap').open('rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = [m for *_, m in reader.iter_decoded_messages(topics='/exact_poses')]
    for capture, message in zip(written, found, strict=True):
        item, = message.transforms
        assert (item.header.frame_id, item.child_frame_id) == ('cup', 'eye')
        stamp = item.header.stamp.sec * 1_000_000_000 + item.header.stamp.nanosec
        assert stamp == capture.view.stamp_ns
        t, q = item.transform.translation, item.transform.rotation
        T = capture.T_world_view
        np.testing.assert_allclose([t.x, t.y, t.z], T[:3, 3], atol=1e-15)
        R = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
        np.testing.assert_allclose(R, T[:3, :3], atol=1e-12)


def test_views_without_points_or_grid(tmp_path):
    view = captures(1)[0].view
    empty = replace(view, points=np.zeros((0, 3)), grid=np.full((4, 5), -1), colors=None)
    plain = replace(view, grid=None, colors=None, stamp_ns=view.stamp_ns + 1)
    write_mcap(tmp_path / 'a.mcap', [Capture(v, np.eye(4)) for v in (empty, plain)])
    first, second = (noted.view for noted in read_views(tmp_path / 'a.mcap'))
    assert first.points.shape == (0, 3)
    assert first.grid.shape == (4, 5)
    assert first.sensor.kind == 'unknown'
    np.testing.assert_array_equal(second.points, view.points)
    assert second.grid is None


def test_unorganized_points_in_an_optical_frame_are_seen_from_its_origin(tmp_path):
    view = replace(captures(1)[0].view, grid=None, colors=None)
    points = view.points * [1, 1, 0.2]  # so near that the points alone tell nothing
    for frame, kind in (('camera_optical_frame', 'pinhole'), ('base_link', 'orthographic')):
        write_mcap(tmp_path / 'a.mcap',
                   [Capture(replace(view, points=points, frame_id=frame), np.eye(4))])
        noted, = read_views(tmp_path / 'a.mcap')
        assert noted.view.sensor.kind == kind
    noted, = read_views(tmp_path / 'a.mcap', sensor='-x', units='mm')
    assert noted.view.sensor.direction == (-1, 0, 0)
    assert noted.view.units == 'mm'


def raw_file(path: Path, messages: list[bytes], encoding: str = 'cdr',
             schema: str = cdr.POINT_CLOUD2_SCHEMA, name: str = 'sensor_msgs/msg/PointCloud2'):
    with path.open('wb') as stream:
        writer = Writer(stream, compression=CompressionType.NONE)
        writer.start()
        known = writer.register_schema(name, 'ros2msg', schema.encode())
        channel = writer.register_channel('/p', encoding, known)
        for data in messages:
            writer.add_message(channel, 5, data, 5)
        writer.finish()


def good_message() -> bytes:
    view = captures(1)[0].view
    return cdr.point_cloud2(point_cloud2.encode(*organized(view)), 7, 'eye')


def test_bad_messages_do_not_end_the_rest(tmp_path):
    good = good_message()
    broken_sizes = bytearray(good)
    width_at = 4 + 8 + 4 + 4 + 4  # mark, stamp, length of 'eye\0', 'eye\0', height
    assert broken_sizes[width_at:width_at + 4] == (17).to_bytes(4, 'little')
    broken_sizes[width_at] = 200
    raw_file(tmp_path / 'a.mcap', [good, good[:100], b'', bytes(broken_sizes), good])
    outcomes = list(read_views(tmp_path / 'a.mcap'))
    kinds = [NotedView, BadView, BadView, BadView, NotedView]
    assert [type(o) for o in outcomes] == kinds
    assert [o.name for o in outcomes if isinstance(o, BadView)] == ['/p@5#2', '/p@5#3', '/p@5#4']
    assert 'cannot be decoded' in outcomes[1].reason
    assert 'row_step' in outcomes[3].reason
    assert outcomes[4].view.name == '/p@5#5'


def test_unknown_encoding_and_schema(tmp_path):
    raw_file(tmp_path / 'a.mcap', [good_message()], encoding='ros1')
    outcome, = read_views(tmp_path / 'a.mcap')
    assert "encoding 'ros1'" in outcome.reason
    raw_file(tmp_path / 'a.mcap', [good_message()], schema='nonsense here\n= ?')
    outcome, = read_views(tmp_path / 'a.mcap')
    assert 'cannot be decoded' in outcome.reason
    raw_file(tmp_path / 'a.mcap', [b''], name='std_msgs/msg/Empty', schema='')
    with pytest.raises(InputError, match='holds no sensor_msgs/msg/PointCloud2'):
        list(read_views(tmp_path / 'a.mcap'))


@pytest.mark.parametrize('share', [0.99, 0.6])
def test_truncated_recording_gives_what_it_has(tmp_path, share):
    path = tmp_path / 'a.mcap'
    good = good_message()
    with path.open('wb') as stream:
        writer = Writer(stream, chunk_size=2 * len(good))
        writer.start()
        known = writer.register_schema(
            'sensor_msgs/msg/PointCloud2', 'ros2msg', cdr.POINT_CLOUD2_SCHEMA.encode())
        channel = writer.register_channel('/p', 'cdr', known)
        for k in range(20):
            writer.add_message(channel, k, good, k)
        writer.finish()
    data = path.read_bytes()
    path.write_bytes(data[:int(share * len(data))])
    outcomes = list(read_views(path))
    assert isinstance(outcomes[-1], BadView)
    assert 'truncated or damaged after' in outcomes[-1].reason
    assert len(outcomes) > 5
    assert all(isinstance(o, NotedView) for o in outcomes[:-1])
    assert Recording(path).count() == len(outcomes) - 1


def test_damaged_chunk_is_noticed(tmp_path):
    write(tmp_path / 'a.mcap')
    data = bytearray((tmp_path / 'a.mcap').read_bytes())
    data[len(data) // 3] ^= 0xFF
    (tmp_path / 'a.mcap').write_bytes(data)
    assert isinstance(list(read_views(tmp_path / 'a.mcap'))[-1], BadView)


def test_no_recording(tmp_path):
    path = tmp_path / 'a.mcap'
    for data, words in ((b'', 'is empty'), (b'ply\n', 'not an MCAP'), (b'\x89MCAP0', 'not an')):
        path.write_bytes(data)
        with pytest.raises(InputError, match=words):
            list(read_views(path))
        with pytest.raises(InputError, match=words):
            Recording(path).count()
        outcome, = find_views([path])[0].views()
        assert words in outcome.reason
    with pytest.raises(InputError, match='cannot be read'):
        Recording(tmp_path / 'none.mcap').count()


def test_writer_refuses(tmp_path):
    capture = captures(1)[0]
    with pytest.raises(InputError, match='no stamp'):
        write_mcap(tmp_path / 'a.mcap',
                   [replace(capture, view=replace(capture.view, stamp_ns=None))])
    with pytest.raises(InputError, match='cannot be written'):
        write_mcap(tmp_path / 'none' / 'a.mcap', [capture])


@needs_recordings
def test_real_depth_camera():
    source, = find_views([RECORDINGS / 'bear_d435' / 'bear_d435_rosbag2.mcap'])
    assert source.count() == 8
    view = next(iter(source.views())).view
    assert view.grid.shape == (480, 640)
    assert 250_000 < len(view.points) < 640 * 480
    assert view.sensor == SensorModel('pinhole')
    assert (view.units, view.frame_id) == ('m', 'camera_depth_optical_frame')
    rows, columns = np.nonzero(view.grid >= 0)
    u = view.points[view.grid[rows, columns], 0] / view.points[view.grid[rows, columns], 2]
    assert np.corrcoef(u, columns)[0, 1] > 0.999999  # not transposed, not scrambled


@needs_recordings
def test_other_recordings():
    gazebo, = find_views([RECORDINGS / 'gazebo_d435_points.mcap'])
    outcomes = list(gazebo.views())
    assert len(outcomes) == gazebo.count() == 12
    assert {o.view.sensor.kind for o in outcomes} == {'pinhole'}
    ros1, = find_views([RECORDINGS / 'ouster_ros1_profile.mcap'])
    assert [o.view.grid.shape for o in ros1.views()] == 2 * [(64, 2048)]
