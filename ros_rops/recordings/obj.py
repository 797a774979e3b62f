# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Triangle models in Wavefront OBJ: vertices and faces, everything else skipped."""

import re

import numpy as np
from numpy.typing import NDArray

from ros_rops.recordings.cloud import FormatError

VERTEX = re.compile(rb'^v[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)', re.MULTILINE)
FACE = re.compile(rb'^f[ \t]+(.*)$', re.MULTILINE)


def parse_mesh(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """
    Return vertices (N, 3) and triangles (F, 3).

    Raises
    ------
    FormatError
        If there is no vertex or face, a number is none, or a face is no triangle of vertices.
    """
    vertices = VERTEX.findall(data)
    faces = [line.split() for line in FACE.findall(data)]
    if not vertices or not faces:
        raise FormatError('is no OBJ model: it has no vertices or no faces')
    if any(len(words) != 3 for words in faces):
        raise FormatError('has faces that are not triangles')
    try:
        points = np.array(vertices).astype(np.float64)
        numbers = np.array([int(w.partition(b'/')[0]) for words in faces for w in words])
    except (ValueError, OverflowError):
        raise FormatError('has a vertex or face that is not made of numbers') from None
    # Counted from 1, or backwards from the last vertex (exactly so where all come first).
    indices = np.where(numbers > 0, numbers - 1, numbers + len(points)).reshape(-1, 3)
    if (numbers == 0).any() or indices.min() < 0 or indices.max() >= len(points):
        raise FormatError('has a face that names a vertex which does not exist')
    return points, indices.astype(np.int32)
