# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The points of all views of an object, side by side in its frame."""

from collections.abc import Sequence

import numpy as np
from ros_rops.core.types import Bools, Bytes, Floats, Ints
from ros_rops.kernels.consensus import dents, piece_sizes, Samples
from ros_rops.modelling.posed import PosedView

GREY = 180
_RING = 6
"""Neighbours of a vertex in a mesh of triangles, in the mean."""
_SHARE, _SIGMA = 0.9, 0.6080
"""Standard deviation of a normal distribution over that share's quantile of its sizes."""


def surface_points(view: PosedView) -> Bools:
    """Tell which points of a view lie on a surface that it saw: those with a face, (N,)."""
    on: Bools = view.weights > 0
    return on


def samples_of(views: Sequence[PosedView], gains: Floats | None = None) -> Samples:
    """
    Return the points of all views that lie on a surface; `Samples.views` counts in `views`.

    Each view's colours are multiplied by its `gains` (V, 3).
    """
    return _samples(views, [surface_points(view) for view in views], gains)


def every_point(views: Sequence[PosedView]) -> tuple[Samples, Bools]:
    """Return all points of all views, and which of them lie on a surface, (N,)."""
    picks = [np.ones(len(view.view.points), np.bool_) for view in views]
    on = np.concatenate([np.zeros(0, np.bool_), *map(surface_points, views)])
    return _samples(views, picks), on


def piece_sizes_of(views: Sequence[PosedView]) -> Ints:
    """Return for each of `samples_of` how many points of its view its piece of surface has."""
    sizes = [
        piece_sizes(view.mesh.faces, len(view.mesh.vertices))[surface_points(view)]
        for view in views]
    return np.concatenate([np.zeros(0, np.int32), *sizes])


def _samples(
    views: Sequence[PosedView], picks: Sequence[Bools], gains: Floats | None = None
) -> Samples:
    chosen = list(zip(views, picks, strict=True))
    coloured = any(view.view.colors is not None for view in views)
    colors = [
        _colors(view, None if gains is None else gains[k])[pick]
        for k, (view, pick) in enumerate(chosen)] if coloured else []
    return Samples(
        np.concatenate([np.zeros((0, 3)), *(view.points[pick] for view, pick in chosen)]),
        np.concatenate([
            np.zeros((0, 3), np.float32),
            *(view.normals[pick].astype(np.float32) for view, pick in chosen)]),
        np.concatenate([np.zeros(0, np.float32), *(view.weights[pick] for view, pick in chosen)]),
        np.repeat(np.arange(len(views), dtype=np.int32), [int(pick.sum()) for pick in picks]),
        np.concatenate([np.zeros((0, 4), np.uint8), *colors]), len(views))


def _colors(view: PosedView, gain: Floats | None) -> Bytes:
    """Return red, green, blue and whether there is a colour, (N, 4); grey where there is none."""
    result = np.full((len(view.view.points), 4), GREY, np.uint8)
    result[:, 3] = 0
    if view.view.colors is not None:
        result[:, :3] = view.view.colors if gain is None else (
            np.clip(np.rint(view.view.colors * gain), 0, 255))
        result[:, 3] = 255
    return result


def noise_of(view: PosedView) -> float:
    """
    Return how far a view's points scatter across their surface (standard deviation).

    In the view's units; from how far most vertices stand out of those around them: edges are
    rare, but the terraces of a sensor that tells depth in steps are flat for the most part.
    """
    inner = surface_points(view) & ~view.mesh.boundary
    if not inner.any():
        return 0.0
    heights = dents(view.mesh.vertices, view.mesh.faces, view.mesh.normals)[inner]
    return float(_SIGMA * np.quantile(np.abs(heights), _SHARE) / np.sqrt(1 + 1 / _RING))
