# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Where to look from next: what of the unseen surface a sensor would see, by visibility.

The gain of a direction is the unseen area that is seen from it, by parallel rays: turned towards
the sensor by enough to be measured and not hidden behind other parts, for which a raster of the
nearest depths stands (next best view by surface, Connolly 1985; Scott et al. 2003, 4).
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Floats
from ros_rops.modelling.closure import Closure

Floats32 = NDArray[np.float32]

CANDIDATES = 180
"""Directions tried, evenly spread: about 15 degrees from one to the next."""
SUGGESTED = 3
"""Directions told at most, each by what it adds to those before."""
LEAST_GAIN = 0.02
"""Share of the unseen area below which a direction is not worth a view."""
GRAZING = 0.35
"""Cosine below which a surface is seen too flat to be measured."""
_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
# Pixel of the depth raster, in cells of the closure: wide enough to leave no gaps.
_PIXEL = 1.5


@dataclass(frozen=True, slots=True)
class Suggestion:
    """
    A direction to look from.

    Parameters
    ----------
    direction : (3,) tuple of float
        From the object towards where the sensor should stand, unit, in the object's frame.
    gain_share : float
        Share of the unseen area that it would show, beside what those before it show.
    """

    direction: tuple[float, float, float]
    gain_share: float


def suggestions(closure: Closure) -> tuple[Suggestion, ...]:
    """Return the best directions to look from, each the best after those before it."""
    unseen = np.flatnonzero(closure.unseen)
    areas = closure.areas[unseen]
    total = float(areas.sum())
    if not total > 0:
        return ()
    directions = sphere(CANDIDATES)
    cosines = visible(closure, directions)
    open_areas, found = areas.copy(), []
    for _ in range(SUGGESTED):
        # Of two that see the same the one that sees it straighter. einsum: the sums of a BLAS
        # product depend on its threads.
        best = int(np.argmax(np.einsum('df,f->d', cosines, open_areas)))
        seen = cosines[best] > 0
        gain = float(open_areas[seen].sum()) / total
        if gain < LEAST_GAIN:
            break
        x, y, z = (float(value) for value in directions[best])
        found.append(Suggestion((x, y, z), gain))
        open_areas[seen] = 0.0
    return tuple(found)


def gains_of(closure: Closure, directions: Floats) -> Floats:
    """Return the share (D,) of the unseen area that is seen from each direction (D, 3)."""
    areas = closure.areas[closure.unseen]
    total = float(areas.sum())
    if not total > 0:
        return np.zeros(len(directions))
    return np.array([areas[one > 0].sum() / total for one in visible(closure, directions)])


def visible(closure: Closure, directions: Floats) -> Floats32:
    """
    Tell which unseen faces are seen from directions.

    Parameters
    ----------
    closure : Closure
    directions : (D, 3) float64
        Unit, towards the sensor.

    Returns
    -------
    (D, U) float32
        Cosine at which each of the U unseen faces, in their order, is seen; 0 where it is not.
    """
    unseen = np.flatnonzero(closure.unseen)
    cosines = np.zeros((len(directions), len(unseen)), np.float32)
    for row, towards in zip(cosines, directions, strict=True):
        row[:] = _visible(closure, unseen, towards)
    return cosines


def _visible(closure: Closure, unseen: NDArray[np.intp], towards: Floats) -> Floats:
    pixel = _PIXEL * closure.cell
    helper = np.eye(3)[np.argmin(np.abs(towards))]
    right = np.cross(helper, towards)
    right /= np.linalg.norm(right)
    basis = np.stack([right, np.cross(towards, right)], axis=1)
    raster = np.floor(np.einsum('fi,ij->fj', closure.centres, basis) / pixel).astype(np.int64)
    raster -= raster.min(axis=0)
    place = raster[:, 0] * (raster[:, 1].max() + 1) + raster[:, 1]
    height = np.einsum('fi,i->f', closure.centres, towards)
    highest = np.full(int(place.max()) + 1, -np.inf)
    np.maximum.at(highest, place, height)
    cosine = np.einsum('fi,i->f', closure.normals[unseen], towards)
    # Within a pixel an inclined surface differs in height by itself.
    slope = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0)) / np.maximum(cosine, GRAZING)
    open_to = height[unseen] >= highest[place[unseen]] - pixel * (1.0 + math.sqrt(2.0) * slope)
    return np.where((cosine > GRAZING) & open_to, cosine, 0.0)


def sphere(count: int) -> Floats:
    """Return `count` unit vectors spread evenly over the sphere, (count, 3)."""
    k = np.arange(count)
    z = 1.0 - (2.0 * k + 1.0) / count
    side = np.sqrt(1.0 - z * z)
    return np.stack([side * np.cos(_GOLDEN * k), side * np.sin(_GOLDEN * k), z], axis=1)
