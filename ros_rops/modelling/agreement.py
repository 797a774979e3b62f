# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How far views of one surface lie apart: noise and errors of the poses together."""

from collections.abc import Sequence

import numpy as np
from ros_rops.core.se3 import move
from ros_rops.core.types import Floats
from ros_rops.modelling.posed import PosedView

SAMPLES = 400
"""Points of each view that the others are asked about."""
WIDEST_MR = 8.0
"""Surfaces farther apart are not the same one."""
FACING = 0.3
"""Least cosine between a point's normal and the direction to a sensor that should have seen it."""
_MAD = 1.4826


def spread_of(views: Sequence[PosedView], resolution: float, threads: int = 0) -> float:
    """
    Return the standard deviation of the views' surfaces about each other, robustly.

    Parameters
    ----------
    views : sequence of PosedView
    resolution : float
        What mr means, in the views' units.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    float
        Of one view's surface, in its units; 0 where no two views saw the same.
    """
    reach = WIDEST_MR * resolution
    samples = [_some(view) for view in views]
    gaps = []
    for number, view in enumerate(views):
        others = [some for other, some in enumerate(samples) if other != number]
        if not others:
            break
        points = _facing(view, *(np.concatenate(part) for part in zip(*others, strict=True)))
        look = view.sight().look(points, reach=reach, threads=threads)
        across = np.abs(look.distance) * look.cosine
        gaps.append(across[across < reach])
    found = np.concatenate(gaps) if gaps else np.zeros(0)
    return float(_MAD / np.sqrt(2.0) * np.median(found)) if len(found) else 0.0


def _some(view: PosedView) -> tuple[Floats, Floats]:
    """Return points of the view spread evenly over its order, all on a face, and normals."""
    faced = np.flatnonzero(view.weights > 0)
    some = faced[::max(len(faced) // SAMPLES, 1)]
    return move(view.T_object_view, view.view.points[some]), view.normals[some]


def _facing(view: PosedView, points: Floats, normals: Floats) -> Floats:
    """Return the points that face the view's sensor: of a wall's back it saw the front, if any."""
    turn, shift = view.T_object_view[:3, :3], view.T_object_view[:3, 3]
    rays = view.view.sensor.to_sensor((points - shift) @ turn) @ turn.T
    facing: Floats = points[np.einsum('ij,ij->i', normals, rays) > FACING]
    return facing
