# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""PointCloud2 to arrays and back; truth: each pixel's value is its index."""

import array
import struct
from types import SimpleNamespace

from msg_adapters import point_cloud2
import numpy as np
import pytest
from ros_rops.core.errors import InputError, ShapeError

HEIGHT, WIDTH = 3, 5


def field(name: str, offset: int, datatype: int, count: int = 1) -> SimpleNamespace:
    return SimpleNamespace(name=name, offset=offset, datatype=datatype, count=count)


def message(order: str = '<', step: int = 40, pad: int = 7, **changes: object) -> SimpleNamespace:
    """Return a cloud with z before x, a double y, odd offsets, extra fields and padded rows."""
    data = bytearray(b'\xee' * HEIGHT * (WIDTH * step + pad))
    for k in range(HEIGHT * WIDTH):
        at = k // WIDTH * (WIDTH * step + pad) + k % WIDTH * step
        struct.pack_into(f'{order}f', data, at + 1, 200 + k)  # z
        struct.pack_into(f'{order}d', data, at + 9, 100 + k)  # y
        struct.pack_into(f'{order}f', data, at + 21, k)  # x
        struct.pack_into(f'{order}I', data, at + 28, k << 16 | (2 * k) << 8 | 3 * k)  # rgb
    fields = [
        field('ring', 0, 2), field('z', 1, 7), field('y', 9, 8), field('x', 21, 7),
        field('rgb', 28, 7), field('t', 32, 6, 2), field('future', 0, 99)]
    values = {
        'height': HEIGHT, 'width': WIDTH, 'fields': fields, 'is_bigendian': order == '>',
        'point_step': step, 'row_step': WIDTH * step + pad, 'data': bytes(data),
        'is_dense': False}
    return SimpleNamespace(**(values | changes))


def check(xyz: np.ndarray, rgb: np.ndarray | None) -> None:
    k = np.arange(HEIGHT * WIDTH).reshape(HEIGHT, WIDTH)
    np.testing.assert_array_equal(xyz, np.stack([k, 100 + k, 200 + k], axis=-1))
    np.testing.assert_array_equal(rgb, np.stack([k, 2 * k, 3 * k], axis=-1))


@pytest.mark.parametrize('order', ['<', '>'])
@pytest.mark.parametrize('pad', [0, 7])
def test_every_pixel_is_its_index(order, pad):
    check(*point_cloud2.decode(message(order, pad=pad)))


@pytest.mark.parametrize(
    'wrap', [bytes, bytearray, memoryview, list, lambda d: np.frombuffer(d, np.uint8),
             lambda d: array.array('B', d)])
def test_data_of_any_kind(wrap):
    m = message()
    m.data = wrap(m.data)
    check(*point_cloud2.decode(m))


@pytest.mark.parametrize('datatype', [5, 6, 7])
def test_packed_colour_types(datatype):
    m = message()
    m.fields[4].datatype = datatype
    check(*point_cloud2.decode(m))


def test_colour_that_is_a_signalling_nan_survives():
    m = message()
    data = bytearray(m.data)
    struct.pack_into('<I', data, 28, 0x7FA12345)
    m.data = bytes(data)
    assert point_cloud2.decode(m)[1][0, 0].tolist() == [0xA1, 0x23, 0x45]


def test_separate_colours_and_none():
    m = message()
    m.fields[4:5] = [field('r', 30, 2), field('g', 29, 2), field('b', 28, 2)]
    check(*point_cloud2.decode(m))
    del m.fields[4]
    assert point_cloud2.decode(m)[1] is None


def test_unorganized_ignores_row_step():
    m = message(pad=0, height=1, width=HEIGHT * WIDTH, row_step=0)
    xyz, rgb = point_cloud2.decode(m)
    assert xyz.shape == rgb.shape == (HEIGHT * WIDTH, 3)
    np.testing.assert_array_equal(xyz[:, 0], np.arange(HEIGHT * WIDTH))


@pytest.mark.parametrize('size', [(0, 0), (0, 5), (1, 0), (4, 0)])
def test_empty(size):
    xyz, _ = point_cloud2.decode(message(height=size[0], width=size[1], data=b''))
    assert xyz.shape == (0, 3)


def test_holes_stay():
    m = message()
    data = bytearray(m.data)
    struct.pack_into('<f', data, 21, float('nan'))
    struct.pack_into('<f', data, 40 + 1, float('inf'))
    m.data = bytes(data)
    xyz, _ = point_cloud2.decode(m)
    assert np.isnan(xyz[0, 0, 0])
    assert np.isinf(xyz[0, 1, 2])


BAD = {
    'short data': ({'data': b'\0' * 300}, 'bytes of data'),
    'one byte short': ({'data': message().data[:-8]}, 'bytes of data'),
    'row_step': ({'row_step': 199}, 'row_step 199'),
    'point_step': ({'point_step': 0, 'row_step': 0}, 'point_step is 0'),
    'small point_step': ({'point_step': 24}, 'of a point of 24'),
    'negative': ({'width': -1}, 'width is -1'),
    'huge': ({'width': 2**40}, 'width is'),
    'large': ({'height': 2**31, 'width': 2**31, 'row_step': 2**31}, 'row_step'),
    'text': ({'height': 'three'}, 'three'),
    'nan': ({'height': float('nan')}, 'no whole number'),
    'no fields': ({'fields': []}, "no field 'x'"),
    'fields none': ({'fields': None}, 'no sequence'),
    'field without name': ({'fields': [SimpleNamespace()]}, "'name'"),
    'unknown type of x': ({'fields': [field('x', 0, 42)]}, 'unknown datatype 42'),
    'outside': ({'fields': [field('x', 38, 7)]}, "'x' ends at byte 42"),
    'data none': ({'data': None}, 'no sequence of bytes'),
    'data of words': ({'data': ['a']}, 'no sequence of bytes'),
}


@pytest.mark.parametrize('case', BAD)
def test_contradictions(case):
    changes, words = BAD[case]
    with pytest.raises(InputError, match=words):
        point_cloud2.decode(message(**changes))


def test_other_message():
    with pytest.raises(InputError, match='no PointCloud2'):
        point_cloud2.decode(SimpleNamespace(data=b''))


@pytest.mark.parametrize('shape', [(4, 6, 3), (9, 3), (0, 3)])
@pytest.mark.parametrize('colored', [True, False])
def test_round_trip(shape, colored):
    rng = np.random.default_rng(1)
    xyz = rng.normal(size=shape).astype(np.float32)
    xyz[rng.random(shape[:-1]) < 0.3] = np.nan
    rgb = rng.integers(0, 256, shape).astype(np.uint8) if colored else None
    view_id = np.arange(xyz[..., 0].size, dtype=np.int32).reshape(shape[:-1])
    m = SimpleNamespace(header='kept')
    point_cloud2.fill(m, SimpleNamespace, xyz, rgb, {'view_id': view_id})
    back, colors = point_cloud2.decode(m)
    np.testing.assert_array_equal(back, xyz)
    np.testing.assert_array_equal(colors, rgb)
    assert m.header == 'kept'
    assert m.is_dense == bool(np.isfinite(xyz).all())
    assert isinstance(m.data, array.array)
    assert len(m.data) == m.row_step * m.height
    last = m.fields[-1]
    assert (last.name, last.datatype, last.count) == ('view_id', 5, 1)


def test_encode_refuses():
    with pytest.raises(ShapeError, match='xyz'):
        point_cloud2.encode(np.zeros((3, 2)))
    with pytest.raises(ShapeError, match='rgb'):
        point_cloud2.encode(np.zeros((3, 3)), np.zeros((3, 3)))
    with pytest.raises(ShapeError, match='label'):
        point_cloud2.encode(np.zeros((3, 3)), extra={'label': np.zeros(3, np.int64)})
    with pytest.raises(ShapeError, match='label'):
        point_cloud2.encode(np.zeros((3, 3)), extra={'label': np.zeros(2, np.int32)})
