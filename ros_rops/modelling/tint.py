# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Colours of a surface, blended from the views that saw each place."""

from collections.abc import Sequence

import numpy as np
from ros_rops.core.types import Bytes, Floats, frozen
from ros_rops.kernels.consensus import agree, Floats32, Reach, Samples
from ros_rops.modelling.exposure import exposures
from ros_rops.modelling.gathering import samples_of
from ros_rops.modelling.posed import PosedView

UNSEEN = 128
"""Grey of places that no view with colours saw."""
RADIUS_MR = 1.5
"""Across and along the normal: as the assembled cloud takes it."""


def tinted(
    vertices: Floats, normals: Floats32, views: Sequence[PosedView], *, resolution: float,
    far: float, threads: int = 0,
) -> Bytes | None:
    """
    Blend the colours of the views as the assembled cloud does.

    Parameters
    ----------
    vertices : (V, 3) float64
        In the object's frame.
    normals : (V, 3) float
        Unit, outwards: only points that face the same way give their colours.
    views : sequence of PosedView
    resolution : float
        dres, in the views' units.
    far : float
        How far the surface may lie from what the views measured: a voxel, or their noise.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    (V, 3) uint8 or None
        `UNSEEN` where no view with colours saw a vertex; None if no view has colours.
    """
    coloured = [view for view in views if view.view.colors is not None]
    if not coloured:
        return None
    samples = samples_of(coloured, exposures(coloured, resolution))
    count = len(samples.points)
    targets = np.arange(count, count + len(vertices), dtype=np.int32)
    reach = Reach(max(RADIUS_MR * resolution, far), resolution, resolution)
    agreed = agree(_with(samples, vertices, normals), targets, reach, move=False, threads=threads)
    return frozen(np.where(agreed.weights[:, None] > 0, agreed.colors, UNSEEN), np.uint8)


def _with(samples: Samples, vertices: Floats, normals: Floats32) -> Samples:
    """Return the samples, and after them the vertices: without weight, without colour."""
    count = len(vertices)
    return Samples(
        np.concatenate([samples.points, vertices]),
        np.concatenate([samples.normals, normals.astype(np.float32)]),
        np.concatenate([samples.weights, np.zeros(count, np.float32)]),
        np.concatenate([samples.views, np.full(count, samples.view_count, np.int32)]),
        np.concatenate([samples.colors, np.zeros((count, 4), np.uint8)]),
        samples.view_count + 1)
