# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Reading PLY; the truth is what each test writes, byte by byte."""

import gzip
import struct

import numpy as np
import pytest

from ros_rops.core.errors import InputError
from ros_rops.recordings.reader import read_mesh, read_view

GRID_HEADER = (
    'ply\nformat {} 1.0\nobj_info num_cols 3\nobj_info num_rows 2\ncomment by hand\n'
    'element vertex 3\nproperty float x\nproperty float y\nproperty float z\n'
    'element range_grid 6\nproperty list uchar int vertex_indices\nend_header\n'
)
POINTS = [(0.0, 0.5, 1.0), (1.0, 0.5, 2.0), (2.0, 1.5, 3.0)]
CELLS = [None, 0, 1, None, None, 2]
GRID = [[-1, 0, 1], [-1, -1, 2]]


def grid_file(kind: str) -> bytes:
    head = GRID_HEADER.format(kind).encode()
    if kind == 'ascii':
        lines = [' '.join(map(str, p)) for p in POINTS]
        lines += ['0' if c is None else f'1 {c}' for c in CELLS]
        return head + '\n'.join(lines).encode() + b'\n'
    order = '<' if 'little' in kind else '>'
    body = b''.join(struct.pack(f'{order}3f', *p) for p in POINTS)
    for cell in CELLS:
        body += b'\0' if cell is None else struct.pack(f'{order}Bi', 1, cell)
    return head + body


@pytest.mark.parametrize('kind', ['ascii', 'binary_little_endian', 'binary_big_endian'])
def test_range_grid(tmp_path, kind):
    path = tmp_path / 'scan.ply'
    path.write_bytes(grid_file(kind))
    view = read_view(path)
    assert view.name == 'scan.ply'
    np.testing.assert_array_equal(view.points, POINTS)
    np.testing.assert_array_equal(view.grid, GRID)


@pytest.mark.parametrize('kind', ['ascii', 'binary_little_endian', 'binary_big_endian'])
@pytest.mark.parametrize('cut', [1, 3, 8, 20])
def test_truncated_range_grid(tmp_path, kind, cut):
    path = tmp_path / 'scan.ply'
    data = grid_file(kind)
    path.write_bytes(data.rstrip()[:-cut] if kind == 'ascii' else data[:-cut])
    with pytest.raises(InputError, match='scan.ply.*truncated'):
        read_view(path)


def test_windows_line_ends(tmp_path):
    path = tmp_path / 'scan.ply'
    path.write_bytes(grid_file('ascii').replace(b'\n', b'\r\n'))
    np.testing.assert_array_equal(read_view(path).grid, GRID)


def test_gzip(tmp_path):
    path = tmp_path / 'scan.ply.gz'
    path.write_bytes(gzip.compress(grid_file('ascii')))
    assert len(read_view(path).points) == 3
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(InputError, match='truncated'):
        read_view(path)


def test_holes_renumber_grid(tmp_path):
    path = tmp_path / 'scan.ply'
    path.write_bytes(grid_file('ascii').replace(b'1.0 0.5 2.0', b'nan inf 2.0'))
    view = read_view(path)
    np.testing.assert_array_equal(view.points, [POINTS[0], POINTS[2]])
    np.testing.assert_array_equal(view.grid, [[-1, 0, -1], [-1, -1, 1]])


ODD_HEADER = (
    'ply\nformat {} 1.0\nelement camera 1\nproperty float view\n'
    'property list int double lens\nelement vertex 2\nproperty uchar diffuse_blue\n'
    'property double z\nproperty list uchar short neighbours\nproperty uchar diffuse_red\n'
    'property float x\nproperty uchar diffuse_green\nproperty int y\nend_header\n'
)


@pytest.mark.parametrize('kind', ['ascii', 'binary_little_endian', 'binary_big_endian'])
def test_any_order_lists_and_unknown_elements(tmp_path, kind):
    if kind == 'ascii':
        body = b'7 3 1 2 3\n30 0.25 2 5 6 10 1.5 20 -4\n60 0.5 0 40 2.5 50 9\n'
    else:
        o = '<' if 'little' in kind else '>'
        body = struct.pack(f'{o}fi3d', 7, 3, 1, 2, 3)
        body += struct.pack(f'{o}BdB2hBfBi', 30, 0.25, 2, 5, 6, 10, 1.5, 20, -4)
        body += struct.pack(f'{o}BdBBfBi', 60, 0.5, 0, 40, 2.5, 50, 9)
    path = tmp_path / 'odd.ply'
    path.write_bytes(ODD_HEADER.format(kind).encode() + body)
    view = read_view(path)
    np.testing.assert_array_equal(view.points, [[1.5, -4, 0.25], [2.5, 9, 0.5]])
    np.testing.assert_array_equal(view.colors, [[10, 20, 30], [40, 50, 60]])
    assert view.grid is None


def test_float_colors_are_fractions(tmp_path):
    path = tmp_path / 'c.ply'
    names = ''.join(f'property float {n}\n' for n in ('x', 'y', 'z', 'red', 'green', 'blue'))
    path.write_text(f'ply\nformat ascii 1.0\nelement vertex 1\n{names}end_header\n'
                    '1 2 3 0 0.5 1\n')
    np.testing.assert_array_equal(read_view(path).colors, [[0, 128, 255]])


def vertices_only(rows: str, count: int) -> bytes:
    return (f'ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\n'
            f'property float y\nproperty float z\nend_header\n{rows}').encode()


@pytest.mark.parametrize('count', [0, 1, 2])
def test_few_points_are_no_reader_error(tmp_path, count):
    path = tmp_path / 'few.ply'
    path.write_bytes(vertices_only('1 2 3\n' * count, count))
    assert read_view(path).points.shape == (count, 3)


def test_absurd_coordinates_are_holes(tmp_path):
    path = tmp_path / 'a.ply'
    path.write_bytes(vertices_only('1 2 1e300\n1e6 1e6 1e6\n1e-320 0 -1e16\n', 3))
    np.testing.assert_array_equal(read_view(path).points, [[1e6, 1e6, 1e6]])


def test_all_nan_is_no_reader_error(tmp_path):
    path = tmp_path / 'nan.ply'
    path.write_bytes(grid_file('ascii').replace(b'1.0', b'nan').replace(b'3.0', b'inf', 1)
                     .replace(b'format ascii nan', b'format ascii 1.0'))
    view = read_view(path)
    assert view.points.shape == (0, 3)
    assert (view.grid == -1).all()
    assert view.sensor.kind == 'unknown'


BAD = {
    'empty': (b'', 'is empty'),
    'no ply': (b'hello world\n', 'not a PLY'),
    'pcd inside': (b'# .PCD v0.7\nFIELDS x y z\n', 'looks like a .pcd'),
    'no end': (b'ply\nformat ascii 1.0\nelement vertex 1\n', 'no end'),
    'no format': (b'ply\nelement vertex 0\nproperty float x\nend_header\n', 'no PLY format'),
    'no vertices': (b'ply\nformat ascii 1.0\nend_header\n', 'no element "vertex"'),
    'no z': (vertices_only('1 2\n', 1).replace(b'property float z\n', b''), 'lack x, y or z'),
    'negative count': (vertices_only('', -3), 'sensible count'),
    'odd digit': (vertices_only('', 7).replace(b'7', b'\xb2'), 'sensible count'),
    'huge count': (vertices_only('1 2 3\n', 10**14), 'truncated'),
    'unknown line': (vertices_only('1 2 3\n', 1).replace(b'end_h', b'bogus 1\nend_h'), 'bogus'),
    'unknown type': (vertices_only('', 0).replace(b'float z', b'quad z'), 'quad'),
    'words': (vertices_only('1 2 three\n', 1), 'other than numbers'),
    'grid size': (grid_file('ascii').replace(b'num_cols 3', b'num_cols 4'), '4 x 2'),
    'grid without size': (grid_file('ascii').replace(b'num_cols', b'columns'), 'num_cols'),
    'grid index': (grid_file('ascii').replace(b'1 2\n', b'1 9\n'), 'does not exist'),
    'grid doubled': (grid_file('ascii').replace(b'1 2\n', b'2 2 1\n'), 'more than one'),
    'grid length': (grid_file('ascii').replace(b'1 2\n', b'0.5 2\n'), 'whole number'),
}


@pytest.mark.parametrize('case', BAD)
def test_bad_file(tmp_path, case):
    data, words = BAD[case]
    path = tmp_path / 'bad.ply'
    path.write_bytes(data)
    with pytest.raises(InputError, match=words) as caught:
        read_view(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('v 0 0 0\n', 'no faces'),
        ('v 0 0 0\nf 1 1 1 1\n', 'not triangles'),
        ('v 0 0 0\nf 1 1 2\n', 'does not exist'),
        ('v 0 0 0\nf 0 1 1\n', 'does not exist'),
        ('v 0 0 0\nf 1 1 -2\n', 'does not exist'),
        ('v 0 0 zero\nf 1 1 1\n', 'not made of numbers'),
        ('v 0 0 0\nf a b c\n', 'not made of numbers'),
    ],
)
def test_bad_obj(tmp_path, text, words):
    (tmp_path / 'm.obj').write_text(text)
    with pytest.raises(InputError, match=words):
        read_mesh(tmp_path / 'm.obj')


def test_obj(tmp_path):
    (tmp_path / 'm.obj').write_text(
        '# a\nmtllib x\nv 0 0 0 1 1 1\nvn 0 0 1\nv 1 0 0\nv  0 1 2e-1\n'
        'f 1/1/1 2/1 3\nf -1 -2 -3\n')
    vertices, faces = read_mesh(tmp_path / 'm.obj')
    assert vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0.2]]
    assert faces.tolist() == [[0, 1, 2], [2, 1, 0]]


def test_mesh(tmp_path):
    path = tmp_path / 'm.ply'
    head = vertices_only('', 3).decode().replace(
        'end_header\n', 'element face 1\nproperty list uchar int vertex_indices\nend_header\n')
    path.write_text(head + '0 0 0\n1 0 0\n0 1 0\n3 2 0 1\n')
    vertices, faces = read_mesh(path)
    assert vertices.shape == (3, 3)
    assert faces.tolist() == [[2, 0, 1]]
    path.write_text(head + '0 0 0\n1 0 0\n0 1 0\n3 2 0 7\n')
    with pytest.raises(InputError, match='does not exist'):
        read_mesh(path)
    path.write_text(head + '0 0 0\n1 0 0\n0 1 0\n2 2 0\n')
    with pytest.raises(InputError, match='not triangles'):
        read_mesh(path)
    path.write_bytes(vertices_only('1 2 3\n', 1))
    with pytest.raises(InputError, match='no faces'):
        read_mesh(path)
