# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
How finely a view may be sampled: no finer than its depths can be trusted.

Depth cameras give more pixels than knowledge: depths come in steps (1 mm is common), and their
errors are of that order and alike over many pixels. Registration measures everything in mesh
resolutions, so a mesh finer than the errors makes right poses look wrong.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.config import MeshConfig
from ros_rops.core.mesh import image_plane
from ros_rops.core.types import Floats, RangeView
from scipy.spatial import cKDTree

# A block's points farther in depth from its median than so many block widths are another surface.
STEEPEST = 3.0
# A block stands for a point where this share of its pixels is measured.
LEAST_FILLED = 0.5
# Stray points spread an image thin: beyond so many blocks a point it is no image.
MOST_EMPTY = 50
# Points that tell the step of the depths and the spacing of the pixels.
SAMPLE = 4000


def depth_step(view: RangeView) -> float:
    """
    Return the step in which a view's depths come, in its units.

    The median, over a sample, of the gap to the next depth that occurs: the step of a sensor
    that rounds, next to nothing where depths are continuous.
    """
    depths, counts = np.unique(
        _every(view.points) @ np.asarray(view.sensor.direction), return_counts=True)
    if len(depths) < 2:
        return 0.0
    gaps = np.diff(depths)
    order = np.argsort(gaps, kind='stable')
    below = np.cumsum(counts[:-1][order])
    return float(gaps[order][np.searchsorted(below, below[-1] / 2.0)])


def coarsened(view: RangeView, config: MeshConfig) -> RangeView:
    """
    Return a view sampled no finer than its depth steps allow.

    Blocks of pixels become their mean, which also averages the noise away.

    Parameters
    ----------
    view : RangeView
    config : MeshConfig
        `depth_steps`: spacing of the points wanted, in depth steps; 0 leaves views alone.

    Returns
    -------
    RangeView
        Organized, a pixel a block; the view itself if it is coarse enough.
    """
    step = depth_step(view) if config.depth_steps else 0.0
    if step == 0.0 or (view.grid is None and view.sensor.kind == 'unknown'):
        return view
    pixels = _pixels(view)
    size = round(config.depth_steps * step / pixels.spacing) if pixels.spacing > 0 else 1
    if size < 2:
        return view
    blocks = _Blocks.of(pixels, size)
    if blocks.shape[0] * blocks.shape[1] > MOST_EMPTY * len(view.points):
        return view
    depths = (view.points @ np.asarray(view.sensor.direction))[pixels.points]
    alike = np.abs(depths - blocks.medians(depths)) <= STEEPEST * size * pixels.spacing
    filled = blocks.sums(alike.astype(np.float64))
    used = filled >= LEAST_FILLED * size * size

    def means(values: NDArray) -> Floats:
        weighted = np.where(alike[:, None], values[pixels.points].astype(np.float64), 0.0)
        sums = np.stack([blocks.sums(column) for column in weighted.T], axis=1)
        mean: Floats = sums[used] / filled[used, None]
        return mean

    colors = None if view.colors is None else np.rint(means(view.colors)).astype(np.uint8)
    grid = np.full(len(used), -1, np.int32)
    grid[used] = np.arange(np.count_nonzero(used))
    return replace(
        view, points=means(view.points), grid=grid.reshape(blocks.shape), colors=colors)


@dataclass(frozen=True, slots=True)
class _Pixels:
    """
    The image that a view's points make.

    Parameters
    ----------
    points : (P,) int
        Index of the point at each measured pixel.
    rows, columns : (P,) int
    spacing : float
        Median distance of neighbours across the line of sight; 0 if unknown.
    """

    points: NDArray[np.intp]
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    spacing: float


def _pixels(view: RangeView) -> _Pixels:
    if view.grid is not None:
        rows, columns = np.nonzero(view.grid >= 0)
        points = view.grid[rows, columns].astype(np.intp)
        return _Pixels(points, rows, columns, _spacing(view))
    uv, front = image_plane(view.sensor, view.points)
    sample = _every(uv)
    pitch = 0.0
    if len(sample) > 1:
        pitch = float(np.median(cKDTree(uv).query(sample, k=2)[0][:, 1]))
    places = np.floor((uv - uv.min(axis=0)) / pitch).astype(np.intp) if pitch else uv.astype(int)
    scale = 1.0
    if view.sensor.kind == 'pinhole' and len(front):
        offsets = view.points[front] - np.asarray(view.sensor.origin)
        scale = float(np.median(offsets @ np.asarray(view.sensor.direction)))
    return _Pixels(front.astype(np.intp), places[:, 1], places[:, 0], pitch * scale)


def _spacing(view: RangeView) -> float:
    """Median distance of an organized view's neighbours across the line of sight."""
    grid = view.grid
    if grid is None:
        return 0.0
    left, right = grid[:, :-1], grid[:, 1:]
    both = (left >= 0) & (right >= 0)
    if not both.any():
        return 0.0
    steps = _every(view.points[right[both]] - view.points[left[both]])
    axis = np.asarray(view.sensor.direction)
    across = steps - (steps @ axis)[:, None] * axis
    return float(np.median(np.linalg.norm(across, axis=1)))


def _every(rows: Floats) -> Floats:
    """Take at most `SAMPLE` rows, spread over all."""
    return rows[::max(-(-len(rows) // SAMPLE), 1)]


@dataclass(frozen=True, slots=True)
class _Blocks:
    """Which of the blocks (rows by columns: `shape`) each pixel belongs to."""

    ids: NDArray[np.intp]
    shape: tuple[int, int]

    @staticmethod
    def of(pixels: _Pixels, size: int) -> '_Blocks':
        rows, columns = pixels.rows // size, pixels.columns // size
        height, width = int(rows.max()) + 1, int(columns.max()) + 1
        return _Blocks(rows * width + columns, (height, width))

    def sums(self, values: Floats) -> Floats:
        """Sum (B,) of the values (P,) of each block."""
        total = np.bincount(self.ids, values, self.shape[0] * self.shape[1])
        return np.asarray(total, dtype=np.float64)

    def medians(self, values: Floats) -> Floats:
        """Median of its block (P,) for each pixel; of an even number, the upper of the two."""
        order = np.lexsort((values, self.ids))
        sizes = np.bincount(self.ids, minlength=self.shape[0] * self.shape[1])
        starts = np.cumsum(sizes) - sizes
        middle = np.minimum(starts + sizes // 2, len(values) - 1)
        of_blocks: Floats = values[order][middle]
        return of_blocks[self.ids]
