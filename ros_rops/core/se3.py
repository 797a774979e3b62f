# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid transforms: 4x4, `T_target_source`, p_target = T_target_source p_source."""

import numpy as np
from ros_rops.core.types import Bools, Floats

# Singular values below this share of the largest are rounding: no direction is known there.
_RANK = 1e-9


def rigid(rotations: Floats, translations: Floats) -> Floats:
    """Return the transforms (..., 4, 4) of rotations (..., 3, 3) and translations (..., 3)."""
    result = np.zeros((*rotations.shape[:-2], 4, 4))
    result[..., :3, :3] = rotations
    result[..., :3, 3] = translations
    result[..., 3, 3] = 1.0
    return result


def move(transform: Floats, points: Floats) -> Floats:
    """Return `points` (N, 3) moved by `transform` (4, 4)."""
    moved: Floats = points @ transform[:3, :3].T + transform[:3, 3]
    return moved


def nearest_rotations(matrices: Floats) -> tuple[Floats, Bools]:
    """
    Project matrices on the rotations (Kabsch).

    Parameters
    ----------
    matrices : (M, 3, 3) float64

    Returns
    -------
    rotations : (M, 3, 3) float64
        Those with the greatest trace(R^T A).
    determined : (M,) bool
        False where the matrix has rank below 2 and many rotations are equally near.
    """
    left, values, right = np.linalg.svd(matrices)
    sign = np.where(np.linalg.det(left) * np.linalg.det(right) < 0, -1.0, 1.0)
    left[:, :, 2] *= sign[:, None]
    return left @ right, values[:, 1] > _RANK * values[:, 0]


def fit_rigid(
    count: Floats, source: Floats, target: Floats, product: Floats
) -> tuple[Floats, Bools]:
    """
    Fit rigid transforms to matched points, least squares, many sets at once.

    Parameters
    ----------
    count : (M,) float64
        Matches of each set, at least 1.
    source, target : (M, 3) float64
        Sums of the matched points p and q. Take them about a near origin: the fit subtracts
        their means.
    product : (M, 3, 3) float64
        Sums of q p^T.

    Returns
    -------
    transforms : (M, 4, 4) float64
        `T_target_source`, minimising sum |R p + t - q|^2.
    determined : (M,) bool
        False where the matches coincide or lie on a line, which leaves the rotation open.
    """
    source, target = source / count[:, None], target / count[:, None]
    spread = product / count[:, None, None] - target[:, :, None] * source[:, None, :]
    rotations, determined = nearest_rotations(spread)
    # Points that coincide leave rounding only.
    size = np.sqrt((source ** 2).sum(axis=1) * (target ** 2).sum(axis=1))
    determined &= np.abs(spread).max(axis=(1, 2)) > _RANK * size
    shift = target - np.einsum('mij,mj->mi', rotations, source)
    return rigid(rotations, shift), determined
