# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What a file parser hands on: points as they stand in the file, before anything is inferred.

Every parser (ply, pcd, text, npz, PointCloud2) returns a `Cloud`; `finish` in `reader` turns it
into a `RangeView`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.types import Floats32or64
from ros_rops.kernels.points import count_holes, measured
from ros_rops.recordings.view_facts import ViewFacts


class FormatError(Exception):
    """The bytes are not what they claim to be; the reader adds the file's name."""


@dataclass(frozen=True, slots=True)
class Cloud:
    """
    Points of one file, holes included.

    Parameters
    ----------
    points : (N, 3) float64
        May hold NaN and infinities.
    grid : (H, W) int32 or None
        Index of the point behind each pixel, -1 where none.
    colors : (N, 3) uint8 or None
        Red, green, blue.
    notes : tuple of str
        What the parser had to assume, one sentence each.
    facts : ViewFacts or None
        What this package wrote into the file beside the points.
    """

    points: NDArray[np.float64]
    grid: NDArray[np.int32] | None = None
    colors: NDArray[np.uint8] | None = None
    notes: tuple[str, ...] = ()
    facts: ViewFacts | None = None


LARGEST = 1e15
"""A coordinate beyond this is no measurement (uninitialised memory): taken as a hole."""


def drop_holes(cloud: Cloud) -> Cloud:
    """
    Return `cloud` with its measured points only, the grid and the colours kept in step.

    A point goes if a coordinate is NaN, infinite or beyond `LARGEST`.
    """
    points, numbers = measured(cloud.points, LARGEST)
    if len(points) == len(numbers):
        return cloud
    renumber = np.append(numbers, np.int32(-1))  # the last entry serves index -1
    return Cloud(
        points, None if cloud.grid is None else renumber[cloud.grid],
        _rows_of(cloud.colors, numbers), cloud.notes, cloud.facts)


def measured_cloud(
    points: Floats32or64, colors: NDArray[np.uint8] | None, notes: tuple[str, ...] = ()
) -> Cloud:
    """
    Return the measured points of a message as a cloud without holes, as `drop_holes` would.

    Parameters
    ----------
    points : (H, W, 3) or (N, 3)
    colors : same shape, uint8, or None
    notes : tuple of str
    """
    kept, numbers = measured(points.reshape(-1, 3), LARGEST)
    return Cloud(
        kept, numbers.reshape(points.shape[:2]) if points.ndim == 3 else None,
        _rows_of(None if colors is None else colors.reshape(-1, 3), numbers), notes)


def _rows_of(
    colors: NDArray[np.uint8] | None, numbers: NDArray[np.int32]
) -> NDArray[np.uint8] | None:
    if colors is None:
        return None
    # A colour is moved as one item: several times as fast.
    items: NDArray[Any] = np.ascontiguousarray(colors).view('V3')[:, 0]
    return items[numbers >= 0].view(np.uint8).reshape(-1, 3)


def mark_holes(points: Floats32or64) -> tuple[Floats32or64, tuple[str, ...]]:
    """
    Return the points of a message with every hole NaN in all coordinates, and a note if need be.

    Lidar drivers write (0, 0, 0) where nothing came back; one such point may be measured, two
    cannot.

    Parameters
    ----------
    points : (H, W, 3) or (N, 3)
        Returned as they are, not a copy, if there is nothing to mark.
    """
    halves, zeros = count_holes(points.reshape(-1, 3))
    if halves == 0 and zeros <= 1:
        return points, ()
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    holes = ~(np.isfinite(x) & np.isfinite(y)) & ~np.isnan(z)
    if zeros > 1:
        holes |= (z == 0) & (x == 0) & (y == 0)
    marked = points.copy()
    marked[holes] = np.nan
    return marked, (f'{zeros} points at (0, 0, 0) taken as holes',) if zeros > 1 else ()


def full_grid(height: int, width: int) -> NDArray[np.int32]:
    """Return the (H, W) grid of a cloud that has one point, or hole, per pixel."""
    return np.arange(height * width, dtype=np.int32).reshape(height, width)


def to_bytes(colors: NDArray) -> NDArray[np.uint8]:
    """
    Return colours as 0-255 bytes.

    Integers are clipped; floats that stay within 0-1 are taken as fractions.
    """
    if colors.dtype == np.uint8:
        return colors
    if np.issubdtype(colors.dtype, np.integer):
        whole: NDArray[np.uint8] = np.clip(colors, 0, 255).astype(np.uint8)
        return whole
    values = np.nan_to_num(colors.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    if values.size and values.max() <= 1.0:
        values = values * 255.0
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
