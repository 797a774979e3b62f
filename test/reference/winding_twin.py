# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""NumPy twin of the winding numbers: every triangle by itself (Van Oosterom, Strackee 1983)."""

import math

import numpy as np


def winding_number(vertices, faces, point):
    """Return how often the faces go round a point: the solid angles over the full sphere."""
    a, b, c = (vertices[faces[:, k]] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    product = np.einsum('ij,ij->i', a, np.cross(b, c))
    dots = [np.einsum('ij,ij->i', p, q) for p, q in ((a, b), (b, c), (c, a))]
    whole = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return 2 * np.arctan2(product, whole).sum() / (4 * math.pi)
