# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A picture of an object from three sides, drawn without a display."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from ros_rops.core.types import Bytes, Floats
from ros_rops.reporting.picture import principal_frame, SIDES
from ros_rops.reporting.shown import Shown

PIXELS = 620
"""Width and height of one side."""
MOST_SAMPLES = 12
"""Along an edge of a face, in pixels; larger ones are cut."""


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

    figure = Figure(figsize=(14.0, 5.2), layout='constrained')
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=10)
    x, y, z = principal_frame(shown.points)
    # Right-handed all three: a mirrored picture would be a lie.
    sides = ([x, y, z], [-z, y, x], [x, -z, y])
    for axis, name, rows in zip(figure.subplots(1, 3), SIDES, sides, strict=True):
        axis.imshow(render(shown, np.array(rows)))
        axis.set_title(name, fontsize=8)
        axis.set_axis_off()
    figure.savefig(path, dpi=130, format='png')


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
    for points, colors in _samples(shown, place, color, pixels):
        _splat(points, colors, depth, image, pixels)
    return image.reshape(pixels, pixels, 3)[::-1].astype(np.uint8)


def _samples(
    shown: Shown, place: Floats, color: Floats, pixels: int
) -> Iterator[tuple[Floats, Floats]]:
    """Yield points so near to each other that no pixel between them stays white."""
    if shown.faces is None:
        # As if they lay evenly on half of the picture.
        side = int(np.clip(np.sqrt(0.5 / len(place)) * pixels * 1.5, 2, 8))
        for x, y in np.ndindex(side, side):
            yield place + np.array((x, y, 0.0)), color
        return
    corners, colors = place[shown.faces], color[shown.faces]
    longest = _longest(corners)
    while longest.max() > MOST_SAMPLES:
        far = longest > MOST_SAMPLES
        corners = np.concatenate([corners[~far], _quartered(corners[far])])
        colors = np.concatenate([colors[~far], _quartered(colors[far])])
        longest = _longest(corners)
    steps = np.maximum(np.ceil(longest * 1.1), 1).astype(int)
    for step in np.unique(steps):
        own = steps == step
        for a in range(step + 1):
            for b in range(step + 1 - a):
                share = np.array([a, b, step - a - b]) / step
                yield (np.einsum('k,fkd->fd', share, corners[own]),
                       np.einsum('k,fkd->fd', share, colors[own]))


def _longest(corners: Floats) -> Floats:
    """Return the longest edge of each triangle (F, 3, 3), as it is seen."""
    flat = corners[..., :2]
    longest: Floats = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2).max(axis=1)
    return longest


def _quartered(corners: Floats) -> Floats:
    """Return triangles (F, 3, 3) cut into four each."""
    between = (corners + np.roll(corners, -1, axis=1)) / 2.0
    outer = [np.stack([corners[:, k], between[:, k], between[:, k - 1]], axis=1)
             for k in range(3)]
    return np.concatenate([between, *outer])


def _splat(
    points: Floats, colors: Floats, depth: Floats, image: Floats, pixels: int
) -> None:
    """Draw points into an image where nothing nearer is."""
    column, row = np.floor(points[:, :2]).astype(int).T
    inside = (column >= 0) & (column < pixels) & (row >= 0) & (row < pixels)
    cell, near = (row * pixels + column)[inside], points[inside, 2]
    order = np.argsort(near, kind='stable')
    cell, near, shades = cell[order], near[order], colors[inside][order]
    # Of several in a pixel the last one written stays: the nearest.
    front = np.full(len(depth), -1, np.int64)
    front[cell] = np.arange(len(cell))
    hit = np.flatnonzero(front >= 0)
    hit = hit[near[front[hit]] > depth[hit]]
    depth[hit], image[hit] = near[front[hit]], shades[front[hit]]
