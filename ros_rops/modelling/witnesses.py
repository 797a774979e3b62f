# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a view testifies of points of others: that it saw through them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Floats, SensorModel
from ros_rops.modelling.posed import PosedView

BEYOND_WEIGHT = 0.5
"""Of a ray that is known to pass by."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """
    Lengths in the units of the views.

    Parameters
    ----------
    through : float
        Points so far in front of a view's surface, across it, are not there.
    sideways : float
        A ray that passes an edge by less might meet it if the pose were a little better.
    """

    through: float
    sideways: float


class Witness:
    """A view that may be asked about points; `view` in its place."""

    def __init__(self, view: PosedView) -> None:
        self._T = view.T_object_view
        self._sensor = view.view.sensor
        self._sight = view.sight()

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
