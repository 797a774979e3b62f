# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
PLY: ASCII and binary, Stanford `range_grid`, any property order, colour, unknown parts skipped.

`parse` gives a range view's cloud, `parse_mesh` the vertices and triangles of a model.
"""

from dataclasses import dataclass
from typing import Any
import warnings

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError
from ros_rops.recordings.cloud import Cloud, FormatError, to_bytes
from ros_rops.recordings.ply_lists import Column, ListColumn, read_rows
from ros_rops.recordings.view_facts import decode_facts, ViewFacts

TYPES = {
    'char': 'i1', 'uchar': 'u1', 'short': 'i2', 'ushort': 'u2', 'int': 'i4', 'uint': 'u4',
    'float': 'f4', 'double': 'f8', 'int8': 'i1', 'uint8': 'u1', 'int16': 'i2', 'uint16': 'u2',
    'int32': 'i4', 'uint32': 'u4', 'float32': 'f4', 'float64': 'f8',
}  # fmt: skip
ORDERS = {'ascii': '', 'binary_little_endian': '<', 'binary_big_endian': '>'}
FACTS_MARK = 'ros_rops_view'
"""The comment that follows this word is the JSON of `view_facts`."""
COLOR_NAMES = (
    ('red', 'green', 'blue'),
    ('diffuse_red', 'diffuse_green', 'diffuse_blue'),
    ('r', 'g', 'b'),
)


@dataclass(frozen=True, slots=True)
class Property:
    """One property of an element: its numpy type, and the type of its length if a list."""

    name: str
    dtype: str
    length: str | None = None


@dataclass(frozen=True, slots=True)
class Element:
    """One element of the header."""

    name: str
    count: int
    properties: list[Property]


@dataclass(frozen=True, slots=True)
class Header:
    """What the header says: byte order ('' for ASCII), elements, `obj_info` words, our facts."""

    order: str
    elements: list[Element]
    info: dict[str, str]
    facts: ViewFacts | None = None


def parse(data: bytes) -> Cloud:
    """
    Return the cloud of a PLY file.

    Raises
    ------
    FormatError
        If the bytes are no PLY file, are truncated, or contradict their header.
    """
    header, tables = _read_tables(data)
    vertices = tables.get('vertex')
    if vertices is None:
        raise FormatError('has no element "vertex"')
    points = _stack(vertices, ('x', 'y', 'z'))
    if points is None:
        raise FormatError('its vertices lack x, y or z')
    colors = None
    for names in COLOR_NAMES:
        stacked = _stack(vertices, names)
        if stacked is not None:
            colors = to_bytes(stacked)
            break
    grid = _range_grid(header, tables, len(points))
    return Cloud(points.astype(np.float64), grid, colors, facts=header.facts)


def parse_mesh(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """
    Return vertices (N, 3) and triangles (F, 3) of a PLY model.

    Raises
    ------
    FormatError
        As `parse`, and if a face is missing, no triangle or out of range.
    """
    points = parse(data).points
    faces = _read_tables(data)[1].get('face', {})
    column = faces.get('vertex_indices', faces.get('vertex_index'))
    if not isinstance(column, ListColumn):
        raise FormatError('has no faces')
    if np.any(column.lengths != 3):
        raise FormatError('has faces that are not triangles')
    triangles = column.values.reshape(-1, 3)
    if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
        raise FormatError('has a face that names a vertex which does not exist')
    return points, triangles.astype(np.int32)


def parse_vertices(data: bytes, element: str = 'vertex') -> dict[str, NDArray[Any]]:
    """
    Return all properties of the vertices (or of another element) that are no lists, (N,) each.

    Raises
    ------
    FormatError
        As `parse`.
    """
    vertices = _read_tables(data)[1].get(element)
    if vertices is None:
        raise FormatError(f'has no element "{element}"')
    return {name: c for name, c in vertices.items() if isinstance(c, np.ndarray)}


def _read_tables(data: bytes) -> tuple[Header, dict[str, dict[str, Column]]]:
    header, start = _read_header(data)
    if header.order == '':
        return header, _ascii_tables(header, data[start:])
    tables = {}
    for element in header.elements:
        tables[element.name], start = read_rows(element, header.order, data, start)
    return header, tables


def _read_header(data: bytes) -> tuple[Header, int]:
    if not data.startswith((b'ply\n', b'ply\r')):
        raise FormatError('is not a PLY file (it does not begin with "ply")')
    end = data.find(b'end_header')
    newline = data.find(b'\n', end)
    if end < 0 or newline < 0:
        raise FormatError('is truncated: its PLY header has no end')
    order: str | None = None
    elements: list[Element] = []
    info: dict[str, str] = {}
    facts: ViewFacts | None = None
    for line in data[:end].decode('latin-1').splitlines()[1:]:
        words = line.split()
        match words:
            case ['format', name, *_]:
                order = ORDERS.get(name)
            case ['comment', mark, _, *_] if mark == FACTS_MARK:
                facts = _facts(line.partition(FACTS_MARK)[2])
            case ['obj_info', key, value, *_]:
                info[key] = value
            case ['element', name, count]:
                elements.append(Element(name, _whole(count, line), []))
            case ['property', *rest] if elements:
                elements[-1].properties.append(_property(rest, line))
            case [] | ['comment' | 'obj_info', *_]:
                pass
            case _:
                raise FormatError(f'has a header line that PLY does not know: {line[:60]!r}')
    if order is None:
        raise FormatError('states no PLY format that exists')
    return Header(order, elements, info, facts), newline + 1


def _facts(text: str) -> ViewFacts | None:
    """Return the facts of a comment; None for somebody else's, or damaged."""
    try:
        return decode_facts(text.strip().encode('latin-1'))
    except InputError:
        return None


def _whole(text: str, line: str) -> int:
    if not (text.isascii() and text.isdigit()) or len(text) > 15:
        raise FormatError(f'has a header line without a sensible count: {line[:60]!r}')
    return int(text)


def _property(words: list[str], line: str) -> Property:
    match words:
        case ['list', length, kind, name] if length in TYPES and kind in TYPES:
            if TYPES[length].startswith('f'):
                raise FormatError(f'has a list whose length is no integer: {line[:60]!r}')
            return Property(name, TYPES[kind], TYPES[length])
        case [kind, name] if kind in TYPES:
            return Property(name, TYPES[kind])
    raise FormatError(f'has a property that PLY does not know: {line[:60]!r}')


def _ascii_tables(header: Header, body: bytes) -> dict[str, dict[str, Column]]:
    with warnings.catch_warnings():
        warnings.simplefilter('error', DeprecationWarning)
        try:
            numbers = np.fromstring(body, dtype=np.float64, sep=' ')
        except (DeprecationWarning, ValueError):
            raise FormatError('holds something other than numbers after its header') from None
    tables: dict[str, dict[str, Column]] = {}
    start = 0
    for element in header.elements:
        tables[element.name], start = read_rows(element, '', numbers, start)
    return tables


def _stack(table: dict[str, Column], names: tuple[str, ...]) -> NDArray | None:
    columns = [table.get(name) for name in names]
    arrays = [column for column in columns if isinstance(column, np.ndarray)]
    return np.stack(arrays, axis=1) if len(arrays) == len(names) else None


def _range_grid(
    header: Header, tables: dict[str, dict[str, Column]], points: int
) -> NDArray[np.int32] | None:
    """Stanford's grid: one list a pixel, row by row, empty or the index of a vertex."""
    lists = [c for c in tables.get('range_grid', {}).values() if isinstance(c, ListColumn)]
    if not lists:
        return None
    cells = lists[0]
    try:
        width, height = int(header.info['num_cols']), int(header.info['num_rows'])
    except (KeyError, ValueError):
        raise FormatError('has a range_grid but no sound num_cols and num_rows') from None
    if width < 0 or height < 0 or width * height != len(cells.lengths):
        raise FormatError(
            f'has a range_grid of {len(cells.lengths)} entries, not num_cols x num_rows = '
            f'{width} x {height}')
    if cells.lengths.size and cells.lengths.max() > 1:
        raise FormatError('has a range_grid entry with more than one vertex')
    grid = np.full(width * height, -1, np.int32)
    if cells.values.size and (cells.values.min() < 0 or cells.values.max() >= points):
        raise FormatError('has a range_grid entry that names a vertex which does not exist')
    grid[cells.lengths == 1] = cells.values
    return grid.reshape(height, width)
