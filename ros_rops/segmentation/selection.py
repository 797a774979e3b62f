# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which frames of a stream become views: all, every k-th, or those of a scene that came to rest.

A scene is compared by a coarse raster of depths. Where a pixel is a hole in either frame nothing
is known, so holes that flicker neither move nor change a scene.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.config import SelectionConfig
from ros_rops.core.frame import Frame, LARGEST
from ros_rops.core.types import Floats, Floats32or64

ACROSS = 80
"""Cells along the longer side of a raster, about."""
PER_SIDE = 3
"""A cell's depth is the median of so many pixels squared."""
EDGE = 2.5
"""A cell across which the depth steps by more than so many tolerances is not compared."""
LEAST_KNOWN = 20
"""Two rasters with fewer common samples cannot be compared: they differ."""


@dataclass(frozen=True, slots=True)
class Decision:
    """
    Whether a frame becomes a view.

    Parameters
    ----------
    taken : bool
    reason : str
        A sentence.
    numbers : mapping of str to float
        `moved`: share of the pixels that differ from the frame at which the scene came to rest;
        `changed`: from the last taken frame; `still_frames`: so many agree by now.
    """

    taken: bool
    reason: str
    numbers: Mapping[str, float] = field(default_factory=dict)


class Selector:
    """
    Decide on the frames of a stream, one after another.

    Deterministic: the state is a function of the frames given and of the parameters.

    Parameters
    ----------
    config : SelectionConfig
    """

    def __init__(self, config: SelectionConfig) -> None:
        self.config = config
        self._count = 0
        self._rest: Floats | None = None
        self._since_ns: int | None = None
        self._agreeing = 0
        self._taken: Floats | None = None
        self._window: Floats | None = None
        self._scale = 1.0

    def decide(self, frame: Frame, *, asked: bool = False) -> Decision:
        """Return whether the frame becomes a view; one that was asked for always does."""
        self._count += 1
        if asked:
            return self._asked(frame)
        if self.config.method == 'every':
            return Decision(True, 'every frame is taken')
        if self.config.method == 'request':
            return Decision(False, 'no view was asked for')
        if self.config.method == 'stride':
            number = (self._count - 1) % self.config.stride
            return Decision(number == 0, f'frame {number + 1} of {self.config.stride}')
        return self._still(frame)

    def _asked(self, frame: Frame) -> Decision:
        if self.config.method == 'still':
            # What was taken is not new any more.
            self._scale = 1000.0 if frame.units == 'mm' else 1.0
            self._taken = self._raster(frame)
        return Decision(True, 'it was asked for')

    def _still(self, frame: Frame) -> Decision:
        self._scale = 1000.0 if frame.units == 'mm' else 1.0
        raster = self._raster(frame)
        if not np.isfinite(raster).any():
            self._rest, self._agreeing = None, 0
            return Decision(False, 'nothing is measured')
        # Compared with the first frame of the rest, not with the one before: a slow turn adds up.
        moved = self._differ(self._rest, raster)
        if moved > self.config.new_share / 2:
            self._rest, self._agreeing = raster, 0
            self._since_ns = frame.stamp_ns
        self._agreeing += 1
        changed = self._differ(self._taken, raster)
        numbers = {'moved': moved, 'changed': changed, 'still_frames': float(self._agreeing)}
        if self._agreeing < self.config.still_frames or not self._long_enough(frame):
            return Decision(False, 'the scene moves or has just come to rest', numbers)
        if changed < self.config.new_share:
            return Decision(False, 'the scene is that of the last taken frame', numbers)
        self._taken = raster
        return Decision(True, 'the scene is at rest and new', numbers)

    def _long_enough(self, frame: Frame) -> bool:
        if frame.stamp_ns is None or self._since_ns is None:
            return True
        return (frame.stamp_ns - self._since_ns) * 1e-9 >= self.config.still_s

    def _differ(self, first: Floats | None, second: Floats) -> float:
        """Return the share of the common samples whose depths differ; 1 if there are too few."""
        if first is None or first.shape != second.shape:
            return 1.0
        low = np.minimum(first, second)  # NaN where either is
        known = int(np.count_nonzero(np.isfinite(low)))
        if known < LEAST_KNOWN:
            return 1.0
        # A depth sensor's noise grows faster than the depth: from 1 m on the tolerance does too.
        limit = self.config.depth_noise * low * np.maximum(1.0, low / self._scale)
        off = np.abs(first - second) > limit
        return float(np.count_nonzero(off)) / known

    def _raster(self, frame: Frame) -> Floats:
        """Return a coarse image of depths, NaN where nothing is measured."""
        if frame.organized:
            return _medians(frame.points, EDGE * self.config.depth_noise)
        return self._cloud_raster(frame)

    def _cloud_raster(self, frame: Frame) -> Floats:
        """Return the mean distances of an unorganized cloud's points by their direction."""
        points = frame.points[(np.abs(frame.points) <= LARGEST).all(axis=1)].astype(np.float64)
        if not len(points):
            return np.full((1, 1), np.nan)
        length = np.sqrt((points**2).sum(axis=1))
        unit = points / np.maximum(length, 1e-12)[:, None]
        azimuth, height = np.arctan2(unit[:, 0], unit[:, 2]), np.arcsin(np.clip(unit[:, 1], -1, 1))
        if self._window is None:
            self._window = _window(azimuth, height)
        left, bottom, side = self._window
        i, j = _cell(azimuth, left, side), _cell(height, bottom, side)
        inside = (i >= 0) & (i < ACROSS) & (j >= 0) & (j < ACROSS)
        cell = (j * ACROSS + i)[inside]
        count = np.bincount(cell, minlength=ACROSS**2)
        mean = np.bincount(cell, length[inside], ACROSS**2) / np.maximum(count, 1)
        off = (length[inside] - mean[cell])**2
        spread = np.sqrt(np.bincount(cell, off, ACROSS**2) / np.maximum(count, 1))
        # Of a cell halved by a depth edge, the spread is half of the step.
        known = (count > 0) & (2 * spread <= EDGE * self.config.depth_noise * mean)
        return np.where(known, mean, np.nan).reshape(ACROSS, ACROSS)


def _medians(points: Floats32or64, edge: float) -> Floats:
    """
    Return the median distance of some pixels (lower of two) in each block of an image.

    NaN where they differ by more than the share `edge`: across a depth edge noise decides which
    side is the median.
    """
    height, width = points.shape[:2]
    step = max(1, round(max(height, width) / ACROSS))
    offsets = np.unique(np.linspace(0, step - 1, min(PER_SIDE, step)).astype(np.int64))
    rows, columns = max(1, height // step), max(1, width // step)
    samples = [
        points[i:i + (rows - 1) * step + 1:step, j:j + (columns - 1) * step + 1:step]
        for i in offsets for j in offsets]
    if not points.size:
        return np.full((1, 1), np.nan)
    lengths = np.stack([_lengths(sample) for sample in samples])
    known = np.count_nonzero(np.isfinite(lengths), axis=0)
    lengths.sort(axis=0)  # NaN comes last
    middle = np.maximum(known - 1, 0) // 2
    median = np.take_along_axis(lengths, middle[None], axis=0)[0]
    largest = np.take_along_axis(lengths, np.maximum(known - 1, 0)[None], axis=0)[0]
    medians: Floats = np.where(largest - lengths[0] <= edge * median, median, np.nan)
    return medians


def _lengths(points: Floats32or64) -> Floats:
    """Return the distances of points (..., 3) from the origin, NaN for holes."""
    good = np.all(np.abs(points) <= LARGEST, axis=-1, keepdims=True)
    whole = np.where(good, points, np.nan).astype(np.float64)
    lengths: Floats = np.sqrt((whole**2).sum(axis=-1))
    return lengths


def _window(azimuth: Floats, height: Floats) -> Floats:
    """Return the lower left corner and the cell of a raster around the directions seen first."""
    low = np.array([azimuth.min(), height.min()])
    wide = max(float(np.ptp(azimuth)), float(np.ptp(height)), 1e-6)
    cell = max(wide / ACROSS, PER_SIDE * float(np.sqrt(
        np.ptp(azimuth) * np.ptp(height) / max(len(azimuth), 1))))
    return np.array([*low, cell])


def _cell(values: Floats, low: float, side: float) -> NDArray[np.int64]:
    cells: NDArray[np.int64] = np.floor((values - low) / side).astype(np.int64)
    return cells
