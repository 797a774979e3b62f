# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The products that the stages hand on.

All are frozen, their arrays read-only. N points, F faces, K keypoints, D descriptor entries.
Lengths are in the view's own units; a transform `T_target_source` maps source points into the
target frame: p_target = T_target_source p_source.
"""
# The name is short and never imported bare, so it hides nothing:
# flake8: noqa: A005

from dataclasses import dataclass, replace
from enum import Enum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import ShapeError

Floats = NDArray[np.float64]
Floats32or64 = NDArray[np.float32] | NDArray[np.float64]
Ints = NDArray[np.int32]
Bools = NDArray[np.bool_]
Bytes = NDArray[np.uint8]

Units = Literal['m', 'mm', 'unknown']

LEAST_RIGID = 1e-6
"""So much a rotation may be off: numbers are rounded where they are stored and multiplied."""


def frozen(array: NDArray, dtype: type) -> NDArray:
    """Return `array` as a read-only C-contiguous array of `dtype` (a copy if need be)."""
    result: NDArray = np.ascontiguousarray(array, dtype=dtype)
    if result.flags.writeable:
        result = result.view()
        result.flags.writeable = False
    return result


def _all_finite(values: Floats) -> bool:
    with np.errstate(all='ignore'):
        # What is not finite never adds up to something finite: one pass, and no array of answers.
        return bool(np.isfinite(values.sum())) or bool(np.isfinite(values).all())


def is_rigid(T: Floats) -> bool:
    """Tell whether `T` is a rotation and a shift, (4, 4), all finite."""
    if T.shape != (4, 4) or not np.isfinite(T).all():
        return False
    turn = T[:3, :3]
    return (
        np.array_equal(T[3], (0.0, 0.0, 0.0, 1.0)) and float(np.linalg.det(turn)) > 0.0
        and bool(np.abs(turn @ turn.T - np.eye(3)).max() < LEAST_RIGID))


class Status(Enum):
    """What became of a view or of a pair; never told by a special transform."""

    PLACED = 'placed'
    PENDING = 'pending'
    AMBIGUOUS = 'ambiguous'
    REFUSED = 'refused'


@dataclass(frozen=True, slots=True)
class SensorModel:
    """
    Where the rays of a view come from, in the view's frame.

    Parameters
    ----------
    kind : {'pinhole', 'orthographic', 'unknown'}
        `pinhole`: all rays leave `origin`. `orthographic`: all rays run along `direction`.
        `unknown`: no evidence can be drawn from the rays.
    origin : (3,) tuple of float
        Centre of projection (pinhole only), in the view's units.
    direction : (3,) tuple of float
        Unit vector from the sensor into the scene.
    """

    kind: Literal['pinhole', 'orthographic', 'unknown'] = 'unknown'
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def to_sensor(self, points: Floats) -> Floats:
        """
        Return unit vectors from `points` (N, 3) towards the sensor.

        For an unknown sensor the vectors are -`direction`, which only orients normals.
        """
        if self.kind == 'pinhole':
            rays = np.asarray(self.origin) - points
            length = np.linalg.norm(rays, axis=1, keepdims=True)
            return rays / np.where(length > 0, length, 1.0)
        return np.broadcast_to(-np.asarray(self.direction), points.shape)


@dataclass(frozen=True, slots=True)
class SupportPlane:
    """
    The plane that the object of a view stands on, in the view's frame.

    Parameters
    ----------
    normal : (3,) tuple of float
        Unit, towards the side on which the object stands.
    offset : float
        In the view's units: normal . p = offset for a point of the plane.
    """

    normal: tuple[float, float, float]
    offset: float


@dataclass(frozen=True, slots=True)
class RangeView:
    """
    What one sensor pose saw.

    Parameters
    ----------
    name : str
        The file's or message's name as given; unique within a session.
    points : (N, 3) float64
        Finite points only, in the sensor's frame.
    grid : (H, W) int32 or None
        For an organized view, the index of the point behind each pixel, -1 where none.
    sensor : SensorModel
    colors : (N, 3) uint8 or None
        Red, green, blue.
    units : {'m', 'mm', 'unknown'}
    stamp_ns : int or None
        Time of capture.
    frame_id : str
        The sensor's frame.
    support : SupportPlane or None
        What the object stands on, where it was seen.
    beyond : (M, 3) float32 or None
        Where rays ended that pass by the object (table, wall): up to there space is empty.
    T_fixed_sensor : (4, 4) float64 or None
        Where the sensor stood in a frame in which the object stands still, as something else
        than the points tells it (TF); in the view's units.

    Raises
    ------
    ShapeError
        If an array's shape or the grid's indices do not fit `points`, or `T_fixed_sensor` is no
        rigid motion.
    """

    name: str
    points: Floats
    grid: Ints | None = None
    sensor: SensorModel = SensorModel()
    colors: Bytes | None = None
    units: Units = 'unknown'
    stamp_ns: int | None = None
    frame_id: str = ''
    support: SupportPlane | None = None
    beyond: NDArray[np.float32] | None = None
    T_fixed_sensor: Floats | None = None

    def __post_init__(self) -> None:
        """Check shapes and make the arrays read-only."""
        points = frozen(self.points, np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError(f'points of {self.name!r}: expected (N, 3), got {points.shape}')
        if not _all_finite(points):
            raise ShapeError(f'points of {self.name!r}: not finite (drop such points first)')
        object.__setattr__(self, 'points', points)
        if self.grid is not None:
            grid = frozen(self.grid, np.int32)
            if grid.ndim != 2 or (grid.size and grid.max() >= len(points)):
                raise ShapeError(f'grid of {self.name!r}: expected (H, W) indices < {len(points)}')
            object.__setattr__(self, 'grid', grid)
        if self.colors is not None:
            colors = frozen(self.colors, np.uint8)
            if colors.shape != points.shape:
                raise ShapeError(f'colors of {self.name!r}: {colors.shape} != {points.shape}')
            object.__setattr__(self, 'colors', colors)
        if self.beyond is not None:
            beyond = frozen(self.beyond, np.float32)
            if beyond.ndim != 2 or beyond.shape[1] != 3 or not np.isfinite(beyond).all():
                raise ShapeError(
                    f'beyond of {self.name!r}: expected finite (M, 3), got {beyond.shape}')
            object.__setattr__(self, 'beyond', beyond)
        if self.T_fixed_sensor is not None:
            T = frozen(self.T_fixed_sensor, np.float64)
            if not is_rigid(T):
                raise ShapeError(f'T_fixed_sensor of {self.name!r}: no rigid motion: {T.tolist()}')
            object.__setattr__(self, 'T_fixed_sensor', T)

    def scaled(self, factor: float, units: Units) -> 'RangeView':
        """Return the view with all its lengths times `factor`, which are then in `units`."""
        x, y, z = self.sensor.origin
        sensor = replace(self.sensor, origin=(x * factor, y * factor, z * factor))
        support = self.support and replace(self.support, offset=self.support.offset * factor)
        beyond = None if self.beyond is None else self.beyond * np.float32(factor)
        T_fixed_sensor = self.T_fixed_sensor
        if T_fixed_sensor is not None:
            T_fixed_sensor = T_fixed_sensor.copy()
            T_fixed_sensor[:3, 3] *= factor
        return replace(
            self, points=self.points * factor, sensor=sensor, units=units, support=support,
            beyond=beyond, T_fixed_sensor=T_fixed_sensor)


@dataclass(frozen=True, slots=True)
class RangeMesh:
    """
    A view's triangle mesh (Guo et al. 2014, III-A).

    Parameters
    ----------
    vertices : (N, 3) float64
    faces : (F, 3) int32
        Counter-clockwise seen from the sensor.
    normals : (N, 3) float64
        Unit, towards the sensor; zero for vertices without a face.
    boundary : (N,) bool
        Vertices on an edge that has one face only, or without a face.
    resolution : float
        Mean length of the mesh's edges (`mr`, each edge once).
    """

    vertices: Floats
    faces: Ints
    normals: Floats
    boundary: Bools
    resolution: float


@dataclass(frozen=True, slots=True)
class Features:
    """
    RoPS features of a view (III-A).

    Parameters
    ----------
    indices : (K,) int32
        Vertex of each keypoint.
    positions : (K, 3) float64
    lrfs : (K, 3, 3) float64
        Rows are the axes x, y, z of the local reference frame.
    descriptors : (K, D) float32
    """

    indices: Ints
    positions: Floats
    lrfs: Floats
    descriptors: NDArray[np.float32]
