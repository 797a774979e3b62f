# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Connected parts of an organized frame, parted by depth edges; and growing them."""

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Ints
from ros_rops.segmentation.edges import Edges
from scipy import ndimage

Side = tuple[slice, slice]
# A pixel, its neighbour, and whether the link between them is in the row or in the column.
_LINKS: tuple[tuple[Side, Side, bool], ...] = (
    ((slice(None), slice(0, -1)), (slice(None), slice(1, None)), True),
    ((slice(0, -1), slice(None)), (slice(1, None), slice(None)), False),
)


def label_parts(mask: Bools, edges: Edges) -> tuple[Ints, int]:
    """
    Return the connected parts of a mask (H, W), numbered, 0 outside; and how many.

    The far side of every depth edge is left out first, so that parts touch across no edge, and
    then joins the part that it continues.
    """
    numbers = np.empty(mask.shape, np.int32)
    count = int(ndimage.label(mask & ~edges.far, output=numbers))
    return grow(numbers, mask & edges.far, edges, 2), count


def grow(numbers: Ints, into: Bools, edges: Edges, steps: int) -> Ints:
    """
    Let parts spread over the pixels of `into` by links on one surface.

    Parameters
    ----------
    numbers : (H, W) int32
        Part of every pixel, 0 for none; changed in place and returned.
    into : (H, W) bool
    edges : Edges
    steps : int
        Pixels that a part may spread.
    """
    rows, columns = np.nonzero(into & (numbers == 0))
    for _ in range(steps):
        if not len(rows):
            break
        found = _neighbours(numbers, edges, rows, columns)
        numbers[rows, columns] = found
        rows, columns = rows[found == 0], columns[found == 0]
        if not found.any():
            break
    return numbers


def _neighbours(numbers: Ints, edges: Edges, rows: NDArray, columns: NDArray) -> Ints:
    """Return the largest part number that each pixel is linked to, 0 for none."""
    height, width = numbers.shape
    best = np.zeros(len(rows), np.int32)
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        i, j = rows + down, columns + right
        inside = (i >= 0) & (i < height) & (j >= 0) & (j < width)
        i, j = np.where(inside, i, 0), np.where(inside, j, 0)
        if right:
            link = edges.right[np.minimum(rows, i), np.clip(np.minimum(columns, j), 0, width - 2)]
        else:
            link = edges.down[np.clip(np.minimum(rows, i), 0, height - 2), np.minimum(columns, j)]
        best = np.maximum(best, np.where(inside & link, numbers[i, j], 0))
    return best
