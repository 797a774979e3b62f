# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The rows of one PLY element, scalars and lists, from numbers (ASCII) or bytes (binary)."""

from dataclasses import dataclass
import struct
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ros_rops.recordings.cloud import FormatError

if TYPE_CHECKING:
    from ros_rops.recordings.ply import Element, Property


@dataclass(frozen=True, slots=True)
class ListColumn:
    """A list property: the length of every row's list (N,), and all values, row after row."""

    lengths: NDArray[np.int64]
    values: NDArray


Column = NDArray | ListColumn


def read_rows(
    element: 'Element', order: str, source: bytes | NDArray[np.float64], start: int
) -> tuple[dict[str, Column], int]:
    """
    Return the columns of an element by property name, and where the next element starts.

    Parameters
    ----------
    element : Element
    order : {'', '<', '>'}
        '' if `source` holds the numbers of an ASCII body, else the byte order.
    source : bytes or (M,) float64
    start : int
        Position in `source` (bytes or numbers) of the element's first row.

    Raises
    ------
    FormatError
        If `source` ends too early or a list's length is not one.
    """
    if not element.properties or not element.count:
        empty = {p.name: _no_rows(p) for p in element.properties}
        return empty, start
    ascii_body = order == ''
    smallest = sum(1 if ascii_body else _size(p.length or p.dtype) for p in element.properties)
    if element.count * smallest > len(source) - start:
        raise _truncated(element)
    if not any(p.length for p in element.properties):
        if isinstance(source, bytes):
            return _binary_scalars(element, order, source, start)
        return _ascii_scalars(element, source, start)
    if len(element.properties) == 1:
        regular = _regular_lists(element, order, source, start)
        if regular is not None:
            return regular
        if isinstance(source, bytes):
            return _byte_lists(element, order, source, start)
        return _number_lists(element, source, start)
    if isinstance(source, bytes):
        return _walk_bytes(element, order, source, start)
    return _walk_numbers(element, source, start)


def _no_rows(prop: 'Property') -> Column:
    if prop.length is None:
        return np.zeros(0, prop.dtype)
    return ListColumn(np.zeros(0, np.int64), np.zeros(0, prop.dtype))


def _size(dtype: str) -> int:
    return np.dtype(dtype).itemsize


def _truncated(element: 'Element') -> FormatError:
    return FormatError(f'is truncated: element "{element.name}" should have {element.count} rows')


def _binary_scalars(
    element: 'Element', order: str, source: bytes, start: int
) -> tuple[dict[str, Column], int]:
    names = [f'f{i}' for i in range(len(element.properties))]  # a name may come twice
    formats = [order + p.dtype for p in element.properties]
    dtype = np.dtype({'names': names, 'formats': formats})
    rows = np.frombuffer(source, dtype, element.count, start)
    columns: dict[str, Column] = {
        p.name: rows[n].astype(p.dtype) for p, n in zip(element.properties, names, strict=True)
    }
    return columns, start + rows.nbytes


def _ascii_scalars(
    element: 'Element', source: NDArray[np.float64], start: int
) -> tuple[dict[str, Column], int]:
    width = len(element.properties)
    stop = start + element.count * width
    rows = source[start:stop].reshape(element.count, width)
    return {p.name: _typed(rows[:, i], p.dtype) for i, p in enumerate(element.properties)}, stop


def _typed(values: NDArray[np.float64], dtype: str) -> NDArray:
    """Keep floats as parsed (ASCII may state more digits than its type); check integers."""
    if dtype.startswith('f'):
        return values
    bounds = np.iinfo(dtype)
    if not (np.isfinite(values).all() and (values >= bounds.min).all()
            and (values <= bounds.max).all()):
        raise FormatError('holds a number that does not fit the type of its property')
    return values.astype(dtype)


def _regular_lists(
    element: 'Element', order: str, source: bytes | NDArray[np.float64], start: int
) -> tuple[dict[str, Column], int] | None:
    """Read rows of one list each, all of one length (faces), at once; None if they are not."""
    prop = element.properties[0]
    if isinstance(source, bytes):
        length = int(np.frombuffer(source, order + str(prop.length), 1, start)[0])
        if length < 0:
            return None
        dtype = np.dtype([('n', order + str(prop.length)), ('v', order + prop.dtype, (length,))])
        stop = start + element.count * dtype.itemsize
        if stop > len(source):
            return None
        rows = np.frombuffer(source, dtype, element.count, start)
        if not (rows['n'] == length).all():
            return None
        values = rows['v'].astype(prop.dtype)
    else:
        first = source[start]
        if not (np.isfinite(first) and 0 <= first == int(first)):
            return None
        length = int(first)
        stop = start + element.count * (length + 1)
        if stop > len(source):
            return None
        table = source[start:stop].reshape(element.count, length + 1)
        if not (table[:, 0] == length).all():
            return None
        values = _typed(table[:, 1:], prop.dtype)
    lengths = np.full(element.count, length, np.int64)
    return {prop.name: ListColumn(lengths, values.reshape(-1))}, stop


def _number_lists(
    element: 'Element', source: NDArray[np.float64], start: int
) -> tuple[dict[str, Column], int]:
    """Read rows of one list each (a range grid): find where they start, then gather."""
    prop = element.properties[0]
    with np.errstate(invalid='ignore'):
        steps = source[start:].astype(np.int64)
    heads = _heads(steps.tolist(), element, 1, 1)
    lengths = steps[heads]
    if (lengths < 0).any() or (lengths != source[start + heads]).any():
        raise FormatError('has a list whose length is no whole number')
    stop = int(heads[-1] + 1 + lengths[-1])
    if stop > len(steps):
        raise _truncated(element)
    inside = np.ones(stop, dtype=bool)
    inside[heads] = False
    values = _typed(source[start:start + stop][inside], prop.dtype)
    return {prop.name: ListColumn(lengths, values)}, start + stop


def _byte_lists(
    element: 'Element', order: str, source: bytes, start: int
) -> tuple[dict[str, Column], int]:
    """Read rows of one list each from bytes; long and signed lengths take the slower way."""
    prop = element.properties[0]
    if prop.length != 'u1':
        return _walk_bytes(element, order, source, start)
    size = _size(prop.dtype)
    body = source[start:]
    heads = _heads(body, element, 1, size)
    lengths = np.frombuffer(body, np.uint8)[heads].astype(np.int64)
    stop = int(heads[-1] + 1 + lengths[-1] * size)
    if stop > len(body):
        raise _truncated(element)
    inside = np.ones(stop, dtype=bool)
    inside[heads] = False
    packed = np.frombuffer(body, np.uint8, stop)[inside].tobytes()
    values = np.frombuffer(packed, order + prop.dtype).astype(prop.dtype)
    return {prop.name: ListColumn(lengths, values)}, start + stop


def _heads(
    lengths: bytes | list[int], element: 'Element', head: int, size: int
) -> NDArray[np.int64]:
    """Return where each row starts, if entry k of `lengths` is the length of a list there."""
    heads = []
    at = 0
    try:
        for _ in range(element.count):
            heads.append(at)
            at += head + size * lengths[at]
    except IndexError:
        raise _truncated(element) from None
    return np.array(heads, np.int64)


def _walk_numbers(
    element: 'Element', source: NDArray[np.float64], start: int
) -> tuple[dict[str, Column], int]:
    numbers = source[start:].tolist()  # plain floats: indexing them is ten times faster
    found: list[list[float]] = [[] for _ in element.properties]
    lengths: list[list[int]] = [[] for _ in element.properties]
    at = 0
    try:
        for _ in range(element.count):
            for k, prop in enumerate(element.properties):
                count = 1
                if prop.length is not None:
                    count = int(numbers[at])
                    if count != numbers[at] or count < 0:
                        raise FormatError(f'has a list of length {numbers[at]}')
                    lengths[k].append(count)
                    at += 1
                if count == 1:
                    found[k].append(numbers[at])
                elif count:
                    found[k].extend(numbers[at:at + count])
                at += count
    except (IndexError, ValueError, OverflowError):
        raise _truncated(element) from None
    if at > len(numbers):
        raise _truncated(element)
    return _columns(element, [np.asarray(f, np.float64) for f in found], lengths), start + at


def _walk_bytes(
    element: 'Element', order: str, source: bytes, start: int
) -> tuple[dict[str, Column], int]:
    codes = {'i1': 'b', 'u1': 'B', 'i2': 'h', 'u2': 'H', 'i4': 'i', 'u4': 'I', 'f4': 'f',
             'f8': 'd'}
    plan = [
        (struct.Struct(order + codes[p.length]) if p.length else None, codes[p.dtype],
         _size(p.dtype))
        for p in element.properties
    ]
    found: list[list[float]] = [[] for _ in plan]
    lengths: list[list[int]] = [[] for _ in plan]
    at = start
    try:
        for _ in range(element.count):
            for k, (head, code, size) in enumerate(plan):
                count = 1
                if head is not None:
                    count = head.unpack_from(source, at)[0]
                    if count < 0 or count * size > len(source) - at:
                        raise _truncated(element)
                    lengths[k].append(count)
                    at += head.size
                if count:
                    found[k].extend(struct.unpack_from(f'{order}{count}{code}', source, at))
                at += count * size
    except struct.error:
        raise _truncated(element) from None
    return _columns(element, [np.asarray(f, np.float64) for f in found], lengths), at


def _columns(
    element: 'Element', found: list[NDArray[np.float64]], lengths: list[list[int]]
) -> dict[str, Column]:
    columns: dict[str, Column] = {}
    for prop, values, counts in zip(element.properties, found, lengths, strict=True):
        typed = _typed(values, prop.dtype)
        columns[prop.name] = (
            typed if prop.length is None else ListColumn(np.asarray(counts, np.int64), typed)
        )
    return columns
