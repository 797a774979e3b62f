# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Find the axis about which a turntable turned, from the poses of views that were placed."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
import itertools

import numpy as np
from ros_rops.core.station import Axis
from ros_rops.core.types import Bools, Floats
from scipy.spatial.transform import Rotation

# A smaller turn leaves the axis open.
LEAST_TURN_DEG = 8.0
# An axis rests on at least so many views of an object.
FEWEST_VIEWS = 3
# The share of the motions that must agree on it.
LEAST_SHARE = 0.6
ROUNDS = 3


@dataclass(frozen=True, slots=True)
class AxisFit:
    """
    An axis, and how well the poses agree on it.

    Parameters
    ----------
    axis : Axis
    share : float
        Of the motions between views, the share that agrees.
    tilt_deg : float
        Mean angle by which these tilt the axis.
    distance : float
        Mean distance by which these move its point, in the units of the poses.
    """

    axis: Axis
    share: float
    tilt_deg: float
    distance: float


def find_axis(
    objects: Iterable[Sequence[Floats]], middle: Floats, tilt_deg: float, distance: float
) -> AxisFit | None:
    """
    Return the axis that most motions between views of an object share.

    Parameters
    ----------
    objects : iterable of sequences of (4, 4) float64
        `T_object_view` of the placed views of each object, all seen by one fixed sensor.
    middle : (3,) float64
        About where the objects are, in the sensor's frame.
    tilt_deg, distance : float
        Motions agree with an axis that tilt it, and move its point, by less.

    Returns
    -------
    AxisFit or None
        None if too few views agree on one.
    """
    motions = np.concatenate([np.empty((0, 4, 4)), *map(_motions, objects)])
    turned = np.degrees(Rotation.from_matrix(motions[:, :3, :3]).magnitude()) \
        if len(motions) else np.empty(0)
    seeds = [_fit(motions[k:k + 1], middle) for k in np.flatnonzero(turned >= LEAST_TURN_DEG)]
    if not seeds:
        return None
    best = max((_agreeing(motions, axis, tilt_deg, distance) for axis in seeds), key=np.sum)
    for _ in range(ROUNDS):
        axis = _fit(motions[best], middle)
        best = _agreeing(motions, axis, tilt_deg, distance)
        if not best.any():
            return None
    enough = FEWEST_VIEWS * (FEWEST_VIEWS - 1) / 2
    if best.sum() < enough or best.mean() < LEAST_SHARE or turned[best].max() < LEAST_TURN_DEG:
        return None
    tilts, moved = _misfits(motions[best], axis)
    return AxisFit(axis, float(best.mean()), float(tilts.mean()), float(moved.mean()))


def _motions(poses: Sequence[Floats]) -> Floats:
    """Return the motion from every view of an object to every later one (M, 4, 4)."""
    pairs = itertools.combinations(poses, 2)
    return np.array([np.linalg.inv(a) @ b for a, b in pairs]).reshape(-1, 4, 4)


def _fit(motions: Floats, middle: Floats) -> Axis:
    """Least squares: the direction that the motions leave, the point that they move least."""
    change = motions[:, :3, :3] - np.eye(3)
    normal = np.einsum('mji,mjk->ik', change, change)
    direction = np.linalg.eigh(normal)[1][:, 0]
    # One sense for all: that of the turns, so that a series of views turns forward.
    vectors = Rotation.from_matrix(motions[:, :3, :3]).as_rotvec()
    if (vectors @ direction).sum() < 0:
        direction = -direction
    rest = np.einsum('mji,mj->i', change, change @ middle + motions[:, :3, 3])
    point = middle - np.linalg.pinv(normal, rcond=1e-6, hermitian=True) @ rest
    point = point - direction * ((point - middle) @ direction)
    return Axis(tuple(direction.tolist()), tuple(point.tolist()))


def _misfits(motions: Floats, axis: Axis) -> tuple[Floats, Floats]:
    """Tilt in deg (M,) of the axis by each motion, and how far (M,) its point goes."""
    direction, point = np.asarray(axis.direction), np.asarray(axis.point)
    tilt = np.clip(motions[:, :3, :3] @ direction @ direction, -1.0, 1.0)
    moved = motions[:, :3, :3] @ point + motions[:, :3, 3] - point
    return np.degrees(np.arccos(tilt)), np.linalg.norm(moved, axis=1)


def _agreeing(motions: Floats, axis: Axis, tilt_deg: float, distance: float) -> Bools:
    tilts, moved = _misfits(motions, axis)
    agreeing: Bools = (tilts <= tilt_deg) & (moved <= distance)
    return agreeing
