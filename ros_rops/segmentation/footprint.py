# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The extent of a plane: a convex polygon on it."""

from dataclasses import dataclass

import numpy as np
from ros_rops.core.types import Bools, Floats
from ros_rops.segmentation.scan import dot, Image

SIDES = 32
RASTER = 100


@dataclass(frozen=True, slots=True)
class Footprint:
    """
    A polygon of `SIDES` sides with fixed directions, and a prism over it.

    Parameters
    ----------
    axes : (2, 3) float64
        Two unit vectors on the plane.
    limits : (SIDES,) float64
        Farthest point of the plane along each direction.
    """

    axes: Floats
    limits: Floats

    def holds(self, points: Floats, margin: float) -> Bools:
        """Return which points (M, 3) project into the polygon, `margin` away from its sides."""
        u, v = (dot(points, axis) for axis in self.axes)
        inside = np.ones(len(points), bool)
        for (c, s), limit in zip(_directions(), self.limits, strict=True):
            inside &= c * u + s * v <= limit - margin
        return inside

    def holds_about(self, u: Image, v: Image) -> Bools:
        """Return the same for places (M,) along the axes, to a hundredth of the extent."""
        low = -self.limits[[SIDES // 2, 3 * SIDES // 4]]
        span = self.limits[[0, SIDES // 4]] - low
        cells = np.linspace(0.0, 1.0, RASTER)
        places = low + span * np.stack(np.meshgrid(cells, cells, indexing='ij'), axis=-1)
        raster = np.zeros((RASTER + 2, RASTER + 2), bool)  # a free rim
        raster[1:-1, 1:-1] = self.holds(places.reshape(-1, 2) @ self.axes, 0.0).reshape(
            RASTER, RASTER)
        kind, top = u.dtype.type, RASTER + 1
        i, j = (
            np.clip((w - kind(start)) * kind((RASTER - 1) / max(wide, 1e-12)) + kind(1.5), 0, top)
            .astype(np.int32) for w, start, wide in zip((u, v), low, span, strict=True))
        inside: Bools = raster[i, j]
        return inside

    def wider(self, margin: float) -> 'Footprint':
        """Return the polygon with its sides moved out."""
        return Footprint(self.axes, self.limits + margin)


def _directions() -> Floats:
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def footprint_of(points: Floats, normal: Floats, trimmed: float) -> Footprint:
    """
    Return the polygon around points (M, 3) of the plane with this normal.

    Parameters
    ----------
    points : (M, 3) float64
    normal : (3,) float64
    trimmed : float
        Share of the points that may lie beyond each side: strays.
    """
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(normal, first)])
    thin = points[::max(1, len(points) // 5_000)]
    u, v = (dot(thin, axis) for axis in axes)
    beyond = int(trimmed * len(thin))
    limits = [
        np.partition(c * u + s * v, len(thin) - 1 - beyond)[len(thin) - 1 - beyond]
        for c, s in _directions()]
    return Footprint(axes, np.array(limits))
