# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The turntable that an object stood on, if it did: its axis, the order round, the next angle."""

from collections.abc import Sequence
from dataclasses import dataclass
import itertools
import math

import numpy as np
from ros_rops.core.config import PriorConfig
from ros_rops.core.station_axis import find_axis
from ros_rops.core.types import Floats
from ros_rops.modelling.closure import Closure
from ros_rops.modelling.outlook import gains_of
from ros_rops.modelling.posed import PosedView
from scipy.spatial.transform import Rotation

STEP_DEG = 5.0
"""Angles tried."""
_LEAST_GAIN = 0.02


@dataclass(frozen=True, slots=True)
class Turn:
    """
    How to turn the object from where it stood in its last view.

    Parameters
    ----------
    axis : (3,) tuple of float
        Of the turntable, in the object's frame, with the sense in which the object was turned
        so far: a positive angle goes on the same way.
    angle_deg : float
        Right-handed about `axis`, by which to turn the object, not the sensor; -180 to 180.
    gain_share : float
        Share of the unseen area that a view from there would show.
    """

    axis: tuple[float, float, float]
    angle_deg: float
    gain_share: float


def axis_of(
    views: Sequence[PosedView], given: Floats | None, config: PriorConfig, resolution: float
) -> Floats | None:
    """
    Return the turntable's axis in the object's frame, (3,), in the sense of the turns so far.

    Parameters
    ----------
    views : sequence of PosedView
    given : (3,) float64 or None
        The direction where the station knows it, either sense; else it is found where most
        motions between views turn about one axis that stands still before the sensor.
    config : PriorConfig
        How well the motions must agree (`tilt_deg`, `distance_mr`).
    resolution : float
    """
    axis = given
    if axis is None:
        poses = [one.T_object_view for one in views]
        middle = np.mean([one.view.points.mean(axis=0) for one in views], axis=0)
        fit = find_axis([poses], middle, config.tilt_deg, config.distance_mr * resolution)
        if fit is None:
            return None
        agreeing = np.mean([one[:3, :3] @ fit.axis.direction for one in poses], axis=0)
        axis = agreeing
    length = float(np.linalg.norm(axis))
    if not length > 0:
        return None
    unit: Floats = np.asarray(axis, np.float64) / length
    ordered = sorted(views, key=lambda one: one.number)
    turned = sum(
        _turned(a.T_object_view, b.T_object_view, unit)
        for a, b in itertools.pairwise(ordered))
    return unit if turned >= 0 else -unit


def _turned(before: Floats, after: Floats, axis: Floats) -> float:
    """Return by how much, in rad, the object turned about the axis between two views."""
    x, y, z, w = Rotation.from_matrix(before[:3, :3] @ after[:3, :3].T).as_quat()
    return math.remainder(2.0 * math.atan2(float(np.dot((x, y, z), axis)), w), 2.0 * math.pi)


def ring_of(views: Sequence[PosedView], axis: Floats, tilt_deg: float) -> tuple[int, ...]:
    """
    Return the views that turned about the axis, in the order round it.

    The largest group whose motions among each other leave the axis where it is.
    """
    inside = np.array([one.T_object_view[:3, :3].T @ axis for one in views])
    alike = np.einsum('vi,wi->vw', inside, inside) >= math.cos(math.radians(tilt_deg))
    members = np.flatnonzero(alike[np.argmax(alike.sum(axis=1))]).tolist()
    first = views[members[0]].T_object_view
    around = [
        math.fmod(_turned(first, views[k].T_object_view, axis) + 2.0 * math.pi, 2.0 * math.pi)
        for k in members]
    return tuple(members[k] for k in np.argsort(around, kind='stable'))


def next_turn(closure: Closure, views: Sequence[PosedView], axis: Floats) -> Turn | None:
    """
    Return by how much to turn the object next, from where it stood in its last view.

    The last view is the one with the highest number. To turn the object by an angle about the
    axis shows the sensor what it would see from a direction turned the other way round.

    Parameters
    ----------
    closure : Closure
    views : sequence of PosedView
    axis : (3,) float64
        As `axis_of` returns it.

    Returns
    -------
    Turn or None
        None if no angle would show anything worth a view.
    """
    last = max(views, key=lambda one: one.number)
    towards = last.view.sensor.to_sensor(last.view.points).mean(axis=0)
    towards = last.T_object_view[:3, :3] @ (towards / np.linalg.norm(towards))
    angles = np.arange(STEP_DEG, 360.0, STEP_DEG)
    about = Rotation.from_rotvec(np.multiply.outer(-np.radians(angles), axis))
    gains = gains_of(closure, about.apply(towards))
    best = int(np.argmax(gains))
    if gains[best] < _LEAST_GAIN:
        return None
    angle = math.remainder(float(angles[best]), 360.0)
    x, y, z = (float(value) for value in axis)
    return Turn((x, y, z), angle, float(gains[best]))
