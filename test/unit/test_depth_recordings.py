# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Depth images of recordings, with CameraInfo and colour; truth: the pinhole equation."""

import numpy as np
import pytest
from reference.bags import cloud, image, info, SECOND, write_bag
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.recordings.frames import count_frames, read_frames

SHAPE = (6, 8)
DEPTH = np.arange(1000, 1000 + 48, dtype='<u2').reshape(SHAPE)


def expected(depth_m: np.ndarray, focal: float = 20.0) -> np.ndarray:
    v, u = np.mgrid[:SHAPE[0], :SHAPE[1]]
    x, y = (u - (SHAPE[1] - 1) / 2) / focal, (v - (SHAPE[0] - 1) / 2) / focal
    return np.stack([x * depth_m, y * depth_m, depth_m], axis=-1)


@pytest.mark.parametrize('kind', ['mcap', 'bag', 'sqlite3'])
@pytest.mark.parametrize('order', ['info first', 'info last', 'info once, at the end'])
def test_depth_images(tmp_path, kind, order):
    records = []
    for k in range(12):
        time = k * SECOND // 10
        pair = [image(time, DEPTH + k, '16UC1'), info(time + 1 if order == 'info last' else time,
                                                      SHAPE)]
        if order == 'info once, at the end':
            pair = pair if k == 11 else pair[:1]
        records += pair if order != 'info first' else pair[::-1]
    frames = list(read_frames(write_bag(tmp_path, kind, records)))
    assert [frame.log_time_ns for frame in frames] == [k * SECOND // 10 for k in range(12)]
    for k, frame in enumerate(frames):
        np.testing.assert_allclose(frame.points, expected((DEPTH + k) / 1000), rtol=3e-7)
        assert (frame.sensor.kind, frame.units, frame.colors) == ('pinhole', 'm', None)


def test_depth_with_its_own_calibration_and_colour(tmp_path):
    rng = np.random.default_rng(4)
    records = []
    rgbs = [rng.integers(0, 256, (*SHAPE, 3), np.uint8) for _ in range(5)]
    for k in range(5):
        records += [
            info(k, SHAPE, focal=20.0 + k), image(k, DEPTH, '16UC1'),
            image(k, rgbs[k], 'rgb8', topic='/color/image'),
            image(k, rgbs[k][..., 0], 'mono8', topic='/infra/image'),
            image(k, rgbs[k], 'bgr8', topic='/other/image', frame='other')]
    frames = list(read_frames(write_bag(tmp_path, 'mcap', records)))
    assert len(frames) == 5
    for k, frame in enumerate(frames):
        np.testing.assert_allclose(
            frame.points, expected(DEPTH / 1000, 20.0 + k), rtol=3e-7)
        np.testing.assert_array_equal(frame.colors, rgbs[k])


def test_clouds_go_before_depth_images(tmp_path):
    records = [info(1, SHAPE), image(1, DEPTH, '16UC1'), cloud(1, np.ones((*SHAPE, 3)))]
    path = write_bag(tmp_path, 'mcap', records)
    frame, = read_frames(path)
    assert frame.topic == '/points'
    assert 'depth images on /depth/image not read' in frame.notes[0]
    both = list(read_frames(path, topics=['/depth/image', '/points']))
    assert [f.topic for f in both] == ['/depth/image', '/points']
    assert count_frames(path, ['/depth/image', '/points']) == 2
    infrared = [info(1, SHAPE), image(1, DEPTH, 'mono16', topic='/infra/image')]
    path = write_bag(tmp_path, 'mcap', infrared)
    with pytest.raises(InputError, match='no depth image'):
        count_frames(path)
    assert count_frames(path, ['/infra/image']) == 1


def test_depth_in_millimetres(tmp_path):
    metres = (DEPTH / 1000).astype('<f4')
    for encoding, pixels in (('16UC1', DEPTH), ('32FC1', metres * 1000)):
        path = write_bag(tmp_path, 'mcap', [info(1, SHAPE), image(1, pixels, encoding)])
        frame, = read_frames(path, units='mm')
        assert frame.units == 'mm'
        np.testing.assert_allclose(frame.points, 1000 * expected(DEPTH / 1000), rtol=3e-7)


def test_depth_that_cannot_be_placed(tmp_path):
    path = write_bag(tmp_path, 'mcap', [image(1, DEPTH, '16UC1')])
    outcome, = read_frames(path)
    assert 'no CameraInfo: none on /depth/camera_info' in outcome.reason
    path = write_bag(tmp_path, 'mcap', [info(1, (5, 8)), image(1, DEPTH, '16UC1')])
    outcome, = read_frames(path)
    assert 'made for images of 8 x 5 pixels, the image has 8 x 6' in outcome.reason
    short = image(2, DEPTH, '16UC1', data=np.zeros(10, np.uint8))
    records = [info(1, SHAPE), image(1, DEPTH, '16UC1'), short]
    good, bad = read_frames(write_bag(tmp_path, 'mcap', records))
    assert isinstance(good, Frame)
    assert '10 bytes of data' in bad.reason


def test_rectified_by_the_name_of_the_topic(tmp_path):
    bent = {'distortion': (0.2, 0, 0, 0, 0)}
    records = [info(1, SHAPE, topic='/camera_info', **bent)]
    straight = image(1, DEPTH, '16UC1', topic='/image_rect')
    frame, = read_frames(write_bag(tmp_path, 'mcap', [*records, straight]))
    np.testing.assert_allclose(frame.points, expected(DEPTH / 1000), rtol=3e-7)
    raw = image(1, DEPTH, '16UC1', topic='/image_raw')
    frame, = read_frames(write_bag(tmp_path, 'mcap', [*records, raw]))
    assert np.nanmax(np.abs(frame.points - expected(DEPTH / 1000))) > 1e-3
