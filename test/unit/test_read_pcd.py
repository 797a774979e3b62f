# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Reading PCD; the truth is what each test writes, and Open3D's own writer."""

import struct

import numpy as np
import pytest

from ros_rops.core.errors import InputError
from ros_rops.recordings import lzf
from ros_rops.recordings.cloud import FormatError
from ros_rops.recordings.reader import read_view

HEIGHT, WIDTH = 2, 3
COUNT = HEIGHT * WIDTH


def table() -> np.ndarray:
    rows = np.zeros(COUNT, [('rgb', '<u4'), ('z', '<f4'), ('tag', 'u1', (3,)), ('x', '<f4'),
                            ('y', '<f8')])
    rows['x'] = np.arange(COUNT)
    rows['y'] = 10 + np.arange(COUNT)
    rows['z'] = 20 + np.arange(COUNT)
    rows['rgb'] = [k << 16 | (k + 1) << 8 | (k + 2) for k in range(COUNT)]
    rows['tag'] = 255
    rows['z'][4] = np.nan
    return rows


def header(kind: str, rgb: str = 'U') -> bytes:
    return (
        '# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS rgb z tag x y\n'
        f'SIZE 4 4 1 4 8\nTYPE {rgb} F U F F\nCOUNT 1 1 3 1 1\nWIDTH {WIDTH}\nHEIGHT {HEIGHT}\n'
        f'VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {COUNT}\nDATA {kind}\n').encode()


def body(kind: str) -> bytes:
    rows = table()
    if kind == 'binary':
        return rows.tobytes()
    if kind == 'ascii':
        return ''.join(
            f'{r["rgb"]} {r["z"]} 255 255 255 {r["x"]} {r["y"]}\n' for r in rows).encode()
    plain = b''.join(rows[name].tobytes() for name in rows.dtype.names)
    packed = literal_lzf(plain)
    return struct.pack('<2I', len(packed), len(plain)) + packed


def literal_lzf(plain: bytes) -> bytes:
    chunks = [plain[k:k + 32] for k in range(0, len(plain), 32)]
    return b''.join(bytes([len(c) - 1]) + c for c in chunks)


KINDS = ['ascii', 'binary', 'binary_compressed']


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('rgb', ['U', 'F'])
def test_organized_with_hole_and_colour(tmp_path, kind, rgb):
    path = tmp_path / 'a.pcd'
    path.write_bytes(header(kind, rgb) + body(kind))
    view = read_view(path)
    np.testing.assert_array_equal(view.grid, [[0, 1, 2], [3, -1, 4]])
    keep = [0, 1, 2, 3, 5]
    np.testing.assert_array_equal(view.points, [[k, 10 + k, 20 + k] for k in keep])
    np.testing.assert_array_equal(view.colors, [[k, k + 1, k + 2] for k in keep])


@pytest.mark.parametrize('kind', KINDS)
def test_truncated(tmp_path, kind):
    path = tmp_path / 'a.pcd'
    path.write_bytes((header(kind) + body(kind))[:-25])
    with pytest.raises(InputError, match='truncated|number of columns'):
        read_view(path)


@pytest.mark.parametrize('compressed', [False, True])
@pytest.mark.parametrize('ascii_body', [False, True])
def test_files_of_another_writer(tmp_path, ascii_body, compressed):
    o3d = pytest.importorskip('open3d')
    rng = np.random.default_rng(1)
    points = np.round(rng.normal(size=(5000, 3)), 2)  # repeats, so that LZF copies
    colors = rng.integers(0, 256, points.shape)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.colors = o3d.utility.Vector3dVector(colors / 255.0)
    path = tmp_path / 'o.pcd'
    o3d.io.write_point_cloud(str(path), cloud, write_ascii=ascii_body, compressed=compressed)
    view = read_view(path)
    np.testing.assert_allclose(view.points, points, atol=1e-6)
    np.testing.assert_allclose(view.colors, colors, atol=1)


def test_lzf_overlapping_copy():
    # one literal 'ab', then a copy of 7 from distance 2 (itself included): 'ab' 'abababa'
    assert lzf.decompress(b'\x01ab' + bytes([(7 - 2) << 5 | 0, 1]), 9) == b'ababababa'
    # length 7 marks an extra byte: 9 + 3 repeated 'x'
    assert lzf.decompress(b'\x00x' + bytes([7 << 5, 3, 0]), 13) == b'x' * 13


@pytest.mark.parametrize(
    ('data', 'size', 'words'),
    [
        (b'\x05ab', 6, 'breaks off'),
        (b'\x00a\x20', 4, 'breaks off'),
        (b'\x00a\xe0', 4, 'breaks off'),
        (b'\x00a\x20\x05', 4, 'before its own beginning'),
        (b'\x01ab', 1, 'more than it states'),
        (b'\x01ab', 5, 'not 5'),
    ],
)
def test_lzf_damaged(data, size, words):
    with pytest.raises(FormatError, match=words):
        lzf.decompress(data, size)


BAD = {
    'no pcd': (b'x y z\n1 2 3\n', 'not a PCD'),
    'ply inside': (b'ply\nformat ascii 1.0\n', 'looks like a .ply'),
    'no data': (header('binary')[:60], 'no DATA line'),
    'unknown data': (header('zipped') + body('binary'), 'zipped'),
    'no width': (header('binary').replace(b'WIDTH 3', b'WIDTH no') + body('binary'), 'WIDTH'),
    'huge': (header('binary').replace(b'WIDTH 3', b'WIDTH 99999999999'), 'WIDTH'),
    'points': (header('binary').replace(b'POINTS 6', b'POINTS 7') + body('binary'), 'POINTS'),
    'fields': (header('binary').replace(b'SIZE 4 ', b'SIZE ') + body('binary'), 'do not agree'),
    'type': (header('binary').replace(b'TYPE U F', b'TYPE U Q') + body('binary'), 'type'),
    'no x': (header('binary').replace(b'tag x y', b'tag q y') + body('binary'), 'lack x'),
    'size': (header('binary').replace(b'SIZE 4 4', b'SIZE 4 a') + body('binary'), 'of a type'),
    'sizes': (header('binary_compressed') + struct.pack('<2I', 5, 7) + b'12345', 'states 7'),
    'no sizes': (header('binary_compressed') + b'12', 'no sizes'),
    'count': (header('binary').replace(b'COUNT 1', b'COUNT \xb2'), 'COUNT is no number'),
    'no rows': (header('ascii') + b'\n', 'no rows'),
    'words': (header('ascii') + b'a b c\n' * 6, 'table of numbers'),
}


@pytest.mark.parametrize('case', BAD)
def test_bad_file(tmp_path, case):
    data, words = BAD[case]
    path = tmp_path / 'bad.pcd'
    path.write_bytes(data)
    with pytest.raises(InputError, match=words) as caught:
        read_view(path)
    assert str(path) in str(caught.value)
