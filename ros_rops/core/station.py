# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What a station knows of poses beforehand: the objects' foot, the turntable, the sensor's poses.

Knowledge proposes poses and objects to others; it never makes a pose believed that the data do
not support. A shape's frame is the sensor's frame of its first view, so that both planes and the
axis of a fixed sensor are known in it. Sensor poses differ: they are of single views.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import math

import numpy as np
from ros_rops.core.config import PriorConfig
from ros_rops.core.se3 import rigid
from ros_rops.core.surface import Surface
from ros_rops.core.types import Bools, Floats, SupportPlane
from scipy.spatial.transform import Rotation

# Poses not yet refined may be off by so many times what refined ones may.
SLACK = 2.0
# Turns about a known axis that are tried.
TURNS = 180
# Poses that are tried around the one that sensor poses say.
AROUND = 500


@dataclass(frozen=True, slots=True)
class Axis:
    """
    A turntable's axis in the frame of the sensor, which stands still.

    Parameters
    ----------
    direction : (3,) tuple of float
        Unit.
    point : (3,) tuple of float
        The point of the axis nearest to the objects' middle.
    """

    direction: tuple[float, float, float]
    point: tuple[float, float, float]

    def turn(self, angles: Floats) -> Floats:
        """Return the transforms (A, 4, 4) that turn by `angles` (A,), in rad, about the axis."""
        axis, point = np.asarray(self.direction), np.asarray(self.point)
        rotations = Rotation.from_rotvec(np.multiply.outer(angles, axis)).as_matrix()
        return rigid(rotations, point - rotations @ point)

    def angle(self, pose: Floats) -> float:
        """Return by how much, in rad, a pose (4, 4) turns about the axis."""
        x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
        along = float(np.dot((x, y, z), self.direction))
        return math.remainder(2.0 * math.atan2(along, w), 2.0 * math.pi)


@dataclass(frozen=True, slots=True)
class Known:
    """
    What is known of the pose between two surfaces.

    Parameters
    ----------
    config : PriorConfig
    axis : Axis or None
    turns : tuple of float or None
        The only turns about the axis that are possible, in rad; None for any.
    way : int
        Sign that the turn must have; 0 for either.
    metre : float or None
        A metre in the units of the surfaces; None if that is not known: then sensor poses say
        nothing.
    """

    config: PriorConfig
    axis: Axis | None = None
    turns: tuple[float, ...] | None = None
    way: int = 0
    metre: float | None = None

    def starts(
        self, source: Surface, target: Surface, count: int, rng: np.random.Generator
    ) -> Floats:
        """Propose poses (H, 4, 4) that agree with what is known, `count` at most."""
        proposals = []
        predicted = self.predicted(source, target)
        if predicted is not None and self.metre is not None:
            proposals.append(poses_around(
                predicted, source.evidence.centre, math.radians(self.config.pose_deg),
                self.config.pose_m * self.metre, min(count, AROUND), rng))
        elif self.axis is not None:
            turns = self.turns
            if turns is None:
                turns = tuple(np.arange(TURNS) * (2.0 * math.pi / TURNS))
            proposals.append(self.axis.turn(np.array(turns)))
        elif self.config.plane and source.support and target.support:
            proposals.append(standing_transforms(source, target, count, rng))
        return np.concatenate([np.empty((0, 4, 4)), *proposals])

    def predicted(self, source: Surface, target: Surface) -> Floats | None:
        """Return the pose (4, 4) that the sensor poses say; None where they are not known."""
        here, there = source.T_fixed_surface, target.T_fixed_surface
        if not self.config.fixed_frame or self.metre is None or here is None or there is None:
            return None
        pose: Floats = np.linalg.inv(there) @ here
        return pose

    def admits(
        self, poses: Floats, source: Surface, target: Surface, slack: float = SLACK
    ) -> Bools:
        """Whether each pose (H, 4, 4) agrees, within `slack` times the tolerances: (H,)."""
        fine = np.ones(len(poses), dtype=bool)
        for misfit in self._misfits(poses, source, target):
            fine &= misfit.values <= slack * misfit.most
        return fine

    def objection(self, pose: Floats, source: Surface, target: Surface) -> str:
        """Return what speaks against a refined pose (4, 4), '' if nothing does."""
        for misfit in self._misfits(pose[None], source, target):
            if misfit.values[0] > misfit.most:
                return (
                    f'the pose contradicts {misfit.what} by {misfit.values[0]:.1f} {misfit.unit}')
        return ''

    def _misfits(self, poses: Floats, source: Surface, target: Surface) -> Iterator['_Misfit']:
        """Yield how far the poses (H, 4, 4) are from all that is known."""
        tilt, distance = self.config.tilt_deg, self.config.distance_mr
        rotations, shifts = poses[:, :3, :3], poses[:, :3, 3]
        here, there = source.support, target.support
        if self.config.plane and here and there:
            normal, foot = np.asarray(there.normal), _foot(here, source.evidence.centre)
            height = np.abs((rotations @ foot + shifts) @ normal - there.offset)
            what = 'the supporting plane'
            yield _Misfit(what, _degrees(rotations @ np.asarray(here.normal), normal), tilt, 'deg')
            yield _Misfit(what, height / target.resolution, distance, 'mr')
        if self.axis is not None:
            direction, point = np.asarray(self.axis.direction), np.asarray(self.axis.point)
            away = np.linalg.norm(rotations @ point + shifts - point, axis=1)
            what = "the turntable's axis"
            yield _Misfit(what, _degrees(rotations @ direction, direction), tilt, 'deg')
            yield _Misfit(what, away / target.resolution, distance, 'mr')
            if self.way:
                back = np.array([-self.way * self.axis.angle(pose) for pose in poses])
                what = 'the order of the views'
                yield _Misfit(what, np.degrees(back), self.config.turn_deg, 'deg')
        predicted = self.predicted(source, target)
        if predicted is not None and self.metre is not None:
            what, middle = 'the sensor poses in TF', source.evidence.centre
            apart = predicted[:3, :3].T @ rotations
            moved = rotations @ middle + shifts - predicted[:3, :3] @ middle - predicted[:3, 3]
            yield _Misfit(
                what, np.degrees(Rotation.from_matrix(apart).magnitude()), self.config.pose_deg,
                'deg')
            yield _Misfit(
                what, np.linalg.norm(moved, axis=1) * (1e3 / self.metre),
                self.config.pose_m * 1e3, 'mm')
        if self.turns is not None:
            yield _Misfit('the known turn', self._turned_wrong(poses), self.config.turn_deg, 'deg')

    def _turned_wrong(self, poses: Floats) -> Floats:
        """Return how far (H,), in deg, the poses' turns are from the nearest possible one."""
        turns = np.array(self.turns)
        if self.axis is not None:
            own = np.array([self.axis.angle(pose) for pose in poses])
        else:  # the direction of a turn is that of its axis: only the amount can be compared
            own = Rotation.from_matrix(poses[:, :3, :3]).magnitude()
            turns = np.abs(np.remainder(turns + math.pi, 2.0 * math.pi) - math.pi)
        apart = own[:, None] - turns[None, :]
        around = np.abs(np.remainder(apart + math.pi, 2.0 * math.pi) - math.pi)
        wrong: Floats = np.degrees(around.min(axis=1, initial=math.pi))
        return wrong


@dataclass(frozen=True, slots=True)
class _Misfit:
    """How far poses are from something known: values (H,), the most allowed, in `unit`."""

    what: str
    values: Floats
    most: float
    unit: str


def poses_around(
    pose: Floats, middle: Floats, angle: float, distance: float, count: int,
    rng: np.random.Generator,
) -> Floats:
    """
    Return `pose` and others around it, the denser the nearer.

    Parameters
    ----------
    pose : (4, 4) float64
        `T_target_source`.
    middle : (3,) float64
        Of the source: what is turned about.
    angle, distance : float
        Most that the others turn, in rad, and move the middle.
    count : int
    rng : numpy.random.Generator

    Returns
    -------
    (count, 4, 4) float64
        `pose` first.
    """
    shake = rng.normal(size=(2, count, 3))
    shake /= np.linalg.norm(shake, axis=2, keepdims=True)
    shake *= rng.random((2, count, 1)) * np.array([angle, distance])[:, None, None]
    shake[:, 0] = 0.0
    rotations = Rotation.from_rotvec(shake[0]).as_matrix()
    poses: Floats = pose @ rigid(rotations, middle - rotations @ middle + shake[1])
    return poses


def standing_transforms(
    source: Surface, target: Surface, count: int, rng: np.random.Generator
) -> Floats:
    """
    Pair features at random that are alike in height, and stand the source on the target's plane.

    An oriented point on each side fixes the rest: the turn brings the normals' horizontal parts
    together, the shift the points.

    Returns
    -------
    (H, 4, 4) float64
        `T_target_source`, H at most `count`.
    """
    here, there = source.support, target.support
    a, b = source.features, target.features
    if here is None or there is None or not len(a.indices) or not len(b.indices):
        return np.empty((0, 4, 4))
    upright_a, upright_b = _upright(here), _upright(there)
    i, j = (rng.integers(0, len(side.indices), 20 * count) for side in (a, b))
    high_a = a.positions @ upright_a[2] - here.offset
    high_b = b.positions @ upright_b[2] - there.offset
    alike = np.abs(high_a[i] - high_b[j]) <= 2.0 * target.resolution
    normal_a, normal_b = a.lrfs[:, 2] @ upright_a.T, b.lrfs[:, 2] @ upright_b.T
    alike &= np.abs(normal_a[i, 2] - normal_b[j, 2]) <= 0.3
    # A normal along the plane's says nothing of the turn.
    alike &= np.abs(normal_a[i, 2]) < 0.9
    chosen = np.flatnonzero(alike)[:count]
    i, j = i[chosen], j[chosen]
    turn = (
        np.arctan2(normal_b[j, 1], normal_b[j, 0]) - np.arctan2(normal_a[i, 1], normal_a[i, 0]))
    about = Rotation.from_rotvec(np.multiply.outer(turn, (0.0, 0.0, 1.0))).as_matrix()
    rotations = upright_b.T @ about @ upright_a
    shift = b.positions[j] - np.einsum('hij,hj->hi', rotations, a.positions[i])
    feet = np.einsum('hij,j->hi', rotations, _foot(here, np.zeros(3))) + shift
    height = feet @ upright_b[2] - there.offset
    return rigid(rotations, shift - height[:, None] * upright_b[2])


def _upright(plane: SupportPlane) -> Floats:
    """Return axes (3, 3), rows, of which the third is the plane's normal."""
    normal = np.asarray(plane.normal)
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    x = np.cross(helper, normal)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(normal, x), normal])


def _foot(plane: SupportPlane, point: Floats) -> Floats:
    """Return the point of the plane below `point` (3,)."""
    normal = np.asarray(plane.normal)
    foot: Floats = point - (point @ normal - plane.offset) * normal
    return foot


def _degrees(vectors: Floats, axis: Floats) -> Floats:
    """Angles (H,) between unit vectors (H, 3) and a unit axis (3,)."""
    angles: Floats = np.degrees(np.arccos(np.clip(vectors @ axis, -1.0, 1.0)))
    return angles
