# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Simplified surfaces by vertex clustering (Guo et al. 2014, III-A and III-C)."""

import numpy as np
from ros_rops.core.types import Floats


def simplify(points: Floats, cell: float) -> Floats:
    """
    Replace the points of every cubic cell by their mean.

    Parameters
    ----------
    points : (N, 3) float64
    cell : float
        Length of the cells' edges, in the points' units.

    Returns
    -------
    (S, 3) float64
        One point for each cell that holds any, in the order of the cells.
    """
    if not len(points):
        return np.zeros((0, 3))
    cells = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    order = np.lexsort(cells.T[::-1])
    new = np.any(np.diff(cells[order], axis=0) != 0, axis=1)
    owner = np.empty(len(points), dtype=np.intp)
    owner[order] = np.concatenate([[0], np.cumsum(new)])
    sums = np.stack([np.bincount(owner, axis) for axis in points.T], axis=1)
    means: Floats = sums / np.bincount(owner)[:, None]
    return means
