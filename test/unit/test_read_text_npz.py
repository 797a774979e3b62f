# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Reading text and NPZ, and what holds for every kind; the truth is what each test writes."""

import gzip
import os

import numpy as np
import pytest

from ros_rops.core.errors import InputError, ParameterError
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.recordings.reader import read_view, read_view_noted
from ros_rops.recordings.units import convert

XYZ = [[1.0, 2.0, -3.5], [4.0, 5.0, -6.25], [7.0, 8.0, -9e-1]]
TEXTS = {
    'blanks': '1 2 -3.5\n4 5 -6.25\n7 8 -9e-1\n',
    'tabs, no last newline': '1\t2\t-3.5\n4\t5\t-6.25\n7\t8\t-9e-1',
    'windows': '1 2 -3.5\r\n4 5 -6.25\r\n7 8 -9e-1\r\n',
    'commas': 'x, y, z\n1, 2, -3.5\n4,5,-6.25\n7,8,-9e-1\n',
    'decimal commas': '1,0;2,0;-3,5\n4,0;5,0;-6,25\n7,0;8,0;-0,9\n',
    'decimal commas, tabs': 'x\ty\tz\r\n1,0\t2,0\t-3,5\r\n4,0\t5,0\t-6,25\r\n7,0\t8,0\t-0,9',
    'comma and blank': '1.0, 2.0, -3.5\n4.0 ,5, -6.25\n7,8,-9e-1\n',
    'semicolons': '1;2;-3.5\n4;5;-6.25\n7;8;-9e-1\n',
    'count first': '3\n1 2 -3.5\n4 5 -6.25\n7 8 -9e-1\n',
    'comments': '# a scan\n// of mine\n1 2 -3.5\n\n4 5 -6.25 # odd\n% end\n7 8 -9e-1\n',
    'byte order mark': '\ufeff1 2 -3.5\n4 5 -6.25\n7 8 -9e-1\n',
    'intensity': '1 2 -3.5 0.5\n4 5 -6.25 0.5\n7 8 -9e-1 0.5\n',
    'normals': '1 2 -3.5 0 0 1\n4 5 -6.25 0 -1 0\n7 8 -9e-1 1 0 0\n',
    'holes': 'nan nan nan\n1 2 -3.5\n4 5 -6.25\ninf 1 2\n7 8 -9e-1\n',
}


@pytest.mark.parametrize('suffix', ['.xyz', '.txt', '.csv', '.asc', '.XYZ', '.txt.gz'])
@pytest.mark.parametrize('case', TEXTS)
def test_text(tmp_path, case, suffix):
    path = tmp_path / f'view{suffix}'
    data = TEXTS[case].encode()
    path.write_bytes(gzip.compress(data) if suffix.endswith('.gz') else data)
    view = read_view(path)
    assert view.name == f'view{suffix}'
    np.testing.assert_array_equal(view.points, XYZ)
    assert view.colors is None


def test_text_colors(tmp_path):
    path = tmp_path / 'c.xyz'
    path.write_text('1 2 3 255 0 17\n4 5 6 1 2 3\n')
    noted = read_view_noted(path)
    np.testing.assert_array_equal(noted.view.colors, [[255, 0, 17], [1, 2, 3]])
    assert any('taken as colours' in note for note in noted.notes)


BAD_TEXT = {
    'empty': (b'', 'is empty'),
    'only words': (b'no numbers here\n' * 5, 'no line with three numbers'),
    'two columns': (b'1 2\n3 4\n', 'no line with three numbers'),
    'binary': (b'1 2 3\n\x00\x01\x02', 'not a text file'),
    'ragged': (b'1 2 3\n4 5\n', 'table of numbers'),
    'word inside': (b'1 2 3\n4 5 six\n', 'table of numbers'),
    'ply inside': (b'ply\nformat ascii 1.0\nend_header\n', 'looks like a .ply'),
}


@pytest.mark.parametrize('case', BAD_TEXT)
def test_bad_text(tmp_path, case):
    data, words = BAD_TEXT[case]
    path = tmp_path / 'bad.txt'
    path.write_bytes(data)
    with pytest.raises(InputError, match=words) as caught:
        read_view(path)
    assert str(path) in str(caught.value)


def test_npz_organized(tmp_path):
    points = np.arange(18.0).reshape(2, 3, 3)
    points[0, 1] = np.nan
    np.savez(tmp_path / 'a.npz', points=points, colors=np.full((2, 3, 3), 7, np.uint8))
    view = read_view(tmp_path / 'a.npz')
    np.testing.assert_array_equal(view.grid, [[0, -1, 1], [2, 3, 4]])
    assert view.points.shape == view.colors.shape == (5, 3)


def test_npz_with_grid(tmp_path):
    grid = np.array([[0, -1], [1, -1], [-1, 2]])
    np.savez(tmp_path / 'a.npz', points=np.eye(3), grid=grid)
    np.testing.assert_array_equal(read_view(tmp_path / 'a.npz').grid, grid)


@pytest.mark.parametrize(
    ('arrays', 'words'),
    [
        ({'cloud': np.eye(3)}, 'no array "points"'),
        ({'points': np.zeros((4, 2))}, r'\(4, 2\)'),
        ({'points': np.zeros(3)}, r'\(3,\)'),
        ({'points': np.array([['a', 'b', 'c']])}, '<U1'),
        ({'points': np.array([[None, None, {}]], dtype=object)}, 'not a sound NPZ'),
        ({'points': np.eye(3), 'colors': np.zeros((2, 3))}, 'do not go with'),
        ({'points': np.eye(3), 'grid': np.array([[0, 3]])}, 'does not exist'),
        ({'points': np.eye(3), 'grid': np.array([[0, -2]])}, 'does not exist'),
        ({'points': np.eye(3), 'grid': np.array([0.0, 1.0])}, 'integers'),
    ],
)
def test_bad_npz(tmp_path, arrays, words):
    np.savez(tmp_path / 'a.npz', **arrays)
    with pytest.raises(InputError, match=words):
        read_view(tmp_path / 'a.npz')


def test_damaged_npz(tmp_path):
    path = tmp_path / 'a.npz'
    np.savez_compressed(path, points=np.random.default_rng(0).normal(size=(100, 3)))
    good = path.read_bytes()
    for data in (good[:len(good) // 2], good[:200] + b'\xff' * 300 + good[500:], b'PK\x03\x04'):
        path.write_bytes(data)
        with pytest.raises(InputError, match='not a sound NPZ'):
            read_view(path)
    path.write_bytes(b'1 2 3\n')
    with pytest.raises(InputError, match='not an NPZ'):
        read_view(path)


def test_missing_folder_unknown_unreadable(tmp_path):
    with pytest.raises(InputError, match='no such file'):
        read_view(tmp_path / 'none.ply')
    (tmp_path / 'folder.ply').mkdir()
    with pytest.raises(InputError, match='is a folder'):
        read_view(tmp_path / 'folder.ply')
    (tmp_path / 'a.stl').write_text('solid')
    with pytest.raises(InputError, match='none of'):
        read_view(tmp_path / 'a.stl')
    (tmp_path / 'a.ply.gz').write_bytes(b'ply\n')
    with pytest.raises(InputError, match='gzip'):
        read_view(tmp_path / 'a.ply.gz')


@pytest.mark.skipif(os.geteuid() == 0, reason='root may read everything')
def test_forbidden(tmp_path):
    path = tmp_path / 'a.xyz'
    path.write_text('1 2 3\n')
    path.chmod(0)
    with pytest.raises(InputError, match='cannot be read'):
        read_view(path)


@pytest.mark.parametrize(
    ('scale', 'stated', 'expected'),
    [(0.1, 'auto', 'm'), (150.0, 'auto', 'mm'), (0.1, 'mm', 'mm'), (150.0, 'm', 'm')],
)
def test_units(tmp_path, scale, stated, expected):
    path = tmp_path / 'a.xyz'
    np.savetxt(path, scale * np.random.default_rng(2).random((20, 3)))
    noted = read_view_noted(path, units=stated)
    assert noted.view.units == expected
    assert any('units inferred' in note for note in noted.notes) == (stated == 'auto')


def test_units_far_from_the_origin_and_without_extent(tmp_path):
    path = tmp_path / 'a.xyz'
    np.savetxt(path, 1e6 + 0.1 * np.random.default_rng(3).random((20, 3)), fmt='%.9f')
    assert read_view(path).units == 'm'
    path.write_text('1 2 3\n' * 5)
    view = read_view(path)
    assert view.units == 'unknown'
    assert len(view.points) == 5  # duplicated points are the engine's to judge


def test_convert_units():
    view = RangeView('v', np.array([[1.0, 2.0, 3.0]]), sensor=SensorModel('pinhole', (0, 0, 2.0)),
                     units='m')
    other = convert(view, 'mm')
    np.testing.assert_allclose(other.points, [[1000, 2000, 3000]])
    assert other.sensor.origin == (0, 0, 2000)
    assert other.units == 'mm'
    np.testing.assert_allclose(convert(other, 'm').points, view.points)
    assert convert(view, 'm') is view
    with pytest.raises(ParameterError, match="'u' from unknown to m"):
        convert(RangeView('u', view.points), 'm')


def test_choices_are_checked(tmp_path):
    path = tmp_path / 'a.xyz'
    path.write_text('1 2 3\n')
    with pytest.raises(ParameterError, match="units: 'inch'"):
        read_view(path, units='inch')
    with pytest.raises(ParameterError, match="sensor: 'up'"):
        read_view(path, sensor='up')
