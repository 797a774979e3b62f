# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The points of all views of an object, side by side in its frame."""

from collections.abc import Sequence

import numpy as np
from ros_rops.core.types import Bools, Bytes
from ros_rops.kernels.consensus import dents, Samples
from ros_rops.modelling.posed import PosedView

_RING = 6
"""Neighbours of a vertex in a mesh of triangles, in the mean."""
_SIGMA = 1.4826
"""Standard deviation of a normal distribution over the median of its sizes."""


def surface_points(view: PosedView) -> Bools:
    """Tell which points of a view lie on a surface that it saw: those with a face, (N,)."""
    on: Bools = view.weights > 0
    return on


def samples_of(views: Sequence[PosedView]) -> Samples:
    """Return the points of all views that lie on a surface; `views` counts in the sequence."""
    picks = [surface_points(view) for view in views]
    chosen = list(zip(views, picks, strict=True))
    coloured = any(view.view.colors is not None for view in views)
    colors = [_colors(view)[pick] for view, pick in chosen] if coloured else []
    return Samples(
        np.concatenate([np.zeros((0, 3)), *(view.points[pick] for view, pick in chosen)]),
        np.concatenate([
            np.zeros((0, 3), np.float32),
            *(view.normals[pick].astype(np.float32) for view, pick in chosen)]),
        np.concatenate([np.zeros(0, np.float32), *(view.weights[pick] for view, pick in chosen)]),
        np.repeat(np.arange(len(views), dtype=np.int32), [int(pick.sum()) for pick in picks]),
        np.concatenate([np.zeros((0, 4), np.uint8), *colors]), len(views))


def _colors(view: PosedView) -> Bytes:
    """Return red, green, blue and whether there is a colour, (N, 4)."""
    result = np.zeros((len(view.view.points), 4), np.uint8)
    if view.view.colors is not None:
        result[:, :3] = view.view.colors
        result[:, 3] = 255
    return result


def noise_of(view: PosedView) -> float:
    """
    Return how far a view's points scatter across their surface (standard deviation).

    In the view's units; from how far each vertex stands out of those around it, of which the
    median tells: edges and steps are rare.
    """
    inner = surface_points(view) & ~view.mesh.boundary
    if not inner.any():
        return 0.0
    heights = dents(view.mesh.vertices, view.mesh.faces, view.mesh.normals)[inner]
    return float(_SIGMA * np.median(np.abs(heights)) / np.sqrt(1 + 1 / _RING))
