# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
A surface as PLY, STL, OBJ and GLB; what its lengths are in is written into each.

PLY, STL and OBJ keep the units of the views and say which: in comments, and of STL in the 80
bytes before the triangles. GLB is in metres, as glTF has it, and keeps what it was in
`asset.extras`; its colours are linear. Vertices are float64 in PLY, float32 in STL and GLB, whose
formats have no other.
"""

from collections.abc import Callable, Mapping
import json
from pathlib import Path
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ParameterError
from ros_rops.core.groups_model import FORMATS
from ros_rops.core.types import Bytes
from ros_rops.modelling.products import SurfaceMesh

METRES = {'m': 1.0, 'mm': 1e-3}
CHUNK = 50_000
"""Lines of text made at once."""
# glTF 2.0, 3.6.2.2 and 3.7.2.1.
FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
VERTICES, INDICES = 34962, 34963


def write_surface(path: Path, surface: SurfaceMesh, *, units: str, about: str = '') -> None:
    """
    Write a surface; the suffix says how.

    Parameters
    ----------
    path : Path
        Ends in .ply, .stl, .obj or .glb.
    surface : SurfaceMesh
    units : {'m', 'mm', 'unknown'}
        Of its lengths.
    about : str
        What else the file should say, in a line.

    Raises
    ------
    OSError
        If it cannot be written.
    ParameterError
        If the suffix is another.
    """
    kind = path.suffix.removeprefix('.').lower()
    if kind not in WRITERS:
        raise ParameterError(f'path: {str(path)!r} does not end in .{", .".join(FORMATS)}')
    path.write_bytes(WRITERS[kind](surface, units, ' '.join(about.split())))


def ply_bytes(
    elements: Mapping[str, NDArray], comments: tuple[str, ...] = (), faces: NDArray | None = None,
    face_flags: Mapping[str, NDArray] | None = None,
) -> bytes:
    """
    Return a binary PLY.

    Parameters
    ----------
    elements : mapping of str to (N,) array
        Properties of the vertices: float64, float32, int32 or uint8.
    comments : tuple of str
        A line each.
    faces : (F, 3) int32, optional
    face_flags : mapping of str to (F,) uint8, optional
        Further properties of the faces.
    """
    lines = ['ply', 'format binary_little_endian 1.0', *(f'comment {text}' for text in comments)]
    rows = _rows(elements)
    lines += [f'element vertex {len(rows)}', *_properties(rows)]
    body = rows.tobytes()
    if faces is not None:
        flags = _rows(face_flags or {}, len(faces))
        cells = np.empty(len(faces), [('n', 'u1'), ('v', '<i4', 3), ('flags', flags.dtype)])
        cells['n'], cells['v'], cells['flags'] = 3, faces, flags
        lines += [f'element face {len(faces)}', 'property list uchar int vertex_indices',
                  *_properties(flags)]
        body += cells.tobytes()
    return '\n'.join([*lines, 'end_header', '']).encode() + body


_PLY_NAMES = {'<f8': 'double', '<f4': 'float', '<i4': 'int', '|u1': 'uchar'}


def _rows(columns: Mapping[str, NDArray], count: int = 0) -> NDArray:
    for values in columns.values():
        count = len(values)
    rows = np.empty(count, [(name, values.dtype.newbyteorder('<'))
                            for name, values in columns.items()])
    for name, values in columns.items():
        rows[name] = values
    return rows


def _properties(rows: NDArray) -> list[str]:
    return [f'property {_PLY_NAMES[rows.dtype[name].str]} {name}'
            for name in rows.dtype.names or ()]


def _ply(surface: SurfaceMesh, units: str, about: str) -> bytes:
    columns = dict(zip('xyz', surface.vertices.T, strict=True))
    columns |= dict(zip(('nx', 'ny', 'nz'), surface.normals.T, strict=True))
    if surface.colors is not None:
        columns |= dict(zip(('red', 'green', 'blue'), surface.colors.T, strict=True))
    # 1 where no view saw a surface.
    flags = {'filled': surface.filled.astype(np.uint8)} if surface.filled.any() else None
    return ply_bytes(columns, _said(units, about), surface.faces, flags)


def _stl(surface: SurfaceMesh, units: str, about: str) -> bytes:
    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    cells = np.zeros(len(corners), [('normal', '<f4', 3), ('corners', '<f4', (3, 3)),
                                    ('attribute', '<u2')])
    cells['normal'] = normals / np.where(length > 0, length, 1.0)
    cells['corners'] = corners
    # Not 'solid', by which readers tell the textual kind.
    header = f'binary STL, {"; ".join(_said(units, about))}'.encode('ascii', 'replace')
    return header[:80].ljust(80) + struct.pack('<I', len(cells)) + cells.tobytes()


def _obj(surface: SurfaceMesh, units: str, about: str) -> bytes:
    head = ''.join(f'# {text}\n' for text in _said(units, about))
    vertices, line = surface.vertices, 'v %.10g %.10g %.10g\n'
    if surface.colors is not None:
        # Not of the format, but of most that read and write it.
        vertices = np.hstack([vertices, surface.colors / 255.0])
        line = 'v %.10g %.10g %.10g %.4f %.4f %.4f\n'
    faces = np.repeat(surface.faces + 1, 2, axis=1)
    return (head + _lines(line, vertices) + _lines('vn %.5f %.5f %.5f\n', surface.normals)
            + _lines('f %d//%d %d//%d %d//%d\n', faces)).encode()


def _lines(line: str, rows: NDArray) -> str:
    parts = [rows[at:at + CHUNK] for at in range(0, len(rows), CHUNK)]
    return ''.join((line * len(part)) % tuple(part.ravel().tolist()) for part in parts)


def _glb(surface: SurfaceMesh, units: str, about: str) -> bytes:
    scale = METRES.get(units, 1.0)
    blobs = _Blobs()
    attributes = {
        'POSITION': blobs.add((surface.vertices * scale).astype('<f4'), 'VEC3', FLOAT, VERTICES,
                              bounds=True),
        'NORMAL': blobs.add(surface.normals.astype('<f4'), 'VEC3', FLOAT, VERTICES)}
    if surface.colors is not None:
        attributes['COLOR_0'] = blobs.add(
            _linear(surface.colors), 'VEC4', UNSIGNED_SHORT, VERTICES, normalized=True)
    faces = blobs.add(surface.faces.astype('<u4').reshape(-1), 'SCALAR', UNSIGNED_INT, INDICES)
    material = {'pbrMetallicRoughness': {'metallicFactor': 0.0, 'roughnessFactor': 0.8},
                'doubleSided': True}
    document = {
        'asset': {'version': '2.0', 'generator': 'ros_rops',
                  'extras': {'units': 'm', 'source_units': units, 'metres_per_unit': scale,
                             'about': about}},
        'scene': 0, 'scenes': [{'nodes': [0]}], 'nodes': [{'mesh': 0}],
        'meshes': [{'primitives': [{'attributes': attributes, 'indices': faces, 'material': 0}]}],
        'materials': [material], 'accessors': blobs.accessors, 'bufferViews': blobs.views,
        'buffers': [{'byteLength': len(blobs.data)}]}
    text = json.dumps(document, separators=(',', ':')).encode()
    chunks = [(b'JSON', text + b' ' * (-len(text) % 4)), (b'BIN\0', bytes(blobs.data))]
    body = b''.join(struct.pack('<I', len(data)) + name + data for name, data in chunks)
    return struct.pack('<4sII', b'glTF', 2, 12 + len(body)) + body


class _Blobs:
    """Arrays of a GLB, one behind the other."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(
        self, values: NDArray, kind: str, component: int, target: int, *,
        bounds: bool = False, normalized: bool = False,
    ) -> int:
        """Add an array; return the number of its accessor."""
        data = np.ascontiguousarray(values).tobytes()
        self.views.append({'buffer': 0, 'byteOffset': len(self.data), 'byteLength': len(data),
                           'target': target})
        self.data += data + bytes(-len(data) % 4)
        accessor: dict[str, Any] = {
            'bufferView': len(self.views) - 1, 'componentType': component, 'count': len(values),
            'type': kind}
        if bounds and len(values):
            accessor |= {'min': values.min(axis=0).tolist(), 'max': values.max(axis=0).tolist()}
        if normalized:
            accessor['normalized'] = True
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _linear(colors: Bytes) -> NDArray:
    """Return sRGB colours as linear RGBA of 16 bits: 8 would lose what is dark."""
    x = np.arange(256) / 255.0
    table = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    shades = np.rint(table * 65535).astype('<u2')
    return np.hstack([shades[colors], np.full((len(colors), 1), 65535, '<u2')])


def _said(units: str, about: str) -> tuple[str, ...]:
    return (f'units: {units}', *([about] if about else ()))


WRITERS: Mapping[str, Callable[[SurfaceMesh, str, str], bytes]] = dict(
    zip(FORMATS, (_ply, _stl, _obj, _glb), strict=True))
