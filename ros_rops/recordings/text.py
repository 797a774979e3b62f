# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Lines of x y z (.xyz .txt .csv .asc), blanks, commas or semicolons between the numbers."""

import io
import re

import numpy as np
from numpy.typing import NDArray

from ros_rops.recordings.cloud import Cloud, FormatError

DECIMAL_COMMAS = re.compile(
    rb'^[ \t]*[-+]?\d+,\d+(?:[; \t]+[-+]?\d+,\d+){2,}[ \t;]*\r?$', re.MULTILINE)
"""A line such as `1,5; 2,5; 3,5`: commas inside the numbers, something else between them."""
HEADER_LINES = 20
"""Most lines without three numbers that may stand before the first point."""


def parse(data: bytes) -> Cloud:
    """
    Return the cloud of a text file.

    Comments begin with `#`, `%` or `//`. Columns four to six are colours if all are whole
    numbers within 0-255 and one exceeds 1; otherwise they, and any further column, are ignored.

    Raises
    ------
    FormatError
        If the bytes are no text, no line holds three numbers, or a line has too few columns.
    """
    if b'\0' in data:
        raise FormatError('is not a text file (it holds zero bytes)')
    text = data.removeprefix(b'\xef\xbb\xbf')
    if b',' in text and DECIMAL_COMMAS.search(text[:4096]):
        text = text.replace(b',', b'.')
    for old, new in ((b'//', b'#'), (b'%', b'#'), (b',', b' '), (b';', b' ')):
        if old in text:
            text = text.replace(old, new)
    body = text[_first_point(text):]
    comments = '#' if b'#' in body else None
    try:
        table = np.loadtxt(io.StringIO(body.decode('latin-1')), comments=comments, ndmin=2)
    except ValueError as error:
        raise FormatError(f'is not a table of numbers ({error})') from None
    if table.shape[1] < 3:
        raise FormatError(f'has {table.shape[1]} columns, not x y z')
    return _cloud(table)


def _first_point(text: bytes) -> int:
    """Return where the first line with three numbers begins."""
    start = 0
    for _ in range(HEADER_LINES):
        stop = text.find(b'\n', start)
        line = text[start:] if stop < 0 else text[start:stop]
        if _is_point(line):
            return start
        if stop < 0:
            break
        start = stop + 1
    raise FormatError(f'has no line with three numbers among its first {HEADER_LINES}')


def _is_point(line: bytes) -> bool:
    words = line.split(b'#')[0].split()
    if len(words) < 3:
        return False
    try:
        [float(word) for word in words]
    except ValueError:
        return False
    return True


def _cloud(table: NDArray[np.float64]) -> Cloud:
    points = np.ascontiguousarray(table[:, :3])
    if table.shape[1] == 3:
        return Cloud(points)
    extra = table[:, 3:6]
    whole = extra.shape[1] == 3 and bool(
        ((extra >= 0) & (extra <= 255) & (extra == np.rint(extra))).all())
    if whole and extra.max() > 1:
        return Cloud(points, colors=extra.astype(np.uint8), notes=(
            'columns 4-6 taken as colours (whole numbers within 0-255)',))
    return Cloud(points, notes=(f'columns 4-{table.shape[1]} ignored',))
