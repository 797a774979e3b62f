# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Depth edges of an organized frame: where surfaces part, and points that hang between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools
from ros_rops.segmentation.scan import Image


@dataclass(frozen=True, slots=True)
class Edges:
    """
    Depth edges between the usable pixels of a frame.

    Parameters
    ----------
    right, down : (H, W - 1), (H - 1, W) bool
        Whether a pixel and its neighbour are on one surface.
    hanging : (H, W) bool
        Pixels on no surface: parted from both neighbours of a row or column, from at least one
        of them by a step in depth (mixed pixels).
    far : (H, W) bool
        Pixels on the far side of a step.
    """

    right: Bools
    down: Bools
    hanging: Bools
    far: Bools


def find_edges(
    depth: Image, usable: Bools, noise: Image, pitch: tuple[float, float], edge_deg: float
) -> Edges:
    """
    Find the depth edges.

    Parameters
    ----------
    depth : (H, W) float
    usable : (H, W) bool
    noise : (H, W) float
        Standard deviation of the depth.
    pitch : (float, float)
        Lateral distance of neighbouring pixels at depth 1: along a row, along a column.
    edge_deg : float
        Neighbours are on one surface if it is seen at less than this from its normal.
    """
    slope = float(np.tan(np.deg2rad(edge_deg)))
    kind = depth.dtype.type
    hanging = np.zeros(depth.shape, bool)
    far = np.zeros(depth.shape, bool)
    joined = []
    for axis, apart in ((1, pitch[0]), (0, pitch[1])):
        first, second = _sides(axis, 0, -1), _sides(axis, 1, None)
        step = depth[second] - depth[first]
        limit = kind(slope * apart) * depth[first] + kind(4.0) * noise[first]
        both = usable[first] & usable[second]
        small = np.abs(step) <= limit
        joined.append(both & small)
        jump = both & ~small
        far[second] |= jump & (step > 0)
        far[first] |= jump & (step < 0)
        hanging |= _parted(joined[-1], jump, axis, depth.shape)
    return Edges(joined[0], joined[1], hanging & usable, far)


def _sides(axis: int, start: int | None, stop: int | None) -> tuple[slice, slice]:
    part = slice(start, stop)
    return (part, slice(None)) if axis == 0 else (slice(None), part)


def _parted(joined: Bools, jump: Bools, axis: int, shape: tuple[int, ...]) -> Bools:
    """Return the pixels joined to neither neighbour along an axis, with a step on one side."""
    some = np.zeros(shape, bool)
    step = np.zeros(shape, bool)
    for part in (_sides(axis, 0, -1), _sides(axis, 1, None)):
        some[part] |= joined
        step[part] |= jump
    parted: NDArray[np.bool_] = step & ~some
    return parted
