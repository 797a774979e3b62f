# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whatever the bytes, a recording yields frames, says what is bad, or raises InputError."""

from pathlib import Path
import tempfile
import time
import tracemalloc
from types import SimpleNamespace

from hypothesis import given, settings, strategies as st
from msg_adapters import camera_info, depth_image, point_cloud2, transforms
import numpy as np
import pytest
from reference.bags import (
    cloud, FORMATS, image, info, JAZZY, NOETIC, storage_file, text, transform, write_bag)
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.recordings.frames import count_frames, frame_view, read_frames
from ros_rops.recordings.messages import Channel, Decoder, RawMessage
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.transforms import read_transforms

QUICK = settings(max_examples=8, deadline=None)
RNG = np.random.default_rng(5)
RECORDS = [
    record for k in range(4) for record in (
        text(10 * k), transform(10 * k, 'a', 'b'), info(10 * k, (20, 30)),
        image(10 * k, RNG.integers(0, 3000, (20, 30)).astype('<u2'), '16UC1'),
        cloud(10 * k, RNG.random((20, 30, 3))))]


@pytest.fixture(scope='module')
def recordings(tmp_path_factory):
    # A function: hypothesis would print the bytes.
    paths = {
        kind: write_bag(tmp_path_factory.mktemp('bags'), kind, RECORDS) for kind in FORMATS}
    content = {kind: storage_file(path).read_bytes() for kind, path in paths.items()}
    return lambda kind: (paths[kind], content[kind])


def read_all(path: Path) -> None:
    """Read a recording in every way; nothing may be raised but InputError."""
    for topics in ((), ('/depth/image', '/points')):
        try:
            for frame in read_frames(path, topics=topics):
                assert isinstance(frame, Frame | BadView)
                if isinstance(frame, Frame):
                    assert frame.points.size <= 3 * 20 * 30
                    frame_view(frame)
            count_frames(path, topics)
            read_transforms(path)
        except InputError as error:
            words = str(error)
        else:
            continue
        assert str(path) in words


def damaged(recordings, kind: str, change) -> None:
    """Read the recording with its storage file changed, and put it right again."""
    path, data = recordings(kind)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / path.name
        file = target
        if path.is_dir():
            target.mkdir()
            (target / 'metadata.yaml').write_bytes((path / 'metadata.yaml').read_bytes())
            file = target / storage_file(path).name
        file.write_bytes(change(data))
        read_all(target)


@pytest.mark.parametrize('kind', FORMATS)
@given(share=st.floats(0, 1))
@QUICK
def test_cut_anywhere(recordings, kind, share):
    damaged(recordings, kind, lambda data: data[:int(share * len(data))])


@pytest.mark.parametrize('kind', FORMATS)
@given(edits=st.lists(
    st.tuples(st.floats(0, 1), st.binary(min_size=1, max_size=4)), min_size=1, max_size=4))
@QUICK
def test_bytes_changed(recordings, kind, edits):
    def change(data: bytes) -> bytes:
        changed = bytearray(data)
        for share, patch in edits:
            at = int(share * (len(data) - 4))
            changed[at:at + len(patch)] = patch
        return bytes(changed)

    damaged(recordings, kind, change)


def sample(record, ros1: bool) -> tuple[Channel, bytes]:
    store = NOETIC if ros1 else JAZZY
    words, _ = store.generate_msgdef(record.kind, ros_version=1 if ros1 else 2)
    write = store.serialize_ros1 if ros1 else store.serialize_cdr
    channel = Channel(record.topic, record.kind, 'ros1' if ros1 else 'cdr',
                      'ros1msg' if ros1 else 'ros2msg', words)
    return channel, bytes(write(record.make(store), record.kind))


SAMPLES = {
    f'{record.kind.rpartition("/")[2]} {"ros1" if ros1 else "cdr"}': sample(record, ros1)
    for record in RECORDS[:5] for ros1 in (False, True)}
USE = {
    'PointCloud2': point_cloud2.decode, 'Image': depth_image.decode_depth,
    'CameraInfo': lambda m: camera_info.rays(camera_info.calibration(m, 20, 30)),
    'TFMessage': transforms.decode, 'String': lambda m: m.data}
DECODER = Decoder()


@pytest.mark.parametrize('name', SAMPLES)
@given(edits=st.lists(st.tuples(st.integers(0, 10**6), st.binary(min_size=1, max_size=4)),
                      max_size=4), cut=st.integers(0, 90))
@settings(max_examples=60, deadline=None)
def test_serialized_messages_damaged(name, edits, cut):
    channel, data = SAMPLES[name]
    changed = bytearray(data)
    for at, patch in edits:
        at %= min(len(data), 300)  # where lengths are
        changed[at:at + len(patch)] = patch
    raw = RawMessage(channel, 0, bytes(changed[:max(len(changed) - cut, 0)]))
    try:
        USE[name.partition(' ')[0]](DECODER.decode(raw))
    except InputError:
        pass


anything = st.one_of(
    st.integers(-2**33, 2**33), st.floats(), st.none(), st.text(max_size=3), st.booleans())
size = st.one_of(st.integers(0, 12), anything)
numbers = st.one_of(st.lists(st.floats(), max_size=15), anything)
images = st.builds(
    SimpleNamespace, height=size, width=size, step=st.one_of(st.integers(0, 60), anything),
    encoding=st.one_of(st.sampled_from([*depth_image.DEPTHS, *depth_image.COLORS]), anything),
    is_bigendian=anything, data=st.one_of(st.binary(max_size=600), anything))
regions = st.builds(SimpleNamespace, x_offset=size, y_offset=size, height=size, width=size)
infos = st.builds(
    SimpleNamespace, height=size, width=size, roi=st.one_of(regions, anything),
    distortion_model=st.one_of(st.sampled_from([*camera_info.MODELS]), anything),
    d=st.one_of(st.lists(st.floats(-2, 2), min_size=4, max_size=14), numbers),
    k=st.one_of(st.lists(st.floats(-20, 20), min_size=9, max_size=9), numbers),
    p=st.one_of(st.lists(st.floats(-20, 20), min_size=12, max_size=12), numbers),
    binning_x=size, binning_y=size)


@given(images)
@settings(max_examples=300, deadline=None)
def test_any_image_decodes_or_is_refused(message):
    for decode in (depth_image.decode_depth, depth_image.decode_color):
        try:
            pixels = decode(message)
        except InputError:
            continue
        assert pixels.shape[:2] in ((message.height, message.width), (0, 0))
        if decode is depth_image.decode_depth:
            assert not (pixels <= 0).any()


@given(infos, st.booleans())
@settings(max_examples=300, deadline=None)
def test_any_camera_info_gives_rays_or_is_refused(message, rectified):
    depth = np.ones((5, 6), np.float32)
    try:
        points = depth_image.backproject(depth, message, rectified=rectified)
    except InputError:
        return
    holes = np.isnan(points[..., 2])
    assert np.isnan(points[holes]).all()
    assert np.isfinite(points[~holes]).all()


@pytest.mark.parametrize('decode', [depth_image.decode_depth, depth_image.decode_color])
def test_claims_of_size_take_no_memory(decode):
    encoding = '32FC1' if decode is depth_image.decode_depth else 'rgb8'
    most = 2**32 - 1
    message = SimpleNamespace(
        height=most, width=most, step=most, encoding=encoding, is_bigendian=0, data=b'abc',
        point_step=12, row_step=most, is_dense=True,
        fields=[SimpleNamespace(name=n, offset=4 * k, datatype=7, count=1)
                for k, n in enumerate('xyz')])
    tracemalloc.start()
    for refuse in (decode, point_cloud2.decode):
        with pytest.raises(InputError):
            refuse(message)
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()


def test_a_list_without_bytes_cannot_hang():
    """A definition of the file's own, whose elements take no byte, with a length of 2^32 - 1."""
    words = 'sensor_msgs/PointField[] fields\n' + '=' * 80 + '\nMSG: sensor_msgs/PointField\n'
    channel = Channel('/p', 'sensor_msgs/msg/PointCloud2', 'ros1', 'ros1msg', words)
    started = time.perf_counter()
    with pytest.raises(InputError, match='without fields'):
        Decoder().decode(RawMessage(channel, 0, b'\xff\xff\xff\xff'))
    assert time.perf_counter() - started < 5
