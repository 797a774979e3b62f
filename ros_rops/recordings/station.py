# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How a simulated capture goes: which objects, which poses, at what times."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ros_rops.core.errors import ParameterError
from ros_rops.core.types import Floats
from ros_rops.recordings.scene import Placed
from ros_rops.recordings.synthetic import directions_around, look_at, Model

START_NS = 1_700_000_000_000_000_000


@dataclass(frozen=True, slots=True)
class Plan:
    """
    What the operator does; lengths in metres.

    Parameters
    ----------
    capture : {'turntable', 'hand-held'}
        Which of the two moves, the object or the camera.
    views : int
        Stops: of each object, or of the scene if the objects stand together.
    step_deg : float or None
        Turn of the table between stops; None for a full turn in `views` stops.
    elevation_deg : tuple of float
        Height of the camera above the table as an angle, turntable only; stops take turns.
    distance : float
        From the camera to the middle of what it looks at; 0 for 2.8 radii of the largest.
    together : bool
        All objects stand on the table at once, not one after the other.
    mixed : bool
        Frames come in random order, as when objects are changed all the time.
    still : int
        Frames at each stop.
    moving : int
        Frames between one stop and the next.
    rate_hz : float
        Frames a second.
    """

    capture: Literal['turntable', 'hand-held'] = 'turntable'
    views: int = 18
    step_deg: float | None = None
    elevation_deg: tuple[float, ...] = (35.0,)
    distance: float = 0.0
    together: bool = False
    mixed: bool = True
    still: int = 1
    moving: int = 0
    rate_hz: float = 1.0

    def __post_init__(self) -> None:
        """Check what the options say together."""
        for name, least in (('views', 1), ('still', 1), ('moving', 0)):
            if getattr(self, name) < least:
                raise ParameterError(
                    f'{name}: must be at least {least}, got {getattr(self, name)}')
        if not 0 < self.rate_hz <= 1000:
            raise ParameterError(f'rate: must lie in 0-1000 Hz, got {self.rate_hz}')
        if not 0 <= self.distance < np.inf:
            raise ParameterError(f'distance: must be at least 0, got {self.distance}')
        if self.step_deg is not None and not np.isfinite(self.step_deg):
            raise ParameterError(f'step: must be a number, got {self.step_deg}')
        if not self.elevation_deg or not all(-90 < e < 90 for e in self.elevation_deg):
            raise ParameterError(
                f'elevation: must lie within -90 and 90 degrees, got {self.elevation_deg}')
        if self.moving and self.mixed:
            raise ParameterError('moving: frames between stops need the order of time')

    def frames(self, objects: int) -> int:
        """Return the number of frames of a capture of so many objects."""
        groups = 1 if self.together else objects
        return groups * (self.views * self.still + (self.views - 1) * self.moving)


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """
    One frame to be taken.

    Parameters
    ----------
    objects : tuple of int
        Which stand on the table.
    T_world_turntable, T_world_camera : (4, 4) float64
    stop : int or None
        The stop's number, None while something moves.
    stamp_ns : int
    """

    objects: tuple[int, ...]
    T_world_turntable: Floats
    T_world_camera: Floats
    stop: int | None
    stamp_ns: int


def place(models: Sequence[Model], *, together: bool, rng: np.random.Generator) -> list[Placed]:
    """
    Stand models on the turntable, their lowest points at height 0, turned at random.

    One after the other they stand a little off the axis; together, in a circle, apart.
    """
    reach = [float(np.hypot(*(m.vertices - m.middle)[:, :2].T).max()) for m in models]
    widest = max(reach)
    ring = 0.0
    if together and len(models) > 1:
        ring = 1.15 * widest / np.sin(np.pi / len(models))
    placed = []
    for k, model in enumerate(models):
        turn, away, towards = rng.uniform(-np.pi, np.pi), rng.uniform(0, 0.1), rng.uniform(0, 7)
        around = 2 * np.pi * k / len(models)
        T = about_z(turn)
        spot = ring * np.array([np.cos(around), np.sin(around)])
        if not ring:
            spot = away * widest * np.array([np.cos(towards), np.sin(towards)])
        foot = np.array([*model.middle[:2], model.vertices[:, 2].min()])
        T[:3, 3] = np.array([*spot, 0.0]) - T[:3, :3] @ foot
        placed.append(Placed(model, T))
    return placed


def about_z(angle: float) -> Floats:
    """Return the rotation (4, 4) about z by `angle` (radians)."""
    T = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    T[:2, :2] = [[c, -s], [s, c]]
    return T


def shots(placed: Sequence[Placed], plan: Plan, rng: np.random.Generator, *,
          above: bool) -> list[Shot]:
    """
    Return the frames of a capture in the order of their stamps.

    Parameters
    ----------
    placed : sequence of Placed
    plan : Plan
    rng : Generator
        Of hand-held poses and of the order.
    above : bool
        The camera stays above the table (hand-held).
    """
    groups = [tuple(range(len(placed)))] if plan.together else [(k,) for k in range(len(placed))]
    radius = max(_sphere([placed[k] for k in group])[1] for group in groups)
    found: list[Shot] = []
    for group in groups:
        middle = _sphere([placed[k] for k in group])[0]
        stops = _stops(plan, middle, plan.distance or 2.8 * radius, radius, rng, above)
        for number, (table, eye) in enumerate(stops):
            found += [Shot(group, table, eye, number, 0)] * plan.still
            if number + 1 < len(stops):
                found += [
                    Shot(group, *_between(stops[number], stops[number + 1], step), None, 0)
                    for step in np.arange(1, plan.moving + 1) / (plan.moving + 1)]
    order = rng.permutation(len(found)) if plan.mixed else np.arange(len(found))
    period = round(1e9 / plan.rate_hz)
    return [
        Shot(s.objects, s.T_world_turntable, s.T_world_camera, s.stop, START_NS + n * period)
        for n, s in enumerate(found[k] for k in order)]


def _sphere(placed: Sequence[Placed]) -> tuple[Floats, float]:
    """Middle and radius of what stands on the table."""
    points = np.concatenate([
        p.model.vertices @ p.T_turntable_object[:3, :3].T + p.T_turntable_object[:3, 3]
        for p in placed])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return middle, float(np.linalg.norm(points - middle, axis=1).max())


Stop = tuple[Floats, Floats]
"""T_world_turntable, T_world_camera."""


def _stops(
    plan: Plan, middle: Floats, distance: float, radius: float, rng: np.random.Generator,
    above: bool,
) -> list[Stop]:
    if plan.capture == 'turntable':
        step = 360.0 / plan.views if plan.step_deg is None else plan.step_deg
        target = np.array([0.0, 0.0, middle[2]])
        stops = []
        for k in range(plan.views):
            up = np.deg2rad(plan.elevation_deg[k % len(plan.elevation_deg)])
            eye = target + distance * np.array([np.cos(up), 0.0, np.sin(up)])
            stops.append((about_z(np.deg2rad(k * step)), _upright(eye, target)))
        return stops
    result = []
    for direction in directions_around(plan.views, rng):
        if above:
            direction = np.array([*direction[:2], 0.25 + 0.75 * abs(direction[2])])
            direction /= np.linalg.norm(direction)
        eye = middle + direction * distance * rng.uniform(0.95, 1.15)
        target = middle + rng.normal(0.0, 0.05 * radius, 3)
        result.append((np.eye(4), look_at(eye, target, rng.uniform(-np.pi, np.pi))))
    return result


def _upright(eye: Floats, target: Floats) -> Floats:
    """Return `T_world_camera` with the image's rows parallel to the table."""
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, (0.0, 0.0, 1.0))
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    T[:3, 3] = eye
    return T


def _between(start: Stop, end: Stop, share: float) -> Stop:
    """Poses on the way: turned evenly, moved in a straight line."""
    return _blend(start[0], end[0], share), _blend(start[1], end[1], share)


def _blend(a: Floats, b: Floats, share: float) -> Floats:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(a[:3, :3].T @ b[:3, :3]).as_rotvec()
    T = np.eye(4)
    T[:3, :3] = a[:3, :3] @ Rotation.from_rotvec(share * turn).as_matrix()
    T[:3, 3] = (1 - share) * a[:3, 3] + share * b[:3, 3]
    return T
