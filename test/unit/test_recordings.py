# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of every kind of recording; truth: what rosbags' and mcap's own writers were given."""

from pathlib import Path
import tracemalloc

import numpy as np
import pytest
from reference.bags import (
    cloud, FORMATS, Record, SECOND, storage_file, text, transform, write_bag, write_ros1)
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.recordings.frames import count_frames, frame_view, read_frames
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.sources import find_views, Recording
from rosbags.rosbag1 import Writer as Ros1Writer

SHAPE = (6, 8)


def points(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    xyz = rng.uniform(1, 2, (*SHAPE, 3)).astype(np.float32)
    xyz[rng.random(SHAPE) < 0.2] = np.nan
    return xyz


def clouds(count: int) -> list[Record]:
    records = []
    for k in range(count):
        time = (100 + k) * SECOND + k
        records += [text(time - 5), cloud(time, points(k)), transform(time + 5, 'a', 'b')]
    return records


def check(frames: list, count: int) -> None:
    assert all(isinstance(frame, Frame) for frame in frames), frames
    assert [f.log_time_ns for f in frames] == [(100 + k) * SECOND + k for k in range(count)]
    for k, frame in enumerate(frames):
        assert frame.name == f'/points@{frame.log_time_ns}'
        assert (frame.topic, frame.units, frame.frame_id) == ('/points', 'm', 'eye')
        assert frame.stamp_ns == frame.log_time_ns
        assert frame.points.dtype == np.float32
        np.testing.assert_array_equal(frame.points, points(k))


@pytest.mark.parametrize('kind', FORMATS)
def test_every_kind(tmp_path, kind):
    path = write_bag(tmp_path, kind, clouds(9))
    check(list(read_frames(path)), 9)
    assert count_frames(path) == 9
    source, = find_views([path])
    assert source == Recording(path)
    assert [o.view.name for o in source.views()] == [f.name for f in source.frames()]


@pytest.mark.parametrize('kind', FORMATS)
@pytest.mark.parametrize('share', [0.6, 0.9, 0.999])
def test_broken_off(tmp_path, kind, share):
    """Everything before the cut is read, and the loss is said last."""
    noise = np.random.default_rng(3).random((20, 60, 80, 3), np.float32)  # nothing to compress
    path = write_bag(tmp_path, kind, [cloud(k, xyz) for k, xyz in enumerate(noise)])
    file = storage_file(path)
    file.write_bytes(file.read_bytes()[:int(share * file.stat().st_size)])
    *frames, last = read_frames(path)
    if isinstance(last, Frame):  # only the index of times is lost, of which we make no use
        assert kind.startswith('sqlite3')
        frames.append(last)
    else:
        assert 'truncated or damaged after' in last.reason
        assert f'after {len(frames)} view' in last.reason
    times = [frame.log_time_ns for frame in frames]
    for time, frame in zip(times, frames, strict=True):
        np.testing.assert_array_equal(frame.points, noise[time])
    if kind.startswith('sqlite3'):  # a tree: what is lost need not be the last
        assert times == sorted(set(times))
        assert count_frames(path) >= len(frames) >= int(20 * share) - 6
    else:
        assert times == list(range(len(frames)))
        assert count_frames(path) == len(frames) >= int(20 * share) - (8 if 'bz2' in kind else 2)


@pytest.mark.parametrize('share', [0.3, 0.6, 0.9])
@pytest.mark.parametrize(('compression', 'lost'), [  # bz2 gives whole blocks of 0.9 MB
    (None, 2), (Ros1Writer.CompressionFormat.LZ4, 2), (Ros1Writer.CompressionFormat.BZ2, 6)])
def test_a_bag_broken_off_within_its_only_chunk(tmp_path, compression, lost, share):
    """Recorders write chunks of many messages; those before the cut are whole."""
    noise = np.random.default_rng(4).random((20, 200, 100, 3), np.float32)
    path = tmp_path / 'a.bag'
    write_ros1(path, [cloud(k, xyz) for k, xyz in enumerate(noise)], compression, chunk=2**24)
    path.write_bytes(path.read_bytes()[:int(share * path.stat().st_size)])
    *frames, last = read_frames(path)
    assert isinstance(last, BadView) and 'its last record lacks' in last.reason
    assert count_frames(path) == len(frames) >= 20 * share - lost
    for k, frame in enumerate(frames):
        assert frame.log_time_ns == k
        np.testing.assert_array_equal(frame.points, noise[k])


@pytest.mark.parametrize('damage', ['gone', 'rosbag2_bagfile_information: ['])
def test_packed_messages_are_known_without_metadata(tmp_path, damage):
    path = write_bag(tmp_path, 'sqlite3 message', clouds(3))
    metadata = path / 'metadata.yaml'
    if damage == 'gone':
        metadata.unlink()
        path = storage_file(path)
    else:
        metadata.write_text(damage)
    check(list(read_frames(path)), 3)


@pytest.mark.parametrize('kind', ['sqlite3', 'folder mcap', 'sqlite3 file'])
def test_several_files_and_lost_metadata(tmp_path, kind):
    first = write_bag(tmp_path / 'one', kind, clouds(9)[:15])
    second = write_bag(tmp_path / 'two', kind, clouds(9)[15:])
    names = []
    for k, folder in enumerate((first, second)):
        file = storage_file(folder)
        names.append(file.name.replace('a.', f'a_{k}.'))
        file.rename(first / names[-1])
    metadata = first / 'metadata.yaml'
    words = metadata.read_text()
    listed = ''.join(f'  - {name}\n' for name in names)
    metadata.write_text(words.replace(f'  - a.{names[0].partition(".")[2]}\n', listed, 1))
    check(list(read_frames(first)), 9)
    assert count_frames(first) == 9
    metadata.write_text('rosbag2_bagfile_information: [')
    check(list(read_frames(first)), 9)
    metadata.unlink()
    sources = find_views([first])
    assert [source.path.name for source in sources] == names
    check([frame for source in sources for frame in source.frames()], 9)


def test_a_file_of_the_folder_is_missing(tmp_path):
    path = write_bag(tmp_path, 'sqlite3', clouds(3))
    metadata = path / 'metadata.yaml'
    words = metadata.read_text()
    metadata.write_text(words.replace('  - a.db3\n', '  - gone.db3\n  - a.db3\n', 1))
    *frames, last = read_frames(path)
    check(frames, 3)
    assert 'gone.db3' in last.reason and 'cannot be read' in last.reason
    (path / 'a.db3').unlink()
    with pytest.raises(InputError, match='none of its files can be read'):
        list(read_frames(path))


def test_a_damaged_message_in_a_packed_recording(tmp_path):
    path = write_bag(tmp_path, 'sqlite3 message', clouds(3))
    file = storage_file(path)
    file.write_bytes(file.read_bytes().replace(b'\x28\xb5\x2f\xfd', b'\x28\xb5\x2f\xff'))
    outcomes = list(read_frames(path))
    assert [type(outcome) for outcome in outcomes] == 3 * [BadView]
    assert 'compressed message is damaged' in outcomes[0].reason


def test_names_stay_unique(tmp_path):
    twins = [cloud(5, points(k)) for k in range(3)]
    path = write_bag(tmp_path, 'mcap', twins)
    assert [frame.name for frame in read_frames(path)] == [
        '/points@5', '/points@5#2', '/points@5#3']


def test_topics_named(tmp_path):
    records = [
        cloud(1, points(1), topic='/left'), cloud(2, points(2), topic='/right'), text(3)]
    path = write_bag(tmp_path, 'mcap', records)
    assert [frame.topic for frame in read_frames(path)] == ['/left', '/right']
    assert [frame.topic for frame in read_frames(path, topics=['/right'])] == ['/right']
    assert [frame.topic for frame in read_frames(path, topics=['right'])] == ['/right']
    assert count_frames(path, ['/right']) == 1
    with pytest.raises(InputError, match=r"no '/front'.* holds .*/left \(sensor_msgs/msg/Point"):
        list(read_frames(path, topics=['/front']))
    with pytest.raises(InputError, match="'/chatter' is of type 'std_msgs/msg/String', neither"):
        count_frames(path, ['/chatter'])


def test_nothing_to_read(tmp_path):
    path = write_bag(tmp_path, 'mcap', [text(1)])
    with pytest.raises(InputError, match=r'no depth image; it holds /chatter \(std_msgs'):
        list(read_frames(path))
    path = write_bag(tmp_path, 'mcap', [])
    with pytest.raises(InputError, match='it holds no message'):
        list(read_frames(path))
    for name in ('a.bag', 'a.db3', 'b.mcap'):
        for data, words in ((b'', 'is empty'), (b'nonsense and more', 'not a')):
            (tmp_path / name).write_bytes(data)
            with pytest.raises(InputError, match=words):
                count_frames(tmp_path / name)
    (tmp_path / 'empty').mkdir()
    for name in ('none.bag', 'none.db3', 'empty', 'a.doc'):
        with pytest.raises(InputError):
            count_frames(tmp_path / name)


def test_stamps_that_go_backwards(tmp_path):
    records = [cloud(k, points(k), stamp_ns=stamp) for k, stamp in enumerate((30, 10, 20))]
    frames = list(read_frames(write_bag(tmp_path, 'mcap', records)))
    assert [frame.stamp_ns for frame in frames] == [30, 10, 20]
    assert [len(frame.notes) for frame in frames] == [0, 1, 0]
    assert 'before that of the frame before' in frames[1].notes[0]


def test_messages_come_in_the_order_of_log_time(tmp_path):
    records = [cloud(k, points(k)) for k in (3, 1, 2)]
    for kind in ('mcap', 'sqlite3', 'bag'):
        path = write_bag(tmp_path, kind, records)
        assert [frame.log_time_ns for frame in read_frames(path)] == [1, 2, 3]


def test_holes_of_all_sorts(tmp_path):
    xyz = points(1)
    xyz[0, :3] = 0
    xyz[1, 0, 0] = np.inf
    frame, = read_frames(write_bag(tmp_path, 'mcap', [cloud(1, xyz)]))
    assert np.isnan(frame.points[0, :3]).all()
    assert np.isnan(frame.points[1, 0]).all()
    assert frame.notes == ('3 points at (0, 0, 0) taken as holes',)
    view = frame_view(frame).view
    assert len(view.points) == np.isfinite(frame.points).all(axis=-1).sum()
    np.testing.assert_array_equal(view.points[view.grid[5, 5]], xyz[5, 5])


def test_units_and_sensor_stated(tmp_path):
    path = write_bag(tmp_path, 'mcap', [cloud(1, points(1))])
    frame, = read_frames(path, units='mm', sensor='-z')
    assert (frame.units, frame.sensor.kind, frame.sensor.direction) == (
        'mm', 'orthographic', (0, 0, -1))
    np.testing.assert_array_equal(frame.points, points(1))
    for wrong in ({'units': 'inch'}, {'sensor': 'left'}):
        with pytest.raises(ValueError, match='is none of'):
            list(read_frames(path, **wrong))


@pytest.mark.parametrize('kind', ['mcap', 'mcap plain', 'sqlite3', 'sqlite3 message', 'bag'])
def test_memory_does_not_grow_with_the_recording(tmp_path, kind):
    xyz = np.random.default_rng(1).random((100, 100, 3))  # 120 kB each, 7 MB in all
    path = write_bag(tmp_path, kind, [cloud(k, xyz) for k in range(60)])
    list(read_frames(path))  # what is loaded once
    tracemalloc.start()
    assert sum(isinstance(frame, Frame) for frame in read_frames(path)) == 60
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2.5e6


def test_folder_path_is_not_confused_with_views(tmp_path):
    path = write_bag(tmp_path, 'folder mcap', clouds(2))
    assert find_views([path]) == [Recording(path)]
    assert find_views([tmp_path / 'a' / 'a.mcap']) == [Recording(Path(tmp_path / 'a' / 'a.mcap'))]
