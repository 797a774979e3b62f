# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Colours of a surface, blended from the views that saw each place."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats, frozen
from ros_rops.kernels.sight import Look, Sight
from ros_rops.modelling.posed import PosedView

UNSEEN = 128
"""Grey of places that no view with colours saw."""


def tinted(
    vertices: Floats, views: Sequence[PosedView], reach: float, threads: int = 0
) -> Bytes | None:
    """
    Blend the colours of the views, each weighted as its distances were.

    Parameters
    ----------
    vertices : (V, 3) float64
        In the object's frame.
    views : sequence of PosedView
    reach : float
        A view whose surface lies farther than this from a vertex saw something else.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    (V, 3) uint8 or None
        `UNSEEN` where no view with colours saw a vertex; None if no view has colours.
    """
    if all(view.view.colors is None for view in views):
        return None
    total, sums = np.zeros(len(vertices)), np.zeros((len(vertices), 3))
    for view in views:
        if view.view.colors is None:
            continue
        distance, weight, cosine = _looked(view, view.weights, vertices, reach, threads)
        with np.errstate(invalid='ignore'):
            trust = np.where(np.abs(distance) * cosine < reach, weight, 0.0)
        total += trust
        for channel in range(3):
            value = view.view.colors[:, channel].astype(np.float32)
            sums[:, channel] += trust * _looked(view, value, vertices, reach, threads).weight
    seen = total > 0
    blended = np.where(seen[:, None], sums / np.where(seen, total, 1.0)[:, None], UNSEEN)
    return frozen(np.clip(np.rint(blended), 0, 255), np.uint8)


def _looked(
    view: PosedView, values: NDArray[np.float32], vertices: Floats, reach: float, threads: int
) -> Look:
    """Look at the vertices with any value of the view's points in the place of weights."""
    sight = Sight.of(
        view.mesh.vertices, view.mesh.faces, values, view.view.sensor,
        T_object_view=view.T_object_view)
    return sight.look(vertices, reach=reach, threads=threads)
