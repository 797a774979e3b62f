# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the lines of sight: what a view says of a point of space."""

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Floats, frozen, Ints, is_rigid, SensorModel
from ros_rops.kernels import _kernels
from ros_rops.kernels.meshes import check_mesh

Floats32 = NDArray[np.float32]
_SENSOR_KINDS = {'unknown': 0, 'orthographic': 1, 'pinhole': 2}


class Look(NamedTuple):
    """
    What a view says of M points.

    Parameters
    ----------
    distance : (M,) float32
        Along the line of sight to the view's surface, in its units: positive in front of it (on
        the sensor's side), negative behind; +inf where the ray is known to pass by; NaN where
        the view knows nothing (outside, a hole, a depth step).
    weight : (M,) float32
        Of the surface there, interpolated; 0 where there is none.
    cosine : (M,) float32
        Between the ray and the normal of the surface there; 0 where there is none.
    """

    distance: Floats32
    weight: Floats32
    cosine: Floats32


@dataclass(frozen=True, slots=True)
class Sight:
    """
    The lines of sight of a view in its place (Curless and Levoy 1996, 2).

    Parameters
    ----------
    kernel : object
        The compiled part: triangles listed by pixel of the sensor's image plane (unknown sensors:
        by cell of space).
    """

    kernel: '_kernels._Sight'

    @classmethod
    def of(
        cls,
        vertices: Floats,
        faces: Ints,
        weights: Floats32,
        sensor: SensorModel,
        *,
        T_object_view: Floats | None = None,
        beyond: Floats32 | None = None,
    ) -> 'Sight':
        """
        Prepare the look-up of a view.

        Parameters
        ----------
        vertices : (N, 3) float64
            In the view's frame.
        faces : (F, 3) int32
            Counter-clockwise seen from the sensor.
        weights : (N,) float32
        sensor : SensorModel
        T_object_view : (4, 4) float64, optional
            Where the view stands; the identity if left out.
        beyond : (M, 3) float32, optional
            Where rays ended that pass by the object, in the view's frame.

        Raises
        ------
        ShapeError
            If an array has the wrong shape, a face names no vertex, or the pose is not rigid.
        """
        T = np.eye(4) if T_object_view is None else np.asarray(T_object_view, np.float64)
        past = np.empty((0, 3), np.float32) if beyond is None else beyond
        _check(vertices, faces, weights, T, past)
        return cls(_kernels._Sight(
            vertices, faces, weights, _SENSOR_KINDS[sensor.kind], list(sensor.origin),
            list(sensor.direction), T, past))

    def look(self, points: Floats, *, reach: float, threads: int = 0) -> Look:
        """
        Look at `points` along the view's lines of sight.

        A ray counts where it meets a triangle, to the nearest of which the distance is exact. A
        view of an unknown sensor has no rays: the distance is that to the nearest point of its
        surface within `reach`, and nothing is said beside its rim.

        Parameters
        ----------
        points : (M, 3) float64
            In the object's frame.
        reach : float
            How far the surface of an unknown sensor is looked for; others see along all the ray.
        threads : int
            0 takes all cores; no influence on the result.

        Raises
        ------
        ShapeError
            If `points` has another shape or `reach` is negative or not finite.
        """
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError(f'points: expected (M, 3), got {points.shape}')
        if not 0.0 <= reach < math.inf:
            raise ShapeError(f'reach: must be a length, got {reach}')
        return Look(*(frozen(a, np.float32) for a in self.kernel.look(points, reach, threads)))


def _check(
    vertices: Floats, faces: Ints, weights: Floats32, T: Floats, beyond: Floats32
) -> None:
    check_mesh(vertices, faces)
    if weights.shape != vertices.shape[:1]:
        raise ShapeError(f'weights: expected ({len(vertices)},), got {weights.shape}')
    if beyond.ndim != 2 or beyond.shape[1] != 3:
        raise ShapeError(f'beyond: expected (M, 3), got {beyond.shape}')
    if not is_rigid(T):
        raise ShapeError(f'T_object_view: no rigid motion: {T.tolist()}')
