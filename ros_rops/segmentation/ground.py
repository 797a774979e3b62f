# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Where the supporting plane is seen: what nothing is seen beneath may stand there unseen.

The contact of an overhanging body, or of one behind another, is hidden; below a hand, a cable or
a ball on a thread the plane is seen.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Bytes, Floats
from ros_rops.segmentation.plane import Support
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.scan import BAND, dot, ends, Scan

FEW = 0.1
"""The plane is seen in a cell with this share of the usual number of its points."""
TOUCHES = 8
"""So many pixels at the border make a part reach out of the image."""


@dataclass(frozen=True, slots=True)
class Ground:
    """
    A raster on the supporting plane.

    Parameters
    ----------
    axes : (2, 3) float64
        Two unit vectors on the plane.
    low : (2,) float64
        Where the raster begins along them.
    cell : float
    seen : (A, B) bool
        Cells in which the plane is seen; none at the rim.
    """

    axes: Floats
    low: Floats
    cell: float
    seen: Bools

    def hidden_below(self, points: Floats) -> float:
        """Return the share of points (M, 3) below which the plane is not seen."""
        i, j = (
            np.clip(np.floor((dot(points, axis) - start) / self.cell), 0, most - 1).astype(int)
            for axis, start, most in zip(self.axes, self.low, self.seen.shape, strict=True))
        return 1.0 - float(self.seen[i, j].mean())


def ground_of(scan: Scan, labels: Bytes, support: Support) -> Ground:
    """Return where the points labelled as the plane's are."""
    axes, cell = support.extent.axes, support.patch
    flat = np.flatnonzero(labels == Label.PLANE)
    if not len(flat) or cell <= 0:
        return Ground(axes, np.zeros(2), 1.0, np.zeros((1, 1), bool))
    places = [scan.along(axis, flat) for axis in axes]
    low = np.array([float(place.min()) for place in places]) - cell
    row, column = (
        ((place - place.dtype.type(start)) * place.dtype.type(1 / cell)).astype(np.int32)
        for place, start in zip(places, low, strict=True))
    shape = int(row.max()) + 2, int(column.max()) + 2
    count = np.bincount(row * np.int32(shape[1]) + column, minlength=shape[0] * shape[1])
    seen = count >= max(1.0, FEW * float(np.median(count[count > 0])))
    return Ground(axes, low, cell, seen.reshape(shape))


@dataclass(frozen=True, slots=True)
class Rim:
    """The rectangle of an image in which anything is measured."""

    top: int
    left: int
    bottom: int
    right: int
    width: int

    def touched_by(self, members: NDArray) -> bool:
        """Return whether some of these pixels, by their number, lie at the rim."""
        row, column = members // self.width, members % self.width
        at = (row < self.top + BAND) | (row > self.bottom - BAND)
        at |= (column < self.left + BAND) | (column > self.right - BAND)
        return int(np.count_nonzero(at)) >= TOUCHES


def rim_of(scan: Scan) -> Rim | None:
    """Return the rim of an organized frame, None for others."""
    if scan.shape is None:
        return None
    measured = scan.image(scan.measured)
    top, bottom = ends(measured[:, ::4].mean(axis=1))
    left, right = ends(measured[::4].mean(axis=0))
    return Rim(top, left, bottom, right, scan.shape[1])
