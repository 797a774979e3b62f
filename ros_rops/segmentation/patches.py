# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A frame in a few thousand small patches, each with its mean and normal: what planes are of."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.segmentation.scan import Image, Scan

ACROSS = 80
"""Patches along an organized frame's longer side, about."""
CELLS = 4000
"""Patches of an unorganized frame, about."""
SAMPLE = 40_000
"""Points on which the size of cells is found, at most."""
LEAST_POINTS = 5
"""A cell of fewer points has no normal."""


@dataclass(frozen=True, slots=True)
class Patches:
    """
    Patches of a frame.

    Parameters
    ----------
    centres, normals : (M, 3) float64
        Normals are unit and point to the sensor; zero where there is none.
    depth : (M,) float64
    weights : (M,) float64
        Measured points, about.
    size : (M,) float64
        Length across, about.
    owner : (N,) int32
        Patch of every point of the frame, -1 for none.
    """

    centres: Floats
    normals: Floats
    depth: Floats
    weights: Floats
    size: Floats
    owner: Ints


def patches_of(scan: Scan, usable: Bools, pitch: tuple[float, float]) -> Patches:
    """Cut the usable points of a frame into patches."""
    if scan.shape is not None and min(scan.shape) >= 12:
        return _of_pixels(scan, usable, pitch)
    return _of_cells(scan, usable)


def _of_pixels(scan: Scan, usable: Bools, pitch: tuple[float, float]) -> Patches:
    """Blocks of pixels; the normal of a block is across the means of its four neighbours."""
    height, width = scan.shape or (0, 0)
    side = min(max(4, round(max(height, width) / ACROSS)), min(height, width) // 3)
    thin = max(1, side // 4)
    rows, columns = height // side, width // side
    good = _blocks(scan.image(usable), side, thin, rows, columns)
    count = good.sum(axis=(1, 3), dtype=np.float64)

    def mean(values: Image) -> Floats:
        # A block that is less than half measured has no mean.
        part = _blocks(scan.image(values), side, thin, rows, columns)
        total = np.where(good, part, 0).sum(axis=(1, 3), dtype=np.float64)
        half = good.shape[1] * good.shape[3] / 2
        return np.where(count >= half, total / np.maximum(count, 1), np.nan)

    centres = np.stack([mean(scan.x), mean(scan.y), mean(scan.z)], axis=-1)
    depth = mean(scan.depth)
    normals = np.zeros(centres.shape)
    normals[1:-1, 1:-1] = np.cross(
        centres[1:-1, 2:] - centres[1:-1, :-2], centres[2:, 1:-1] - centres[:-2, 1:-1])
    owner = np.full((height, width), -1, np.int32)
    number = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    owner[:rows * side, :columns * side] = number.repeat(side, axis=0).repeat(side, axis=1)
    centres, depth = centres.reshape(-1, 3), depth.ravel()
    size = side * (sum(pitch) / 2) * np.nan_to_num(depth)
    return Patches(
        np.nan_to_num(centres), _towards(scan, centres, normals.reshape(-1, 3)),
        np.nan_to_num(depth), count.ravel() * thin**2, size, owner.ravel())


def _blocks(image: NDArray, side: int, thin: int, rows: int, columns: int) -> NDArray:
    cut = image[:rows * side, :columns * side].reshape(rows, side, columns, side)
    return cut[:, thin // 2::thin, :, thin // 2::thin]


def _towards(scan: Scan, centres: Floats, normals: Floats) -> Floats:
    """Make normals unit and turn them to the sensor; zero where they are not known."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    known = np.isfinite(length) & (length > 0)
    unit = np.where(known, normals / np.where(known, length, 1.0), 0.0)
    to_sensor = (unit * towards_sensor(scan, np.nan_to_num(centres))).sum(axis=1, keepdims=True)
    turned: Floats = np.where(to_sensor < 0, -unit, unit)
    return turned


def towards_sensor(scan: Scan, points: Floats) -> Floats:
    """Return vectors from points (M, 3) to the sensor; an unknown one is at the origin."""
    if scan.sensor.kind == 'orthographic':
        return np.broadcast_to(-np.asarray(scan.sensor.direction), points.shape)
    vectors: Floats = np.asarray(scan.sensor.origin) - points
    return vectors


def _of_cells(scan: Scan, usable: Bools) -> Patches:
    """Cubic cells; the normal is the direction of least variance."""
    which = np.flatnonzero(usable)
    owner = np.full(len(usable), -1, np.int32)
    if not len(which):
        none = np.zeros((0, 3))
        return Patches(none, none, np.zeros(0), np.zeros(0), np.zeros(0), owner)
    points = scan.take(which)
    side = cell_side(points, CELLS)
    cell, count = number_cells(points, side)
    owner[which] = cell

    def mean(values: NDArray) -> Floats:
        return np.bincount(cell, values, len(count)) / count

    centres = np.stack([mean(points[:, k]) for k in range(3)], axis=1)
    off = points - centres[cell]
    spread = np.empty((len(count), 3, 3))
    for i in range(3):
        for j in range(i, 3):
            spread[:, i, j] = spread[:, j, i] = mean(off[:, i] * off[:, j])
    normals = np.linalg.eigh(spread)[1][:, :, 0]
    normals[count < LEAST_POINTS] = 0.0
    return Patches(
        centres, _towards(scan, centres, normals), mean(scan.depth[which]),
        count.astype(np.float64), np.full(len(count), side), owner)


def cell_side(points: Floats, wanted: int) -> float:
    """
    Return the side of cubic cells of which about `wanted` hold a point.

    Found on a sample that fills few cells well; a surface fills them by the square of their side.
    """
    thin = points[::max(1, len(points) // SAMPLE)]
    extent = float(np.ptp(thin, axis=0).max())
    if extent <= 0:
        return 1.0
    few = max(1, min(wanted, len(thin) // 20))
    low, high = extent / 4096, extent * 1.001
    for _ in range(10):
        side = float(np.sqrt(low * high))
        if len(number_cells(thin, side)[1]) > few:
            low = side
        else:
            high = side
    return float(np.sqrt(low * high * few / wanted))


def number_cells(points: Floats, side: float) -> tuple[Ints, NDArray[np.int64]]:
    """Return the cell of each point, numbered along x, then y, then z; and their points."""
    steps, span = [], []
    for k in range(3):
        column = np.ascontiguousarray(points[:, k])
        steps.append(((column - column.min()) * (1.0 / side)).astype(np.int64))
        span.append(int(steps[-1].max()) + 1)
    key = (steps[0] * span[1] + steps[1]) * span[2] + steps[2]
    return renumber(key, span[0] * span[1] * span[2])


def renumber(key: NDArray[np.int64], most: int) -> tuple[Ints, NDArray[np.int64]]:
    """Return keys below `most` as numbers without gaps in their order, and how often each is."""
    if most <= max(16 * len(key), 1_000_000):
        full = np.bincount(key, minlength=most)
        number = np.cumsum(full > 0, dtype=np.int32) - np.int32(1)
        return number[key], full[full > 0]
    _, cell, count = np.unique(key, return_inverse=True, return_counts=True)
    return cell.astype(np.int32).ravel(), count
