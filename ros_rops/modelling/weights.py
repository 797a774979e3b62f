# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How far a point of a view may be trusted: by angle, by distance, and near a border."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Floats, frozen, RangeMesh, RangeView
from scipy.spatial import cKDTree

RAMP_MR = 3.0
"""Weight rises from the border of what was seen over this distance, in mesh resolutions."""
LEAST_WEIGHT = 1e-3
"""Of a point on a surface, however badly seen: alone it is better than nothing."""


def point_weights(
    view: RangeView, mesh: RangeMesh, *, nearest: float | None = None
) -> NDArray[np.float32]:
    """
    Return the weight of each point of a view (Curless and Levoy 1996, 2).

    Parameters
    ----------
    view : RangeView
    mesh : RangeMesh
        Of the view.
    nearest : float or None
        Distance to the sensor at which a pinhole's point has its full weight: the least of all
        views that are compared (`nearest_of`); None for that of this view.

    Returns
    -------
    (N,) float32
        0 to 1: the cosine between line of sight and surface, times the distance to the border of
        what was seen (1 from `RAMP_MR` on), and for a pinhole times the inverse square of the
        distance to the sensor. Depth noise grows with the square of the distance, so that for
        noise alone it were the fourth power; the poses' errors do not grow, and without noise
        all would weigh the same. 0 for points without a face.
    """
    cosine = np.abs(np.einsum('ij,ij->i', mesh.normals, view.sensor.to_sensor(view.points)))
    weights = cosine * _inner(mesh) * _nearness(view, nearest)
    faced = mesh.normals.any(axis=1)
    return frozen(np.where(faced, np.maximum(weights, LEAST_WEIGHT), 0.0), np.float32)


def _inner(mesh: RangeMesh) -> Floats:
    """Return how far inside of its border each vertex lies, 0 to 1."""
    rim = mesh.vertices[mesh.boundary]
    if not len(rim):
        return np.ones(len(mesh.vertices))
    reach = RAMP_MR * mesh.resolution
    distance, _ = cKDTree(rim).query(mesh.vertices, distance_upper_bound=reach)
    inner: Floats = np.minimum(distance / reach, 1.0)
    return inner


def nearest_of(views: Iterable[RangeView]) -> float | None:
    """Return how near a point of a pinhole's view is to its sensor; None without such views."""
    squared = [
        _squared(view).min() for view in views
        if view.sensor.kind == 'pinhole' and len(view.points)]
    return float(np.sqrt(min(squared))) if squared else None


def _nearness(view: RangeView, nearest: float | None) -> Floats:
    if view.sensor.kind != 'pinhole' or not len(view.points):
        return np.ones(len(view.points))
    squared = _squared(view)
    least = float(squared.min()) if nearest is None else nearest**2
    return np.minimum(least / squared, 1.0) if least > 0 else np.ones(len(squared))


def _squared(view: RangeView) -> Floats:
    squared: Floats = np.square(view.points - np.asarray(view.sensor.origin)).sum(axis=1)
    return squared
