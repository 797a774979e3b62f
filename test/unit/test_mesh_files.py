# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Files of surfaces. Truth: a box of known size and colours, read by two other libraries."""

import json
import struct

import numpy as np
import pytest
from ros_rops.core.config import Config
from ros_rops.core.errors import ParameterError
from ros_rops.core.groups_model import formats_of
from ros_rops.modelling.products import SurfaceMesh
from ros_rops.recordings.reader import read_mesh
from ros_rops.reporting.mesh_files import write_surface
from ros_rops.reporting.residual_colours import reach_of, residual_colors

SIZE = np.array([120.0, 80.0, 45.5])
"""Of the box, in mm."""
SHADES = np.array([[0, 0, 0], [255, 255, 255], [188, 60, 10], [3, 128, 254]], np.uint8)
FORMATS = ('ply', 'stl', 'obj', 'glb')


def _box(units='mm', colors=True, filled=False):
    trimesh = pytest.importorskip('trimesh')
    box = trimesh.creation.box(SIZE)
    vertices = (np.array(box.vertices) + 5.0) * {'mm': 1.0, 'm': 1e-3}[units]
    return SurfaceMesh(
        vertices, np.array(box.faces, np.int32), np.array(box.vertex_normals, np.float32),
        np.tile(SHADES, (2, 1)) if colors else None,
        np.arange(12) < (3 if filled else 0), {'voxel': 1.25, 'method': 'volume'})


def _write(tmp_path, kind, surface, units):
    path = tmp_path / f'box.{kind}'
    write_surface(path, surface, units=units, about='frame: object_0, voxel: 1.25')
    return path


@pytest.mark.parametrize('units', ['mm', 'm'])
@pytest.mark.parametrize('kind', FORMATS)
def test_two_libraries_read_the_size_that_was_written(tmp_path, kind, units):
    trimesh, open3d = pytest.importorskip('trimesh'), pytest.importorskip('open3d')
    path = _write(tmp_path, kind, _box(units), units)
    # Only glTF says in its standard what a length is in.
    size = SIZE * (1e-3 if units == 'm' or kind == 'glb' else 1.0)
    one = trimesh.load(path, force='mesh')
    np.testing.assert_allclose(one.extents, size, rtol=1e-6)
    assert one.is_watertight and one.volume == pytest.approx(size.prod(), rel=1e-4)
    other = open3d.io.read_triangle_mesh(str(path))
    np.testing.assert_allclose(np.ptp(np.asarray(other.vertices), axis=0), size, rtol=1e-6)
    assert len(other.triangles) == 12
    if kind != 'glb':  # which our own reader does not know
        np.testing.assert_allclose(np.ptp(read_mesh(path)[0], axis=0), size, rtol=1e-6)


@pytest.mark.parametrize('kind', ['ply', 'obj'])
def test_colours_and_normals_are_kept(tmp_path, kind):
    open3d = pytest.importorskip('open3d')
    surface = _box()
    found = open3d.io.read_triangle_mesh(str(_write(tmp_path, kind, surface, 'mm')))
    # By place: not every reader keeps the order.
    away = np.linalg.norm(np.asarray(found.vertices)[:, None] - surface.vertices, axis=2)
    same = away.argmin(axis=1)
    np.testing.assert_allclose(
        np.asarray(found.vertex_colors) * 255, surface.colors[same], atol=0.6)
    np.testing.assert_allclose(
        np.asarray(found.vertex_normals), surface.normals[same], atol=1e-4)
    plain = open3d.io.read_triangle_mesh(str(_write(tmp_path, kind, _box(colors=False), 'mm')))
    assert not plain.has_vertex_colors()


def _glb(path):
    """Return the document and the bytes of a GLB."""
    data = path.read_bytes()
    magic, version, length, size, kind = struct.unpack_from('<4sIII4s', data)
    assert (magic, version, length, kind) == (b'glTF', 2, len(data), b'JSON')
    assert size % 4 == 0 and length % 4 == 0
    return json.loads(data[20:20 + size]), data[28 + size:]


def _array(document, data, number):
    accessor = document['accessors'][number]
    place = document['bufferViews'][accessor['bufferView']]
    kind = {5126: '<f4', 5123: '<u2', 5125: '<u4'}[accessor['componentType']]
    width = {'SCALAR': 1, 'VEC3': 3, 'VEC4': 4}[accessor['type']]
    assert place['byteOffset'] % 4 == 0
    values = np.frombuffer(data, kind, accessor['count'] * width, place['byteOffset'])
    return values.reshape(-1, width)


def test_a_glb_is_in_metres_and_its_colours_are_linear(tmp_path):
    surface = _box()
    document, data = _glb(_write(tmp_path, 'glb', surface, 'mm'))
    assert document['asset']['extras'] == {
        'units': 'm', 'source_units': 'mm', 'metres_per_unit': 0.001,
        'about': 'frame: object_0, voxel: 1.25'}
    parts = document['meshes'][0]['primitives'][0]
    points = _array(document, data, parts['attributes']['POSITION'])
    np.testing.assert_allclose(points, surface.vertices * 1e-3, rtol=1e-6)
    assert document['accessors'][0]['min'] == points.min(axis=0).tolist()
    linear = _array(document, data, parts['attributes']['COLOR_0'])[:, :3] / 65535
    # IEC 61966-2-1, by hand: half of the light is 188 of 255.
    assert linear[2, 0] == pytest.approx(0.5029, abs=2e-4)
    assert linear[2, 2] == pytest.approx(10 / 255 / 12.92, abs=1e-5)
    assert linear[0].tolist() == [0, 0, 0] and linear[1].tolist() == [1, 1, 1]
    # And back: no shade is lost.
    back = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
    np.testing.assert_array_equal(np.rint(back * 255), surface.colors)


def test_units_are_written_down(tmp_path):
    for units in ('mm', 'm', 'unknown'):
        surface = _box()
        for kind in ('ply', 'obj'):
            head = _write(tmp_path, kind, surface, units).read_bytes()[:200]
            assert f'units: {units}\n'.encode() in head and b'voxel: 1.25' in head
        head = _write(tmp_path, 'stl', surface, units).read_bytes()[:80]
        # A reader that sees 'solid' takes it for text.
        assert f'units: {units};'.encode() in head and not head.startswith(b'solid')
    document, data = _glb(_write(tmp_path, 'glb', surface, 'unknown'))
    assert document['asset']['extras']['source_units'] == 'unknown'
    np.testing.assert_allclose(np.ptp(_array(document, data, 0), axis=0), SIZE, rtol=1e-6)


def test_faces_where_nothing_was_seen_are_marked(tmp_path):
    trimesh = pytest.importorskip('trimesh')
    path = _write(tmp_path, 'ply', _box(filled=True), 'mm')
    assert b'property uchar filled' in path.read_bytes()[:600]
    raw = trimesh.load(path, force='mesh').metadata['_ply_raw']['face']['data']
    assert raw['filled'].tolist() == [1, 1, 1] + [0] * 9
    assert b'filled' not in _write(tmp_path, 'ply', _box(), 'mm').read_bytes()


def test_lists_of_formats():
    assert formats_of(' ply, STL,ply,') == ('ply', 'stl') and formats_of('') == ()
    with pytest.raises(ParameterError, match=r"model.formats: 'step' is none of ply, stl"):
        Config.from_flat({'model.formats': 'ply,step'})


@pytest.mark.parametrize('name', ['box', 'box.txt'])
def test_a_suffix_that_is_no_format_is_refused(tmp_path, name):
    with pytest.raises(ParameterError):
        write_surface(tmp_path / name, _box(), units='mm')


def test_scale_of_residuals_is_round_and_leaves_out_what_is_contradicted():
    residual = np.append(np.linspace(-0.00026, 0.00026, 101), [0.5, np.nan]).astype(np.float32)
    state = np.append(np.ones(101), [2, 0]).astype(np.uint8)
    assert reach_of(residual, state) == 0.0003
    assert reach_of(1000 * residual, state) == 0.3  # the same in mm
    assert reach_of(np.array([np.nan], np.float32), None) == 1.0


def test_residuals_are_blue_behind_and_red_in_front():
    residual = np.array([-9.0, 0.0, 9.0, np.nan, 0.1], np.float32)
    colors = residual_colors(residual, np.array([1, 1, 1, 0, 2], np.uint8), 2.0)
    behind, on, front, alone, against = colors.astype(int)
    assert behind[2] > behind[0] + 50 and front[0] > front[2] + 50 and on.min() > 180
    assert np.ptp(alone) < 10 and tuple(alone) != tuple(on) and against[1] == 0
