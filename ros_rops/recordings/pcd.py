# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""PCD 0.6 and 0.7: ASCII, binary and binary_compressed, organized or not, packed colour."""

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ros_rops.recordings import lzf
from ros_rops.recordings.cloud import Cloud, FormatError, full_grid

DTYPES = {
    ('F', '4'): '<f4', ('F', '8'): '<f8', ('I', '1'): 'i1', ('I', '2'): '<i2',
    ('I', '4'): '<i4', ('I', '8'): '<i8', ('U', '1'): 'u1', ('U', '2'): '<u2',
    ('U', '4'): '<u4', ('U', '8'): '<u8',
}  # fmt: skip
LARGEST = 2**31 - 1


def parse(data: bytes) -> Cloud:
    """
    Return the cloud of a PCD file, organized if HEIGHT > 1.

    Raises
    ------
    FormatError
        If the bytes are no PCD file, are truncated, or contradict their header.
    """
    header, start = _read_header(data)
    dtype = _record(header)
    width, height = _one(header, 'WIDTH'), _one(header, 'HEIGHT')
    count = width * height
    if _one(header, 'POINTS', count) != count:
        raise FormatError(f'states POINTS that are not WIDTH x HEIGHT = {width} x {height}')
    kind = header.get('DATA', [''])[0]
    if kind == 'ascii':
        columns = _ascii(data[start:], dtype, count)
    elif kind == 'binary':
        columns = _binary(data[start:], dtype, count)
    elif kind == 'binary_compressed':
        columns = _compressed(data[start:], dtype, count)
    else:
        raise FormatError(f'states a kind of DATA that PCD does not know: {kind[:30]!r}')
    try:
        axes = [columns[axis] for axis in 'xyz']
    except KeyError:
        raise FormatError('its FIELDS lack x, y or z') from None
    if any(axis.ndim != 1 for axis in axes):
        raise FormatError('its x, y or z has a COUNT other than 1')
    points = np.stack(axes, axis=1).astype(np.float64)
    grid = full_grid(height, width) if height > 1 else None
    note = _viewpoint_note(header)
    return Cloud(points, grid, _colors(columns), (note,) if note else ())


def _read_header(data: bytes) -> tuple[dict[str, list[str]], int]:
    header: dict[str, list[str]] = {}
    start = 0
    while 'DATA' not in header:
        stop = data.find(b'\n', start, start + 65536)
        if stop < 0:
            known = 'FIELDS' in header or data.startswith(b'# .PCD')
            raise FormatError('is truncated: its PCD header has no DATA line' if known
                              else 'is not a PCD file')
        words = data[start:stop].decode('latin-1').split()
        start = stop + 1
        if words and not words[0].startswith('#'):
            header[words[0]] = words[1:] or ['']
        if not header and start > 4096:
            raise FormatError('is not a PCD file')
    return header, start


def _one(header: dict[str, list[str]], key: str, default: int | None = None) -> int:
    if key not in header and default is not None:
        return default
    try:
        value = int(header[key][0])
    except (KeyError, ValueError):
        raise FormatError(f'its PCD header has no sound {key}') from None
    if not 0 <= value <= LARGEST:
        raise FormatError(f'its PCD header states {key} {value}')
    return value


def _record(header: dict[str, list[str]]) -> np.dtype:
    """Return the record of one point; PCD's padding fields `_` are kept under made-up names."""
    names = header.get('FIELDS', [])
    sizes, kinds = header.get('SIZE', []), header.get('TYPE', [])
    counts = header.get('COUNT', ['1'] * len(names))
    if not names or not len(names) == len(sizes) == len(kinds) == len(counts):
        raise FormatError('its FIELDS, SIZE, TYPE and COUNT do not agree')
    parts: list[tuple[Any, ...]] = []
    for k, (name, size, kind, number) in enumerate(
            zip(names, sizes, kinds, counts, strict=True)):
        if not (number.isascii() and number.isdigit() and len(number) <= 6):
            raise FormatError('its COUNT is no number')
        code = DTYPES.get((kind, size))
        if code is None:
            raise FormatError(f'its field {name[:30]!r} is of a type PCD does not know')
        unique = name if name not in (p[0] for p in parts) and name != '_' else f'_{k}'
        parts.append((unique, code, (int(number),)) if number != '1' else (unique, code))
    return np.dtype(parts)


def _ascii(body: bytes, dtype: np.dtype, count: int) -> dict[str, NDArray]:
    names = dtype.names or ()
    width = sum(int(np.prod(dtype[name].shape)) for name in names)
    if not count:
        return {name: np.zeros(0, dtype[name].base) for name in names}
    if not body.strip():
        raise FormatError(f'is truncated: no rows, not {count}')
    try:
        table = np.loadtxt(io.StringIO(body.decode('latin-1')), comments=None, ndmin=2)
    except ValueError as error:
        raise FormatError(f'is not a table of numbers ({error})') from None
    if table.shape != (count, width):
        raise FormatError(f'is truncated or damaged: {table.shape[0]} rows of {table.shape[1]} '
                          f'numbers, not {count} of {width}')
    columns, at = {}, 0
    for name in names:
        size = int(np.prod(dtype[name].shape))
        part = table[:, at] if dtype[name].shape == () else table[:, at:at + size]
        columns[name] = _packed(part, dtype[name].base) if name in ('rgb', 'rgba') else part
        at += size
    return columns


def _packed(values: NDArray[np.float64], dtype: np.dtype) -> NDArray:
    """Return a packed colour in its own type: its bits count, not its value."""
    whole = bool(np.isfinite(values).all() and (values == np.rint(values)).all())
    if dtype.kind == 'f' and not (whole and values.size and values.max() >= 1):
        return values.astype(np.float32)
    # Integers, and floats that some writers print as the integer they stand for.
    return np.clip(np.nan_to_num(values), 0, 2**32 - 1).astype(np.uint32)


def _binary(body: bytes, dtype: np.dtype, count: int) -> dict[str, NDArray]:
    if len(body) < count * dtype.itemsize:
        raise FormatError(f'is truncated: {len(body)} bytes of points, not '
                          f'{count * dtype.itemsize}')
    rows = np.frombuffer(body, dtype, count)
    return {name: rows[name] for name in dtype.names or ()}


def _compressed(body: bytes, dtype: np.dtype, count: int) -> dict[str, NDArray]:
    """Read field after field (not point after point) behind two sizes."""
    if len(body) < 8:
        raise FormatError('is truncated: its compressed data has no sizes')
    packed, size = (int(value) for value in np.frombuffer(body, '<u4', 2))
    if size != count * dtype.itemsize:
        raise FormatError(f'states {size} bytes of points, not {count * dtype.itemsize}')
    if len(body) < 8 + packed:
        raise FormatError(f'is truncated: {len(body) - 8} compressed bytes, not {packed}')
    plain = lzf.decompress(body[8:8 + packed], size)
    columns, at = {}, 0
    for name in dtype.names or ():
        field = dtype[name]
        values = np.frombuffer(plain, field.base, count * int(np.prod(field.shape)), at)
        columns[name] = values.reshape((count, *field.shape))
        at += values.nbytes
    return columns


def _colors(columns: dict[str, NDArray]) -> NDArray[np.uint8] | None:
    column = columns.get('rgb', columns.get('rgba'))
    if column is None or column.ndim != 1 or column.dtype.itemsize != 4:
        return None
    packed = np.ascontiguousarray(column).view(np.uint32)
    return np.stack([packed >> 16, packed >> 8, packed], axis=1).astype(np.uint8)


def _viewpoint_note(header: dict[str, list[str]]) -> str:
    stated = header.get('VIEWPOINT', [])
    if stated in ([], ['0', '0', '0', '1', '0', '0', '0']):
        return ''
    return f'VIEWPOINT {" ".join(stated)} not applied: the points are taken as the sensor saw them'
