# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A picture of an object from three sides, drawn without a display."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats
from ros_rops.reporting.picture import principal_frame, SIDES
from ros_rops.reporting.shown import Shown

PIXELS = 620
"""Width and height of one side."""
DPI = 130
MOST_CELLS = 500_000
"""Pixels that are looked at at once: the faces between them share the memory."""
WITHIN = 1e-9
"""A pixel on the edge of two faces belongs to both: none stays white."""
Longs = NDArray[np.int64]
Cover = tuple[Longs, Floats, Floats]
"""Pixels (N,), how near what covers them is (N,), and its colours (N, 3)."""


def draw_shown(path: Path, shown: Shown, title: str) -> None:
    """
    Write a PNG.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    side, top = PIXELS / DPI, 0.6
    figure = Figure(figsize=(3 * side, side + top))
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=10)
    x, y, z = principal_frame(shown.points)
    # Right-handed all three: a mirrored picture would be a lie.
    sides = ([x, y, z], [-z, y, x], [x, -z, y])
    for k, (name, rows) in enumerate(zip(SIDES, sides, strict=True)):
        axis = figure.add_axes((k / 3.0, 0.0, 1.0 / 3.0, side / (side + top)))
        axis.imshow(render(shown, np.array(rows)))
        axis.set_title(name, fontsize=8)
        axis.set_axis_off()
    figure.savefig(path, dpi=DPI, format='png')


def render(shown: Shown, frame: Floats, pixels: int = PIXELS) -> Bytes:
    """
    Return what is seen from the third row of `frame`, parallel, lit from there.

    Parameters
    ----------
    shown : Shown
    frame : (3, 3) float64
        Right, up, and towards the viewer.
    pixels : int

    Returns
    -------
    (pixels, pixels, 3) uint8
        On white.
    """
    flat = shown.points @ frame.T
    low, high = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
    scale = 0.94 * pixels / max(float((high - low).max()), 1e-12)
    place = flat * scale
    place[:, :2] += pixels / 2.0 - (low + high) / 2.0 * scale
    facing = np.abs(shown.normals @ frame[2])
    shade = np.where(np.linalg.norm(shown.normals, axis=1) > 0.5, 0.3 + 0.7 * facing, 1.0)
    color = shown.colors * shade[:, None]
    depth = np.full(pixels * pixels, -np.inf)
    image = np.full((pixels * pixels, 3), 255.0)
    cover = _points(place, color, pixels) if shown.faces is None else (
        _faces(place[shown.faces], color[shown.faces], pixels))
    for cell, near, colors in cover:
        _paint(cell, near, colors, depth, image)
    return np.rint(image.reshape(pixels, pixels, 3)[::-1]).astype(np.uint8)


def _points(place: Floats, color: Floats, pixels: int) -> Iterator[Cover]:
    """Yield the pixels of points, each a square, as if they lay evenly on half of the picture."""
    side = int(np.clip(np.sqrt(0.5 / len(place)) * pixels * 1.5, 2, 8))
    corner = np.floor(place[:, :2]).astype(np.int64)
    for offset in np.ndindex(side, side):
        column, row = (corner + offset).T
        inside = (column >= 0) & (column < pixels) & (row >= 0) & (row < pixels)
        yield (row * pixels + column)[inside], place[inside, 2], color[inside]


def _faces(corners: Floats, colors: Floats, pixels: int) -> Iterator[Cover]:
    """Yield the pixels whose middles lie in triangles (F, 3, 3), linear in between."""
    # Pixel k reaches from k to k + 1.
    low = np.clip(np.ceil(corners[..., :2].min(axis=1) - 0.5 - WITHIN), 0, pixels).astype(int)
    high = np.clip(np.floor(corners[..., :2].max(axis=1) - 0.5 + WITHIN), -1, pixels - 1)
    size = np.maximum(high.astype(int) - low + 1, 0)
    cells = size.prod(axis=1)
    a, b, c = (corners[:, k, :2] for k in range(3))
    area = _cross(b - a, c - a)
    seen = np.flatnonzero((cells > 0) & (area != 0.0))
    batch = np.cumsum(cells[seen]) // MOST_CELLS
    for part in np.split(seen, np.flatnonzero(np.diff(batch)) + 1):
        face = np.repeat(part, cells[part])
        step = np.arange(len(face)) - np.repeat(
            np.cumsum(cells[part]) - cells[part], cells[part])
        row, column = np.divmod(step, size[face, 0])
        row, column = row + low[face, 1], column + low[face, 0]
        middle = np.stack([column, row], axis=1) + 0.5
        first = _cross(c[face] - b[face], middle - b[face]) / area[face]
        second = _cross(a[face] - c[face], middle - c[face]) / area[face]
        share = np.stack([first, second, 1.0 - first - second], axis=1)
        hit = (share >= -WITHIN).all(axis=1)
        face, share = face[hit], share[hit]
        yield ((row * pixels + column)[hit], np.einsum('nk,nk->n', share, corners[face, :, 2]),
               np.einsum('nk,nkd->nd', share, colors[face]))


def _cross(a: Floats, b: Floats) -> Floats:
    found: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return found


def _paint(cell: Longs, near: Floats, colors: Floats, depth: Floats, image: Floats) -> None:
    """Paint pixels where nothing nearer is."""
    before = depth[cell]
    np.maximum.at(depth, cell, near)
    front = (near == depth[cell]) & (near > before)
    image[cell[front]] = colors[front]
