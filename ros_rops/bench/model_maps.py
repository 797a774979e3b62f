# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of where a surface errs and of what it lacks."""

from pathlib import Path
import re
from typing import Any

import numpy as np
from ros_rops.bench.model_distance import Triangles
from ros_rops.bench.model_score import signed
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats
from ros_rops.modelling.products import SurfaceMesh

SCALE_DRES = 1.0
"""Colours end there."""
SIDES = ((0, 1, 2, 1), (0, 1, 2, -1), (2, 1, 0, 1), (2, 1, 0, -1), (0, 2, 1, 1), (0, 2, 1, -1))
"""Axis to the right, up, towards the eye, and from which end."""


def draw_map(
    folder: Path, title: str, surface: SurfaceMesh, reference: Triangles, dres: float,
    samples: int,
) -> Path:
    """
    Draw the signed distance of a surface to its reference, seen along the axes, as a PNG.

    Red lies outside, blue inside; black dots are places of the reference that the surface lacks
    by more than 2 dres; grey is what lies farther than 5 dres.

    Raises
    ------
    InputError
        If the picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    model = Triangles(surface.vertices, surface.faces)
    points, faces = model.samples(samples)
    gaps = signed(points, reference.closest(points), reference) / dres
    lacks = reference.vertices[model.closest(reference.vertices).distance > 2 * dres]
    figure = Figure(figsize=(15, 10), dpi=100)
    canvas = FigureCanvasAgg(figure)
    for axes, side in zip(figure.subplots(2, 3).ravel(), SIDES, strict=True):
        dots = _draw_side(axes, points, model.normals[faces], gaps, lacks, side)
    figure.suptitle(f'{title}: signed distance in dres; black: lacking')
    figure.colorbar(dots, ax=figure.axes, shrink=0.6)
    path = folder / (re.sub(r'\W+', '_', title).strip('_') + '.png')
    try:
        folder.mkdir(parents=True, exist_ok=True)
        canvas.print_png(path)
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None
    return path


def _draw_side(
    axes: Any, points: Floats, normals: Floats, gaps: Floats, lacks: Floats,
    side: tuple[int, int, int, int],
) -> Any:
    right, up, depth, sign = side
    faced = np.flatnonzero(normals[:, depth] * sign > 0)
    order = faced[np.argsort(points[faced, depth] * sign)]
    far = np.abs(gaps[order]) > 5
    axes.scatter(*points[order[far]][:, [right, up]].T, s=0.5, c='0.6')
    near = order[~far]
    dots = axes.scatter(
        *points[near][:, [right, up]].T, s=0.5, c=gaps[near], cmap='coolwarm', vmin=-SCALE_DRES,
        vmax=SCALE_DRES)
    axes.scatter(*lacks[:, [right, up]].T, s=2, c='black')
    axes.set_aspect('equal')
    axes.set_title(f'from {"+" if sign > 0 else "-"}{"xyz"[depth]}')
    if sign < 0:
        axes.invert_xaxis()
    return dots
