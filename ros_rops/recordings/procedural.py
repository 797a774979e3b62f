# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Objects made by formulas, so that the repository needs nobody's scan.

An object is a scalar field (negative inside, in metres); `mesh_of` turns it into triangles.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.types import Floats, Ints

Field = Callable[[Floats], Floats]
"""Points (..., 3) to signed values (...)."""

EXTENT_M = 0.12
"""Every object fits into the cube from minus to plus this."""


def blob(seed: int = 7, bumps: int = 30) -> Field:
    """Return a star-shaped body with smooth bumps and dents in random directions."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(bumps, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    heights = rng.uniform(-0.010, 0.016, bumps)
    sharpness = rng.uniform(8.0, 50.0, bumps)

    def field(points: Floats) -> Floats:
        length = np.linalg.norm(points, axis=-1)
        directions = points / np.maximum(length, 1e-9)[..., None]
        radius = np.full(length.shape, 0.055)
        for axis, height, sharp in zip(axes, heights, sharpness, strict=True):
            radius += height * np.exp(sharp * (directions @ axis - 1.0))
        outside: Floats = length - radius
        return outside

    return field


def bracket() -> Field:
    """Return a machine part: plate, wall, oblique rib, bosses, a ball and bored holes."""
    c, s = np.cos(np.deg2rad(35.0)), np.sin(np.deg2rad(35.0))
    about_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    about_z = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def upper(points: Floats) -> Floats:
        body = _box(points, (0.0, 0.0, -0.045), (0.075, 0.05, 0.010))
        wall = _box(points, (-0.055, 0.004, 0.005), (0.011, 0.042, 0.055))
        body = _blend(body, wall, 0.010)
        slanted = (points - np.array([-0.025, -0.018, -0.010])) @ about_y.T
        body = _blend(body, _box(slanted, (0.0, 0.0, 0.0), (0.010, 0.008, 0.042)), 0.008)
        body = _blend(body, _cylinder(points, (0.038, 0.016), (-0.045, 0.008), 0.021), 0.006)
        body = _blend(body, _cylinder(points, (0.030, -0.030), (-0.045, -0.018), 0.012), 0.006)
        body = _blend(body, _ball(points, (-0.052, 0.020, 0.062), 0.022), 0.008)
        return _blend(body, _ball(points, (0.070, -0.042, -0.050), 0.017), 0.006)

    def field(points: Floats) -> Floats:
        along_x = points[..., [1, 2, 0]]
        body = _blend(upper(points), _cylinder(along_x, (0.025, -0.008), (-0.08, -0.06), 0.012),
                      0.004)
        turned = (points - np.array([0.020, 0.004, -0.055])) @ about_z.T
        body = _blend(body, _box(turned, (0.0, 0.0, 0.0), (0.034, 0.007, 0.010)), 0.005)
        body = _blend(body, _ball(points, (-0.042, -0.026, -0.055), 0.015), 0.005)
        body = _cut(body, _cylinder(points, (0.038, 0.016), (-0.020, 0.03), 0.011), 0.003)
        body = _cut(body, _cylinder(along_x, (-0.014, 0.028), (-0.08, -0.03), 0.013), 0.004)
        return _cut(body, _ball(points, (0.005, 0.045, -0.062), 0.021), 0.004)

    return field


def assembly(seed: int, parts: int = 9) -> Field:
    """
    Return a body of blocks, rods and balls of random sizes that grow out of each other.

    Bodies of different seeds are as unlike as tools or toys are; none is symmetric.
    """
    rng = np.random.default_rng(seed)
    middles = [np.zeros(3)]
    for _ in range(parts - 1):
        step = rng.normal(size=3)
        start = middles[rng.integers(len(middles))]
        middles.append(np.clip(
            start + rng.uniform(0.025, 0.04) * step / np.linalg.norm(step), -0.06, 0.06))
    kinds = rng.integers(3, size=parts)
    sizes = rng.uniform(0.010, 0.030, (parts, 3))
    turns = np.linalg.qr(rng.normal(size=(parts, 3, 3)))[0]

    def field(points: Floats) -> Floats:
        body = np.full(points.shape[:-1], np.inf)
        for kind, middle, size, turn in zip(kinds, middles, sizes, turns, strict=True):
            own = (points - middle) @ turn
            if kind == 0:
                part = _box(own, (0.0, 0.0, 0.0), tuple(size))
            elif kind == 1:
                part = _cylinder(own, (0.0, 0.0), (-1.5 * size[2], 1.5 * size[2]), 0.7 * size[0])
            else:
                part = _ball(own, (0.0, 0.0, 0.0), 1.1 * size[0])
            body = _blend(body, part, 0.006)
        return body

    return field


OBJECTS: dict[str, Callable[[], Field]] = {'blob': blob, 'bracket': bracket}


def _box(points: Floats, center: tuple[float, ...], half: tuple[float, ...]) -> Floats:
    q = np.abs(points - np.asarray(center)) - np.asarray(half) + 0.003  # rounded by 3 mm
    outside = np.linalg.norm(np.maximum(q, 0.0), axis=-1)
    inside: Floats = outside + np.minimum(q.max(axis=-1), 0.0) - 0.003
    return inside


def _ball(points: Floats, center: tuple[float, ...], radius: float) -> Floats:
    distance: Floats = np.linalg.norm(points - np.asarray(center), axis=-1) - radius
    return distance


def _cylinder(
    points: Floats, center: tuple[float, float], span: tuple[float, float], radius: float
) -> Floats:
    """Upright cylinder (third axis) between the two heights of `span`."""
    around = np.hypot(points[..., 0] - center[0], points[..., 1] - center[1]) - radius
    middle, half = (span[0] + span[1]) / 2, (span[1] - span[0]) / 2
    return np.maximum(around, np.abs(points[..., 2] - middle) - half)


def _blend(a: Floats, b: Floats, width: float) -> Floats:
    """Union with a fillet of about `width`."""
    h = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - h * h * width / 4


def _cut(a: Floats, b: Floats, width: float) -> Floats:
    """Take `b` away from `a`, the edge rounded."""
    return -_blend(-a, b, width)


def mesh_of(field: Field, cell: float = 0.0015) -> tuple[Floats, Ints]:
    """
    Return the closed surface where `field` is zero: vertices (N, 3), outward faces (F, 3).

    Naive surface nets: one vertex per cell that the surface crosses, one quadrilateral per
    crossed grid edge; then two Newton steps put the vertices on the surface.

    Parameters
    ----------
    field : callable
    cell : float
        Side of a cell, in metres.
    """
    count = int(np.ceil(2 * EXTENT_M / cell)) + 1
    axis = (np.arange(count) - (count - 1) / 2) * cell
    values = np.stack([
        field(np.stack(np.meshgrid([x], axis, axis, indexing='ij'), axis=-1))[0] for x in axis])
    inside = values < 0
    vertices, number = _cell_vertices(values, inside)
    faces = np.concatenate([_quads(inside, number, direction) for direction in range(3)])
    points = _onto(field, vertices * cell + axis[0], cell)
    return points, faces.astype(np.int32)


def _corners(grid: NDArray, offset: tuple[int, int, int]) -> NDArray:
    """Return the values at one corner of all cells."""
    return grid[tuple(slice(o, o + s - 1) for o, s in zip(offset, grid.shape, strict=True))]


def _cell_vertices(
    values: Floats, inside: NDArray[np.bool_]
) -> tuple[Floats, NDArray[np.int64]]:
    """Mean of the crossings on each crossed cell's edges, in cells; and each cell's vertex."""
    corners = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    some = np.any([_corners(inside, c) for c in corners], axis=0)
    every = np.all([_corners(inside, c) for c in corners], axis=0)
    cells = np.argwhere(some & ~every)
    number = np.full(some.shape, -1)
    number[tuple(cells.T)] = np.arange(len(cells))
    total, hits = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for start in corners:
        for direction in range(3):
            if start[direction]:
                continue
            step = np.eye(3, dtype=int)[direction]
            a = values[tuple((cells + start).T)]
            b = values[tuple((cells + start + step).T)]
            crossed = (a < 0) != (b < 0)
            t = np.where(crossed, a / np.where(crossed, a - b, 1.0), 0.0)
            total += crossed[:, None] * (np.asarray(start) + t[:, None] * step)
            hits += crossed
    return cells + total / hits[:, None], number


def _quads(
    inside: NDArray[np.bool_], number: NDArray[np.int64], direction: int
) -> NDArray[np.int64]:
    """Two triangles around every crossed grid edge along `direction`, facing outwards."""
    a = np.moveaxis(inside, direction, 0)
    cells = np.moveaxis(number, direction, 0)
    first, second = a[:-1, 1:-1, 1:-1], a[1:, 1:-1, 1:-1]
    i, j, k = np.nonzero(first != second)
    ring = np.stack([
        cells[i, j, k], cells[i, j + 1, k], cells[i, j + 1, k + 1], cells[i, j, k + 1]], axis=1)
    # moveaxis of the middle axis reverses the handedness of the other two
    outward = first[i, j, k] ^ (direction == 1)
    ring[~outward] = ring[~outward][:, ::-1]
    return np.concatenate([ring[:, [0, 1, 2]], ring[:, [0, 2, 3]]])


def _onto(field: Field, points: Floats, cell: float) -> Floats:
    h = cell / 10
    for _ in range(2):
        gradient = np.stack([
            (field(points + h * e) - field(points - h * e)) / (2 * h) for e in np.eye(3)], axis=1)
        square = np.maximum((gradient**2).sum(axis=1, keepdims=True), 0.1)
        step = field(points)[:, None] * gradient / square
        points = points - np.clip(step, -cell, cell)
    return points
