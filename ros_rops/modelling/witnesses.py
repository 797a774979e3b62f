# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the views of an object testify of each other's points: seen there, or seen through."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Floats, SensorModel
from ros_rops.kernels.sight import Sight
from ros_rops.modelling.gathering import surface_points
from ros_rops.modelling.posed import PosedView

SAMPLES = 300
"""Points of a view that the others are asked about."""
BEYOND_WEIGHT = 0.5
"""Of a ray that is known to pass by."""
MOST_WRONG = 0.1
"""
A view of which the others deny more than this share of what they can judge is left out.

Of right poses they deny nothing (measured: none of 60,000 points of the four real sets), while a
wrong view agrees with the others where its surface happens to run through theirs.
"""
FEWEST_JUDGED = 0.1
"""Of a view's samples; of fewer nothing is concluded."""
FEWEST_VIEWS = 3
"""Of two views that contradict each other none is known to be the wrong one."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """
    Lengths in the units of the views.

    Parameters
    ----------
    same : float
        Points so near to a view's surface, across it, were seen by the view.
    through : float
        Points so far in front of a view's surface, across it, are not there.
    sideways : float
    """

    same: float
    through: float
    sideways: float


class Witness:
    """A view that may be asked about points; `view` in its place."""

    def __init__(self, view: PosedView) -> None:
        self._T = view.T_object_view
        self._sensor = view.view.sensor
        self._sight = Sight.of(
            view.mesh.vertices, view.mesh.faces, view.weights, view.view.sensor,
            T_object_view=view.T_object_view, beyond=view.view.beyond)

    def confirms(self, points: Floats, tolerance: Tolerance, threads: int) -> Bools:
        """Tell which of `points` (M, 3) lie on the surface that the view saw, (M,)."""
        look = self._sight.look(points, reach=tolerance.through, threads=threads)
        with np.errstate(invalid='ignore'):  # rays that pass by are infinite, and have no angle
            return np.abs(look.distance) * look.cosine < tolerance.same

    def denies(
        self, points: Floats, tolerance: Tolerance, threads: int
    ) -> NDArray[np.float32]:
        """
        Return by what weight the view saw through `points` (M, 3); 0 where it did not.

        A point is seen through if a surface was seen well behind it, along its own ray and along
        those that pass beside it on all sides.
        """
        weights = self._through(points, tolerance, threads)
        some = np.flatnonzero(weights)
        for side in self._sides(points[some], tolerance.sideways):
            beside = self._through(side, tolerance, threads)
            weights[some] = np.minimum(weights[some], beside)
        return weights

    def _through(
        self, points: Floats, tolerance: Tolerance, threads: int
    ) -> NDArray[np.float32]:
        look = self._sight.look(points, reach=tolerance.through, threads=threads)
        past = np.isposinf(look.distance)
        with np.errstate(invalid='ignore'):
            behind = look.distance * look.cosine > tolerance.through
        result: NDArray[np.float32] = np.where(
            past, BEYOND_WEIGHT, np.where(behind, look.weight, 0.0)).astype(np.float32)
        return result

    def _sides(self, points: Floats, far: float) -> list[Floats]:
        """Return the points moved by `far` to four sides, across the lines of sight."""
        rays = _rays(self._sensor, points, self._T)
        helper = np.eye(3)[np.argmin(np.abs(rays), axis=1)]
        right = np.cross(helper, rays)
        right /= np.linalg.norm(right, axis=1, keepdims=True)
        return [points + far * way for way in (
            right, -right, np.cross(rays, right), -np.cross(rays, right))]


def _rays(sensor: SensorModel, points: Floats, T_object_view: Floats) -> Floats:
    turn, shift = T_object_view[:3, :3], T_object_view[:3, 3]
    rays: Floats = sensor.to_sensor((points - shift) @ turn) @ turn.T
    return rays


def wrong_views(
    views: Sequence[PosedView], witnesses: Sequence[Witness], tolerance: Tolerance, *,
    threads: int = 0,
) -> list[int]:
    """
    Find the views whose poses contradict the others.

    Parameters
    ----------
    views : sequence of PosedView
    witnesses : sequence of Witness
        Of the same views.
    tolerance : Tolerance
    threads : int

    Returns
    -------
    list of int
        Their places in `views`, the worst first, less than half of all; as they are taken out one
        by one, what they testified no longer counts.
    """
    for_, against = _testimony(views, witnesses, tolerance, threads)
    left, wrong = list(range(len(views))), []
    while len(left) >= FEWEST_VIEWS and 2 * len(left) > len(views):
        denied = against[np.ix_(left, left)].sum(axis=1)
        judged = denied + for_[np.ix_(left, left)].sum(axis=1)
        share = denied / np.maximum(judged, FEWEST_JUDGED * SAMPLES)
        worst = int(np.argmax(share))
        if share[worst] <= MOST_WRONG:
            break
        wrong.append(left.pop(worst))
    return wrong


def _testimony(
    views: Sequence[PosedView], witnesses: Sequence[Witness], tolerance: Tolerance, threads: int
) -> tuple[Floats, Floats]:
    """Return how many points each two views confirm and deny of each other, (V, V) each."""
    count = len(views)
    for_, against = np.zeros((count, count)), np.zeros((count, count))
    for i, view in enumerate(views):
        on = np.flatnonzero(surface_points(view))
        points = view.points[on[np.linspace(0, len(on), min(SAMPLES, len(on)), False).astype(int)]]
        for j, witness in enumerate(witnesses):
            if i != j and len(points):
                for_[i, j] = witness.confirms(points, tolerance, threads).sum()
                against[i, j] = (witness.denies(points, tolerance, threads) > 0).sum()
    return for_ + for_.T, against + against.T
