# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the kernel that makes one sheet of overlapping views."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Bytes, Floats, Ints
from ros_rops.kernels import _kernels

Floats32 = NDArray[np.float32]


class Samples(NamedTuple):
    """
    Measured points of several views, in one frame.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float32
        Unit, towards the sensor.
    weights : (N,) float32
        Above 0.
    views : (N,) int32
        Number of the view, below `view_count`.
    colors : (N, 4) uint8, or (0, 4)
        The fourth is 0 for points without colour.
    view_count : int
    """

    points: Floats
    normals: Floats32
    weights: Floats32
    views: Ints
    colors: Bytes
    view_count: int


class Reach(NamedTuple):
    """
    How far around a place points count, in the units of the points.

    Parameters
    ----------
    radius : float
        Across the normal, and along it.
    near : float
        Across: a view with a point so near saw the place.
    paint : float
        Across: so near colours mix.
    """

    radius: float
    near: float
    paint: float


class Agreed(NamedTuple):
    """
    What the points around each of M places agree on.

    Parameters
    ----------
    points : (M, 3) float64
    normals : (M, 3) float32
        Unit.
    weights : (M,) float32
        Sum over the views of their points' mean weight there.
    views : (M,) int32
        The view that weighs most; -1 where no point is near.
    directions : (M,) int32
        How many views saw the place.
    support : (M,) int32
        How many points are around.
    colors : (M, 3) uint8
        Zeros where no point around has a colour.
    """

    points: Floats
    normals: Floats32
    weights: Floats32
    views: Ints
    directions: Ints
    support: Ints
    colors: Bytes

    def at(self, rows: NDArray[np.integer]) -> 'Agreed':
        """Return the answers of some places only."""
        return Agreed(
            self.points[rows], self.normals[rows], self.weights[rows], self.views[rows],
            self.directions[rows], self.support[rows], self.colors[rows])


def agree(
    samples: Samples, targets: Ints, reach: Reach, *, move: bool = True, threads: int = 0
) -> Agreed:
    """
    Ask the points around each target where the surface is (Levin 2003: moving least squares).

    A target moves along its normal to the height that the points around it have in the weighted
    mean, after a line was fitted to how the heights change sideways. The height of a point is
    taken along the mean of its normal and the target's, so that curved surfaces neither shrink nor
    swell (Rusinkiewicz 2019). Only points that face the same way count: thin parts keep two sides.

    Parameters
    ----------
    samples : Samples
    targets : (M,) int32
        Which of the samples are asked for.
    reach : Reach
    move : bool
        Whether targets move; otherwise they stay, normals too.
    threads : int
        0 takes all cores; no influence on the result.

    Raises
    ------
    ShapeError
        If arrays do not fit together or a number is out of its range.
    """
    _check_samples(samples)
    _check_reach(reach)
    if len(targets) and not (0 <= targets.min() and targets.max() < len(samples.points)):
        raise ShapeError(f'targets: expected indices below {len(samples.points)}')
    return Agreed(*_kernels.agree(
        np.ascontiguousarray(samples.points, np.float64),
        np.ascontiguousarray(samples.normals, np.float32),
        np.ascontiguousarray(samples.weights, np.float32),
        np.ascontiguousarray(samples.views, np.int32),
        np.ascontiguousarray(samples.colors, np.uint8),
        np.ascontiguousarray(targets, np.int32), samples.view_count, *reach, move, threads))


def spread(points: Floats, normals: Floats32, order: Ints, spacing: float) -> Ints:
    """
    Choose points so that none is nearer than `spacing` to another that faces the same way.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float32
    order : (N,) int32
        A permutation: those that come first are chosen first.
    spacing : float
        Above 0.

    Returns
    -------
    (M,) int32
        Indices of those chosen, ascending.

    Raises
    ------
    ShapeError
        If arrays do not fit together, or `spacing` is not above 0.
    """
    _check_oriented(points, normals)
    if order.shape != points.shape[:1] or not np.array_equal(
            np.bincount(order, minlength=len(points)), np.ones(len(points), np.intp)):
        raise ShapeError(f'order: expected a permutation of {len(points)}, got {order.shape}')
    if not 0 < spacing < np.inf:
        raise ShapeError(f'spacing: must be above 0, got {spacing}')
    chosen: Ints = _kernels.spread(
        np.ascontiguousarray(points, np.float64), np.ascontiguousarray(normals, np.float32),
        np.ascontiguousarray(order, np.int32), spacing)
    return chosen


def heaviest(points: Floats, normals: Floats32, weights: Floats32, side: float) -> Ints:
    """
    Choose the heaviest point of each cubic cell, for each of the six ways that points face.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float32
    weights : (N,) float32
    side : float
        Of a cell.

    Returns
    -------
    (M,) int32
        Indices of those chosen, ascending.

    Raises
    ------
    ShapeError
        If arrays do not fit together, or `side` is not above 0.
    """
    _check_oriented(points, normals)
    if weights.shape != points.shape[:1]:
        raise ShapeError(f'weights: expected ({len(points)},), got {weights.shape}')
    if not 0 < side < np.inf:
        raise ShapeError(f'side: must be above 0, got {side}')
    chosen: Ints = _kernels.heaviest(
        np.ascontiguousarray(points, np.float64), np.ascontiguousarray(normals, np.float32),
        np.ascontiguousarray(weights, np.float32), side)
    return chosen


def dents(vertices: Floats, faces: Ints, normals: Floats) -> Floats32:
    """
    Return how far each vertex lies below its neighbours' mean along its normal, (N,).

    Parameters
    ----------
    vertices : (N, 3) float64
    faces : (F, 3) int32
    normals : (N, 3) float64

    Returns
    -------
    (N,) float32
        NaN for vertices without a face.

    Raises
    ------
    ShapeError
        If arrays do not fit together.
    """
    _check_oriented(vertices, normals)
    _check_faces(faces, len(vertices))
    heights: Floats32 = _kernels.dents(
        np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.int32),
        np.ascontiguousarray(normals, np.float64))
    return heights


def piece_sizes(faces: Ints, count: int) -> Ints:
    """
    Return how many vertices hang together with each of `count` vertices by faces, (N,).

    Parameters
    ----------
    faces : (F, 3) int32
    count : int

    Returns
    -------
    (N,) int32
        0 for vertices without a face.

    Raises
    ------
    ShapeError
        If a face names no vertex.
    """
    _check_faces(faces, count)
    sizes: Ints = _kernels.piece_sizes(np.ascontiguousarray(faces, np.int32), count)
    return sizes


def _check_oriented(points: Floats, normals: NDArray[np.floating]) -> None:
    if points.ndim != 2 or points.shape[1] != 3 or normals.shape != points.shape:
        raise ShapeError(f'points, normals: expected (N, 3), got {points.shape}, {normals.shape}')


def _check_faces(faces: Ints, count: int) -> None:
    if faces.ndim != 2 or faces.shape[1] != 3 or (
            faces.size and not (0 <= faces.min() and faces.max() < count)):
        raise ShapeError(f'faces: expected (F, 3) indices below {count}')


def _check_samples(samples: Samples) -> None:
    count = len(samples.points)
    _check_oriented(samples.points, samples.normals)
    if samples.weights.shape != (count,) or samples.views.shape != (count,):
        raise ShapeError(f'weights, views: expected ({count},), got {samples.weights.shape}, '
                         f'{samples.views.shape}')
    if samples.colors.shape not in ((count, 4), (0, 4)):
        raise ShapeError(f'colors: expected ({count}, 4) or (0, 4), got {samples.colors.shape}')
    if count and not (0 <= samples.views.min() and samples.views.max() < samples.view_count):
        raise ShapeError(f'views: expected numbers below {samples.view_count}')


def _check_reach(reach: Reach) -> None:
    if not all(0 < length < np.inf for length in reach):
        raise ShapeError(f'reach: all must be above 0, got {tuple(reach)}')
