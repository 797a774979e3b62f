# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Triangle models in STL, binary or ASCII; equal corners become one vertex."""

import re

import numpy as np
from numpy.typing import NDArray

from ros_rops.recordings.cloud import FormatError

VERTEX = re.compile(rb'\bvertex\s+(\S+)\s+(\S+)\s+(\S+)')
RECORD = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('attribute', '<u2')])
HEAD = 80


def parse_mesh(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """
    Return vertices (N, 3) and triangles (F, 3); triangles without an area are left out.

    Raises
    ------
    FormatError
        If the bytes are no STL file, are truncated or hold no triangle.
    """
    corners = _binary(data)
    if corners is None:
        corners = _ascii(data)
    if not np.isfinite(corners).all():
        raise FormatError('has a vertex that is not made of numbers')
    points, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    faces = index.reshape(-1, 3).astype(np.int32)
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if not len(faces):
        raise FormatError('has no faces')
    return points, faces


def _binary(data: bytes) -> NDArray[np.float64] | None:
    """Corners (F, 3, 3), or None if the bytes are no binary STL: its count must fit its size."""
    count = int.from_bytes(data[HEAD:HEAD + 4], 'little')
    if len(data) < HEAD + 4 or len(data) != HEAD + 4 + count * RECORD.itemsize:
        return None
    corners: NDArray[np.float64] = np.frombuffer(
        data, RECORD, offset=HEAD + 4)['corners'].astype(np.float64)
    return corners


def _ascii(data: bytes) -> NDArray[np.float64]:
    if not data.lstrip().startswith(b'solid') or b'facet' not in data:
        raise FormatError('is no STL model, or truncated')
    found = VERTEX.findall(data)
    if len(found) % 3 or b'endsolid' not in data:
        raise FormatError('is truncated: a triangle of its STL is not whole')
    try:
        return np.array(found).astype(np.float64).reshape(-1, 3, 3)
    except ValueError:
        raise FormatError('has a vertex that is not made of numbers') from None
