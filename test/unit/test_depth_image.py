# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Depth and colour images and CameraInfo to arrays; truth: values written by hand, and lenses."""

import math
import os
from pathlib import Path
from types import SimpleNamespace

from msg_adapters import camera_info, depth_image
import numpy as np
import pytest
from ros_rops.core.errors import InputError, ShapeError
from ros_rops.recordings.frames import read_frames

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))
RECORDINGS = DATA.parent / 'recordings'
H, W = 3, 4


def image(pixels: np.ndarray, encoding: str, pad: int = 0, **changes: object) -> SimpleNamespace:
    """Return an Image with `pad` unused bytes at the end of each row."""
    rows = pixels.reshape(len(pixels), -1)
    padded = [row.tobytes() + b'\xee' * pad for row in rows]
    values = {
        'height': pixels.shape[0], 'width': pixels.shape[1], 'encoding': encoding,
        'is_bigendian': pixels.dtype.byteorder == '>', 'step': len(padded[0]),
        'data': b''.join(padded)}
    return SimpleNamespace(**(values | changes))


def info(**changes: object) -> SimpleNamespace:
    region = SimpleNamespace(x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
    values = {
        'height': H, 'width': W, 'distortion_model': 'plumb_bob', 'd': [0.0] * 5,
        'k': [10.0, 0, 1.5, 0, 20.0, 1.0, 0, 0, 1.0],
        'p': [8.0, 0, 1.0, 0, 0, 16.0, 0.5, 0, 0, 0, 1.0, 0],
        'binning_x': 0, 'binning_y': 0, 'roi': region}
    return SimpleNamespace(**(values | changes))


MM = np.array([[0, 1, 1000, 65535], [500, 0, 2, 3], [4, 5, 6, 7]])


@pytest.mark.parametrize('order', ['<', '>'])
@pytest.mark.parametrize('pad', [0, 5])
@pytest.mark.parametrize('encoding', ['16UC1', 'mono16'])
def test_millimetres(order, pad, encoding):
    depth = depth_image.decode_depth(image(MM.astype(f'{order}u2'), encoding, pad))
    assert depth.dtype == np.float32
    np.testing.assert_allclose(depth, np.where(MM == 0, np.nan, MM / 1000), rtol=1e-7)


@pytest.mark.parametrize('order', ['<', '>'])
@pytest.mark.parametrize('pad', [0, 5])
def test_metres_and_holes(order, pad):
    metres = np.array([[0.5, np.nan, np.inf, -np.inf], [0, -1, 1e30, 2.25], [1, 1, 1, 1]])
    depth = depth_image.decode_depth(image(metres.astype(f'{order}f4'), '32FC1', pad))
    expected = [[0.5, *3 * [np.nan]], [*3 * [np.nan], 2.25], [1, 1, 1, 1]]
    np.testing.assert_array_equal(depth, expected)
    assert depth.flags.writeable


@pytest.mark.parametrize('encoding', depth_image.COLORS)
@pytest.mark.parametrize('pad', [0, 3])
def test_colours(encoding, pad):
    red, green, blue = 10, 20, 30
    pixel = {'rgb8': (red, green, blue), 'rgba8': (red, green, blue, 99), 'mono8': (red,),
             '8UC1': (red,), 'bgra8': (blue, green, red, 99), '8UC4': (blue, green, red, 99)}
    pixels = np.zeros((H, W, len(pixel.get(encoding, (0, 0, 0)))), np.uint8)
    pixels[1, 2] = pixel.get(encoding, (blue, green, red))
    rgb = depth_image.decode_color(image(pixels, encoding, pad))
    grey = encoding in ('mono8', '8UC1')
    assert rgb[1, 2].tolist() == ([red] * 3 if grey else [red, green, blue])
    assert rgb.sum() == rgb[1, 2].sum()


SMALL = image(MM.astype('<u2'), '16UC1')
BAD = {
    'short': ({'data': SMALL.data[:-1]}, '23 bytes of data, 3 x 4 pixels need 24'),
    'step': ({'step': 7}, 'step 7 < width'),
    'huge': ({'height': 2**32 - 1, 'width': 2**32 - 1, 'step': 2**32 - 1}, 'step'),
    'high': ({'height': 2**32 - 1}, 'pixels need'),
    'too huge': ({'height': 2**32}, 'height is'),
    'negative': ({'width': -1}, 'width is -1'),
    'encoding': ({'encoding': 'jpeg'}, "encoding 'jpeg' is none of 16UC1"),
    'number': ({'data': 10**12}, 'no sequence of bytes'),
    'text': ({'data': 'abc'}, 'no sequence of bytes'),
}


@pytest.mark.parametrize('case', BAD)
def test_contradictions(case):
    changes, words = BAD[case]
    with pytest.raises(InputError, match=words):
        depth_image.decode_depth(SimpleNamespace(**(vars(SMALL) | changes)))


def test_other_messages():
    with pytest.raises(InputError, match='no Image'):
        depth_image.decode_depth(SimpleNamespace(data=b''))
    with pytest.raises(InputError, match="'16UC1' is none of rgb8"):
        depth_image.decode_color(SMALL)
    with pytest.raises(ShapeError, match='depth'):
        depth_image.backproject(np.zeros(3, np.float32), info())


def test_empty():
    assert depth_image.decode_depth(image(MM.astype('<u2'), '16UC1', height=0)).size == 0
    assert depth_image.decode_color(image(MM.astype('u1'), 'mono8', width=0)).size == 0


def test_a_pixel_is_placed_by_hand():
    points = depth_image.backproject(np.full((H, W), 2.0, np.float32), info())
    np.testing.assert_allclose(points[2, 3], [(3 - 1.5) / 10 * 2, (2 - 1) / 20 * 2, 2])
    flat = depth_image.backproject(np.full((H, W), 2.0, np.float32), info(), rectified=True)
    np.testing.assert_allclose(flat[2, 3], [(3 - 1) / 8 * 2, (2 - 0.5) / 16 * 2, 2])


def test_spelling_of_ros1_and_what_is_left_out():
    old = info()
    for name in 'kpd':
        setattr(old, name.upper(), old.__dict__.pop(name))
    assert camera_info.calibration(old, H, W) == camera_info.calibration(info(), H, W)
    only_p = camera_info.calibration(info(k=[0.0] * 9), H, W)
    assert only_p.fx == 8.0
    only_k = camera_info.calibration(info(p=[0.0] * 12), H, W, rectified=True)
    assert only_k.fx == 10.0
    assert camera_info.calibration(info(height=0, width=0), H, W).fx == 10.0


def test_binning_and_region_of_interest():
    region = SimpleNamespace(x_offset=4, y_offset=2, height=2 * H, width=2 * W, do_rectify=False)
    camera = camera_info.calibration(
        info(height=50, width=60, roi=region, binning_x=2, binning_y=2), H, W)
    assert (camera.fx, camera.fy) == (5.0, 10.0)
    assert (camera.cx, camera.cy) == ((1.5 - 4) / 2, (1.0 - 2) / 2)
    with pytest.raises(InputError, match='images of 8 x 6 pixels, the image has 4 x 3'):
        camera_info.calibration(info(height=50, width=60, roi=region), H, W)


BAD_INFO = {
    'uncalibrated': ({'k': [0.0] * 9, 'p': [0.0] * 12}, 'not calibrated'),
    'nan': ({'k': [math.nan] * 9}, 'not calibrated'),
    'size': ({'width': 640, 'height': 480}, 'images of 640 x 480 pixels, the image has 4 x 3'),
    'model': ({'distortion_model': 'thin_plate', 'd': [1.0]}, "'thin_plate' is none of plumb_bob"),
    'coefficients': ({'d': [0.1, 0.1]}, '2 coefficients'),
    'tilted': ({'distortion_model': 'rational_polynomial', 'd': [0.1] * 14}, 'tilted sensor'),
    'short k': ({'k': [1.0]}, 'k has 1 numbers, not 9'),
    'no numbers': ({'p': 'twelve'}, 'p is no sequence of numbers'),
    'infinite': ({'d': [math.inf, 0, 0, 0, 0]}, 'finite'),
}


@pytest.mark.parametrize('case', BAD_INFO)
def test_unsound_calibrations(case):
    changes, words = BAD_INFO[case]
    with pytest.raises(InputError, match=words):
        camera_info.calibration(info(**changes), H, W)


def test_too_many_pixels_are_refused_before_memory_is_taken():
    with pytest.raises(InputError, match='no camera has that'):
        camera_info.rays(camera_info.Calibration(2**31, 2**31, 1.0, 1.0, 0.0, 0.0))


LENSES = {
    'plumb_bob': [-0.28, 0.07, 0.0002, -0.0003, 0.0],
    'plumb_bob of four': [-0.28, 0.07, 0.0002, -0.0003],
    'rational_polynomial': [0.5, -2.6, 0.0006, -0.0002, 1.5, 0.4, -2.4, 1.4],
    'equidistant': [-0.01, 0.03, -0.02, 0.004],
}


@pytest.mark.parametrize('lens', LENSES)
def test_a_lens_is_undone(lens):
    """A ray sent through the lens by the textbook's formula comes back from its pixel."""
    height, width, focal = 48, 64, 60.0
    d = LENSES[lens]
    model = lens.partition(' ')[0]
    camera = camera_info.calibration(
        info(height=height, width=width, d=d, distortion_model=model,
             k=[focal, 0, 31.5, 0, focal, 23.5, 0, 0, 1]), height, width)
    x, y, lost = camera_info.rays(camera)
    assert lost is None
    for v, u in ((0, 0), (47, 63), (10, 50), (24, 32)):
        a, b = float(x[v, u]), float(y[v, u])
        seen = fisheye(a, b, d) if model == 'equidistant' else textbook(a, b, d)
        assert seen[0] * focal + 31.5 == pytest.approx(u, abs=2e-3)
        assert seen[1] * focal + 23.5 == pytest.approx(v, abs=2e-3)
    assert camera_info.rays(camera)[0] is x  # once per camera


def textbook(x: float, y: float, d: list[float]) -> tuple[float, float]:
    k1, k2, p1, p2, k3, k4, k5, k6 = [*d, *[0.0] * 8][:8]
    r2 = x * x + y * y
    scale = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    return (x * scale + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * scale + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y)


def fisheye(x: float, y: float, d: list[float]) -> tuple[float, float]:
    r = math.hypot(x, y)
    theta = math.atan(r)
    bent = theta * (1 + d[0] * theta**2 + d[1] * theta**4 + d[2] * theta**6 + d[3] * theta**8)
    return x * bent / r, y * bent / r


def test_pixels_that_a_lens_cannot_reach_are_holes():
    """With k1 = -1 no ray is seen farther than 0.385 focal lengths from the centre."""
    camera = info(height=H, width=50, d=[-1.0, 0, 0, 0, 0], k=[50.0, 0, 0, 0, 50.0, 0, 0, 0, 1])
    points = depth_image.backproject(np.ones((H, 50), np.float32), camera)
    assert np.isfinite(points[0, :18]).all()
    assert np.isnan(points[0, 21:]).all()


@pytest.mark.skipif(not RECORDINGS.is_dir(), reason=f'no recordings at {RECORDINGS}')
def test_real_depth_images_are_the_recorded_clouds():
    folder = RECORDINGS / 'bear_d435'
    depths = read_frames(folder, topics=['/camera/depth/image_rect_raw'])
    for depth, cloud in zip(depths, read_frames(folder), strict=True):
        assert depth.stamp_ns == cloud.stamp_ns
        assert depth.frame_id == cloud.frame_id
        holes = np.isnan(cloud.points)
        np.testing.assert_array_equal(np.isnan(depth.points), holes)
        size = np.abs(cloud.points[~holes]).max()
        assert np.abs(depth.points[~holes] - cloud.points[~holes]).max() < 2e-7 * size
