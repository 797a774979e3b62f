# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A frame laid out for segmentation: one array per coordinate, measured or not, pixel pitch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.frame import Frame, LARGEST
from ros_rops.core.types import Bools, SensorModel

Image = NDArray[np.floating]

FORWARD = SensorModel('pinhole', direction=(0.0, 0.0, 1.0))
BACKWARD = SensorModel('pinhole', direction=(0.0, 0.0, -1.0))
RAW_BORDER = 0.1
"""A raw frame is measured along at least this share of its border."""
RAW_WITHIN = 0.3
"""Or along this share of the border of what is measured, when that is near the image's own."""
BAND = 4
"""Pixels that belong to the border."""
LINE = 0.2
"""A row or column of the image is measured if this share of it is."""
MARGIN = 0.1
"""So much of an image's side may be without measurements at its border."""


@dataclass(frozen=True, slots=True)
class Scan:
    """
    A frame's coordinates as flat arrays, holes zero.

    Parameters
    ----------
    x, y, z, depth : (N,) float
        `depth` is the distance along a camera's axis, or straight to an unknown sensor.
    measured : (N,) bool
    shape : (H, W) or None
        Of an organized frame.
    scale : float
        Frame units per metre.
    sensor : SensorModel
    """

    x: Image
    y: Image
    z: Image
    depth: Image
    measured: Bools
    shape: tuple[int, int] | None
    scale: float
    sensor: SensorModel

    def take(self, which: NDArray | slice) -> NDArray[np.float64]:
        """Return the points of a mask or of indices, (M, 3) float64."""
        return np.stack([self.x[which], self.y[which], self.z[which]], axis=1).astype(np.float64)

    def columns(self, which: NDArray) -> NDArray[np.float64]:
        """Return the points of indices, (3, M) float64."""
        return np.stack([self.x[which], self.y[which], self.z[which]]).astype(np.float64)

    def along(self, direction: NDArray, which: NDArray | slice = slice(None)) -> Image:
        """Return direction . point for the points of a mask or of indices, in the scan's type."""
        columns = (self.x, self.y, self.z)
        for k in range(3):
            if direction[k] == 1.0 and np.count_nonzero(direction) == 1:
                return columns[k][which]
        a, b, c = (self.z.dtype.type(value) for value in direction)
        result: Image = self.x[which] * a + self.y[which] * b + self.z[which] * c
        return result

    def image(self, values: NDArray) -> NDArray:
        """Return flat values as an (H, W) image."""
        return values.reshape(self.shape or (1, -1))


def dot(points: NDArray, direction: NDArray) -> NDArray[np.float64]:
    """Return the products of points (M, 3) with a direction (3,), summed in this order."""
    # Several times as fast as a sum along the short axis, to the same bits.
    result: NDArray[np.float64] = (
        points[:, 0] * direction[0] + points[:, 1] * direction[1] + points[:, 2] * direction[2])
    return result


def scan_of(frame: Frame) -> Scan:
    """Lay out a frame; where its sensor is not stated, it is taken to be a camera if it can."""
    x, y, z = (frame.points[..., k].flatten() for k in range(3))
    measured = (np.abs(x) <= LARGEST) & (np.abs(y) <= LARGEST) & (np.abs(z) <= LARGEST)
    for values in (x, y, z):
        values[~measured] = 0
    sensor = frame.sensor or _guess(z[measured], frame)
    depth = _depth(x, y, z, sensor)
    shape = (frame.points.shape[0], frame.points.shape[1]) if frame.organized else None
    return Scan(x, y, z, depth, measured, shape, 1000.0 if frame.units == 'mm' else 1.0, sensor)


def _guess(z: Image, frame: Frame) -> SensorModel:
    ahead = np.count_nonzero(z > 0)
    if len(z) and ahead == len(z) and (frame.organized or 'optical' in frame.frame_id):
        return FORWARD
    if len(z) and ahead == 0 and frame.organized:
        return BACKWARD
    return SensorModel('unknown', direction=(0.0, 0.0, -1.0))


def _depth(x: Image, y: Image, z: Image, sensor: SensorModel) -> Image:
    if sensor.kind == 'unknown':
        return np.sqrt(x * x + y * y + z * z)
    if sensor.direction == (0.0, 0.0, 1.0) and not any(sensor.origin):
        return z
    a, b, c = (z.dtype.type(value) for value in sensor.direction)
    start = z.dtype.type(np.dot(sensor.origin, sensor.direction))
    return x * a + y * b + z * c - start


def is_raw(scan: Scan) -> bool:
    """
    Return whether the frame is organized and measured along much of its border.

    Rectified images have a frame of holes, stereo cameras a band of them at one side: the border
    of what is measured counts, too, as far as it is near to that of the image.
    """
    if scan.shape is None or min(scan.shape) < 8:
        return False
    image = scan.image(scan.measured)
    if _along_border(image) >= RAW_BORDER:
        return True
    top, bottom = ends(image.mean(axis=1))
    left, right = ends(image.mean(axis=0))
    return _along_border(image[top:bottom + 1, left:right + 1]) >= RAW_WITHIN


def _along_border(image: Bools) -> float:
    # Cameras lose the outermost pixels: what is measured within a few of the border reaches it.
    border = np.concatenate([
        image[:BAND].any(axis=0), image[-BAND:].any(axis=0),
        image[:, :BAND].any(axis=1), image[:, -BAND:].any(axis=1)])
    return float(border.mean())


def ends(shares: NDArray[np.float64]) -> tuple[int, int]:
    """Return the first and the last measured line of an image; its own where these are far in."""
    last = len(shares) - 1
    lines = np.flatnonzero(shares > LINE)
    margin = MARGIN * len(shares)
    if not len(lines):
        return 0, last
    first = int(lines[0]) if lines[0] <= margin else 0
    return first, int(lines[-1]) if last - lines[-1] <= margin else last


def pitch_of(scan: Scan) -> tuple[float, float]:
    """
    Return how far neighbouring pixels lie apart at depth 1, across the view: (columns, rows).

    The median over a sample of the frame; 0 where no two neighbours are measured.
    """
    image = [scan.image(values) for values in (scan.x, scan.y, scan.z, scan.depth)]
    good = scan.image(scan.measured)
    step = max(1, min(good.shape) // 60)
    result = []
    for first, second in (((slice(None), slice(0, -1)), (slice(None), slice(1, None))),
                          ((slice(0, -1), slice(None)), (slice(1, None), slice(None)))):
        thin = (slice(None, None, step), slice(None, None, step))
        both = (good[first] & good[second])[thin]
        a, b = ([part[where][thin][both] for part in image] for where in (first, second))
        middle = np.maximum((a[3] + b[3]) / 2, 1e-12)
        # Across the ray: what the depths differ by does not count.
        along = np.abs(b[3] - a[3])
        square = sum((q - p) ** 2 for p, q in zip(a[:3], b[:3], strict=True))
        length = np.sqrt(np.maximum(square - along**2, 0.0)) / middle
        result.append(float(np.median(length)) if length.size else 0.0)
    return result[0], result[1]
