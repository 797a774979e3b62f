# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Which points of a view are shown, and in what order, so that any first part is spread evenly."""

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.types import Floats, Ints

BITS = 20
"""Cells along an axis are numbered by so many bits; three axes fit into a word."""
# Steps that spread the bits of a number to every third place (Morton 1966).
_SPREAD = (
    (32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249))


def spread_order(points: Floats, side: float) -> Ints:
    """
    Choose one point of each cubic cell, and order them so that they may be cut off anywhere.

    Parameters
    ----------
    points : (N, 3) float64
        Finite.
    side : float
        Of a cell, in the points' units; 0 takes every point.

    Returns
    -------
    (S,) int32
        Indices of points, of each cell the one nearest to its centre. The first n of them are
        about every (S / n)-th along a curve that fills space (Morton's), for any n.
    """
    if not len(points):
        return np.zeros(0, np.int32)
    low = points.min(axis=0)
    extent = float((points.max(axis=0) - low).max())
    finest = extent / (2 ** BITS - 1)
    # Lengths without extent leave one cell of any size.
    place = (points - low) / (max(side, finest) or 1.0)
    cells = np.floor(place)
    keys = _morton(cells.astype(np.uint64))
    if side > 0:
        off_centre = np.square(place - cells - 0.5).sum(axis=1)
        along = np.lexsort((off_centre, keys))
        first = np.concatenate([[True], np.diff(keys[along]) != 0])
        along = along[first]
    else:
        along = np.argsort(keys, kind='stable')
    order: Ints = along[_evenly(len(along))].astype(np.int32)
    return order


def _morton(cells: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return the place of each cell (N, 3) on Morton's curve, (N,)."""
    keys = np.zeros(len(cells), np.uint64)
    for axis in range(3):
        bits = cells[:, axis]
        for shift, mask in _SPREAD:
            bits = (bits | bits << np.uint64(shift)) & np.uint64(mask)
        keys |= bits << np.uint64(axis)
    return keys


def _evenly(count: int) -> NDArray[np.intp]:
    """Return 0 to `count` - 1 in the order of their bits read backwards (van der Corput)."""
    order = np.zeros(1, np.intp)
    while len(order) < count:
        order = np.concatenate([2 * order, 2 * order + 1])
    return order[order < count]
