# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the feature kernels: frames, RoPS, thinning (METHOD 2-4)."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from ros_rops.kernels import _kernels

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Projections:
    """
    How the descriptor looks at a support.

    Parameters
    ----------
    axes : (R,) tuple of int
        Axis of each rotation, 0 x, 1 y, 2 z; equal ones follow each other.
    angles : (R,) tuple of float
        Angle of each rotation in radians: first' = c first + s second, second' = -s first +
        c second, for the two axes that turn in their alphabetical order.
    bins : int
        Bins of a side of the distribution matrix (L).
    log_unit : float
        The entropy in nats is multiplied by this (1 / ln 2 gives bits).
    skip_keypoint : bool
        Leave the keypoint itself out.
    absolute_norm : bool
        Divide by the L1 norm instead of the plain sum.
    """

    axes: tuple[int, ...] = ()
    angles: tuple[float, ...] = ()
    bins: int = 5
    log_unit: float = 1.0
    skip_keypoint: bool = True
    absolute_norm: bool = False


class FeatureArrays(NamedTuple):
    """What `features` returns; see there."""

    lrfs: Floats
    eigenvalues: Floats
    descriptors: NDArray[np.float32]


def _check(condition: bool, text: str) -> None:
    if not condition:
        raise ShapeError(text)


def _check_indices(name: str, indices: Ints, count: int) -> None:
    if indices.size and (indices.min() < 0 or indices.max() >= count):
        raise ShapeError(f'{name}: indices must lie in 0..{count - 1}')


def features(
    vertices: Floats,
    faces: Ints,
    normals: Floats,
    keypoints: Ints,
    radius: float,
    *,
    normal_radius: float = 0.0,
    touching: bool = False,
    loose: bool = False,
    lrfs: Floats | None = None,
    projections: Projections = Projections(),
    threads: int = 0,
) -> FeatureArrays:
    """
    Frames and descriptors of all keypoints, one neighbour search for both.

    Parameters
    ----------
    vertices : (N, 3) float64
    faces : (F, 3) int32
    normals : (N, 3) float64
        Side to which the z axis of a frame by the normal points.
    keypoints : (K,) int32
    radius : float
        Of the support, in the vertices' units.
    normal_radius : float
        0: frames from the covariance of the triangles (METHOD 3); else z is the normal of the
        vertices within this radius and x a weighted projection (TOLDI).
    touching : bool
        Every triangle with a vertex inside counts (PCL), not only those with all three.
    loose : bool
        Vertices without a face belong to supports too.
    lrfs : (K, 3, 3) float64, optional
        Frames to use instead; then no eigenvalues are computed.
    projections : Projections
        No rotations: frames only.
    threads : int
        0 takes all cores. The result does not depend on it, byte for byte.

    Returns
    -------
    FeatureArrays
        `lrfs` (K, 3, 3), `eigenvalues` (K, 3) falling, `descriptors` (K, 15 R). Where a keypoint
        has no frame (no triangle within reach), all three are zero.

    Raises
    ------
    ShapeError
        If an array has the wrong shape or an index lies outside `vertices`.
    """
    _check(vertices.ndim == 2 and vertices.shape[1] == 3,
           f'vertices: expected (N, 3), got {vertices.shape}')
    _check(normals.shape == vertices.shape,
           f'normals: expected {vertices.shape}, got {normals.shape}')
    _check(faces.ndim == 2 and faces.shape[1] == 3, f'faces: expected (F, 3), got {faces.shape}')
    _check(keypoints.ndim == 1, f'keypoints: expected (K,), got {keypoints.shape}')
    _check(lrfs is None or lrfs.shape == (len(keypoints), 3, 3),
           f'lrfs: expected ({len(keypoints)}, 3, 3)')
    _check(len(projections.axes) == len(projections.angles),
           f'projections: {len(projections.axes)} axes, {len(projections.angles)} angles')
    _check(radius > 0, f'radius: must be positive, got {radius}')
    _check_indices('faces', faces, len(vertices))
    _check_indices('keypoints', keypoints, len(vertices))
    return FeatureArrays(*_kernels.features(
        vertices, faces, normals, keypoints, radius, min(normal_radius, radius), touching,
        loose, lrfs,
        np.array(projections.axes, np.int32), np.array(projections.angles, np.float64),
        projections.bins, projections.log_unit, projections.skip_keypoint,
        projections.absolute_norm, threads,
    ))


def thin(points: Floats, candidates: Ints, spacing: float) -> Ints:
    """
    Keep candidates that lie at least `spacing` apart, the earlier ones first (METHOD 2).

    Parameters
    ----------
    points : (N, 3) float64
    candidates : (M,) int32
        Indices of points in order of preference.
    spacing : float
        Positive, in the points' units.

    Returns
    -------
    (K,) int32
        The candidates kept, in their order.

    Raises
    ------
    ShapeError
        If an array has the wrong shape or an index lies outside `points`.
    """
    _check(points.ndim == 2 and points.shape[1] == 3,
           f'points: expected (N, 3), got {points.shape}')
    _check(candidates.ndim == 1, f'candidates: expected (M,), got {candidates.shape}')
    _check(spacing > 0, f'spacing: must be positive, got {spacing}')
    _check_indices('candidates', candidates, len(points))
    kept: Ints = _kernels.thin(points, candidates, spacing)
    return kept
