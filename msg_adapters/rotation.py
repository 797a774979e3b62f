# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Rotations as geometry_msgs/Quaternion has them."""

import math

import numpy as np
from ros_rops.core.types import Floats


def quaternion(rotation: Floats) -> tuple[float, float, float, float]:
    """
    Return the unit quaternion x, y, z, w (w not negative) of a rotation (3, 3).

    By the largest of the four, which keeps all digits (Shepperd 1978).
    """
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(rotation, np.float64).tolist()
    squares = 1 + a - e - i, 1 - a + e - i, 1 - a - e + i, 1 + a + e + i
    rows = (
        (squares[0], b + d, c + g, h - f), (b + d, squares[1], f + h, c - g),
        (c + g, f + h, squares[2], d - b), (h - f, c - g, d - b, squares[3]))
    row = rows[squares.index(max(squares))]
    length = math.copysign(math.hypot(*row), row[3])
    x, y, z, w = (value / length for value in row)
    return x, y, z, w
