# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The unit of every measured length: dres, the mean mesh edge length of a view.

The mesh is plain and is this file's own, not the engine's: a measure must not change with a
parameter of what it measures. Organized views connect each pixel with those to the right, below
and on one diagonal; others get the Delaunay triangulation of the image plane. Edges of more than
five times the median bridge steps in depth and do not count. With it the published poses give
EVALUATION's residuals (0.206 on the bunny, 0.293 on dragon_stand).
"""

import numpy as np
from ros_rops.core.errors import ViewError
from ros_rops.core.types import Floats, RangeView, SensorModel
from scipy.spatial import Delaunay, QhullError

STEP_MEDIANS = 5.0


def mesh_resolution(view: RangeView) -> float:
    """
    Return the mean mesh edge length of a view, in the view's units.

    Raises
    ------
    ViewError
        If the view has no two neighbouring points apart from each other.
    """
    lengths = _grid_lengths(view) if view.grid is not None else _delaunay_lengths(view)
    lengths = lengths[lengths > 0]
    if not len(lengths):
        raise ViewError(f'view {view.name!r}: no mesh edge in its {len(view.points)} points')
    return float(lengths[lengths <= STEP_MEDIANS * np.median(lengths)].mean())


def _lengths(view: RangeView, first: np.ndarray, second: np.ndarray) -> Floats:
    lengths: Floats = np.linalg.norm(view.points[first] - view.points[second], axis=1)
    return lengths


def _grid_lengths(view: RangeView) -> Floats:
    grid = np.asarray(view.grid)
    neighbours = (
        (grid[:, :-1], grid[:, 1:]), (grid[:-1], grid[1:]), (grid[:-1, :-1], grid[1:, 1:]))
    parts = []
    for first, second in neighbours:
        both = (first >= 0) & (second >= 0)
        parts.append(_lengths(view, first[both], second[both]))
    return np.concatenate(parts)


def _delaunay_lengths(view: RangeView) -> Floats:
    try:
        corners = Delaunay(_in_image(view.points, view.sensor)).simplices
    except (QhullError, ValueError):
        return np.zeros(0)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    return _lengths(view, edges[:, 0], edges[:, 1])


def _in_image(points: Floats, sensor: SensorModel) -> Floats:
    """Project points (N, 3) into the sensor's image plane, (N, 2)."""
    origin = np.asarray(sensor.origin if sensor.kind == 'pinhole' else (0.0, 0.0, 0.0))
    local = points - origin
    forward = local.mean(axis=0) if sensor.kind == 'pinhole' else np.asarray(sensor.direction)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(np.eye(3)[np.argmin(np.abs(forward))], forward)
    right /= np.linalg.norm(right)
    plane: Floats = local @ np.stack([right, np.cross(forward, right)], axis=1)
    if sensor.kind == 'pinhole':
        depth = local @ forward
        plane = plane / np.where(depth > 0, depth, np.nan)[:, None]
    return plane
