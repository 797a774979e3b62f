# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A picture of a run: each object from three sides coloured by view, and what was not placed."""

from collections.abc import Mapping, Sequence
from pathlib import Path
import textwrap
from typing import Any

import numpy as np

from ros_rops.core.types import Floats, Ints
from ros_rops.reporting.clouds import ObjectCloud

SIDES = ('front', 'side', 'top')
MOST_POINTS = 60_000
MOST_OBJECTS = 8
MOST_LINES = 24
# Tableau's twenty, dark before light, so that neighbours in order differ.
PALETTE = np.array([
    (31, 119, 180), (255, 127, 14), (44, 160, 44), (214, 39, 40), (148, 103, 189),
    (140, 86, 75), (227, 119, 194), (127, 127, 127), (188, 189, 34), (23, 190, 207),
    (174, 199, 232), (255, 187, 120), (152, 223, 138), (255, 152, 150), (197, 176, 213),
    (196, 156, 148), (247, 182, 210), (199, 199, 199), (219, 219, 141), (158, 218, 229),
]) / 255.0


def draw_objects(
    path: Path, clouds: Mapping[int, ObjectCloud], views: Sequence[Mapping[str, Any]]
) -> None:
    """
    Write a PNG: a row an object (the largest first), a column a side; below, the rest.

    Parameters
    ----------
    path : Path
    clouds : mapping of int to ObjectCloud
        By the object's id.
    views : sequence of mappings
        The views as `poses.json` lists them.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = sorted(clouds, key=lambda key: (-len(clouds[key].points), key))[:MOST_OBJECTS]
    lines = _not_placed(views, len(clouds) - len(shown))
    heights = [3.2] * len(shown) + [0.35 + 0.17 * len(lines)]
    figure = Figure(figsize=(10.0, sum(heights)), layout='constrained')
    FigureCanvasAgg(figure)
    rows = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for row, key in zip(rows, shown, strict=False):
        _draw_object(row, key, clouds[key])
    rows[-1].text(0.01, 0.98, '\n'.join(lines), va='top', family='monospace', fontsize=7)
    figure.savefig(path, dpi=110)


def _not_placed(views: Sequence[Mapping[str, Any]], hidden: int) -> list[str]:
    rest = [view for view in views if view['status'] != 'placed']
    lines = [f'{hidden} more objects are not shown'] if hidden else []
    if not rest:
        return [*lines, f'all {len(views)} views are placed']
    lines.append(f'{len(rest)} of {len(views)} views are not placed:')
    texts = [f'{view["status"]:9s} {view["name"]}: {view["reason"]}' for view in rest]
    lines += [textwrap.shorten(text, 150, placeholder='...') for text in texts[:MOST_LINES]]
    if len(texts) > MOST_LINES:
        lines.append(f'... and {len(texts) - MOST_LINES} more (poses.json)')
    return lines


def _draw_object(row: Any, key: int, cloud: ObjectCloud) -> None:
    ids = np.unique(cloud.view_ids)
    row.suptitle(f'object {key}: {len(ids)} views, {len(cloud.points)} points', fontsize=9)
    axes = row.subplots(1, len(SIDES))
    frame = principal_frame(cloud.points)
    # Right-handed all three: a mirrored picture would be a lie.
    sides = ([frame[0], frame[1], frame[2]], [-frame[2], frame[1], frame[0]],
             [frame[0], -frame[2], frame[1]])
    for axis, side, rows in zip(axes, SIDES, sides, strict=True):
        _draw_side(axis, cloud, np.array(rows), ids)
        axis.set_title(side, fontsize=7)
    _legend(axes[-1], cloud, ids)


def principal_frame(points: Floats) -> Floats:
    """
    Return the directions of largest to smallest extent of `points` (N, 3) as rows, (3, 3).

    Right-handed; the sign of each of the first two is that of its largest component.
    """
    offset = points - points.mean(axis=0)
    axes: Floats = np.linalg.eigh(offset.T @ offset)[1].T[::-1].copy()
    for k in range(2):
        axes[k] *= np.sign(axes[k][np.argmax(np.abs(axes[k]))])
    axes[2] = np.cross(axes[0], axes[1])
    return axes


def _draw_side(axis: Any, cloud: ObjectCloud, frame: Floats, ids: Ints) -> None:
    """Draw the points that face the viewer, who looks against the third row of `frame`."""
    pick = np.arange(0, len(cloud.points), max(1, len(cloud.points) // MOST_POINTS))
    facing = cloud.normals[pick] @ frame[2]
    # Points without a normal are drawn too, in the middle shade.
    pick, facing = pick[facing >= 0], facing[facing >= 0]
    flat = cloud.points[pick] @ frame.T
    order = np.argsort(flat[:, 2], kind='stable')
    shade = np.where(facing > 0, 0.35 + 0.65 * facing, 0.7)[:, None]
    colours = PALETTE[np.searchsorted(ids, cloud.view_ids[pick]) % len(PALETTE)]
    axis.scatter(
        flat[order, 0], flat[order, 1], s=3.0, marker='s', c=(colours * shade)[order],
        linewidths=0, antialiased=False)
    axis.set_aspect('equal')
    axis.set_axis_off()


def _legend(axis: Any, cloud: ObjectCloud, ids: Ints) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [], [], marker='o', linestyle='', markersize=3,
            color=tuple(PALETTE[k % len(PALETTE)]), label=cloud.names[place][-42:])
        for k, place in enumerate(ids)]
    axis.legend(
        handles=handles, fontsize=5, loc='center left', bbox_to_anchor=(1.0, 0.5),
        frameon=False)
