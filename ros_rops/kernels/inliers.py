# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the kernel that counts inliers of many poses."""

import math

import numpy as np

from ros_rops.core.errors import ParameterError, ShapeError
from ros_rops.core.types import Floats, Ints
from ros_rops.kernels import _kernels


def count_near(
    source: Floats, target: Floats, transforms: Floats, radius: float, *, threads: int = 0
) -> Ints:
    """
    Count the source points that each transform takes nearer than `radius` to a target point.

    Parameters
    ----------
    source : (N, 3) float64
    target : (P, 3) float64
        Finite.
    transforms : (M, 4, 4) float64
        `T_target_source`; one that is not finite has no inlier.
    radius : float
        In the points' units.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    (M,) int32

    Raises
    ------
    ShapeError
        If an array has the wrong shape, or the target is not finite.
    ParameterError
        If `radius` is not positive.
    """
    for name, points in (('source', source), ('target', target)):
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError(f'{name}: expected (N, 3), got {points.shape}')
    if transforms.ndim != 3 or transforms.shape[1:] != (4, 4):
        raise ShapeError(f'transforms: expected (M, 4, 4), got {transforms.shape}')
    if not np.isfinite(target).all():
        raise ShapeError('target: expected finite points')
    if not (math.isfinite(radius) and radius > 0):
        raise ParameterError(f'radius: expected a length above 0, got {radius!r}')
    if not len(source) or not len(target):
        return np.zeros(len(transforms), np.int32)
    counts: Ints = _kernels._count_near(source, target, transforms, radius, threads)
    return counts
