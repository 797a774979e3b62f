# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Consistent correspondences verification (Guo et al. 2014, III-C)."""

from collections.abc import Iterator
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.config import CcvConfig
from ros_rops.core.errors import ParameterError, ShapeError
from ros_rops.core.se3 import fit_rigid, nearest_rotations, rigid
from ros_rops.core.types import Floats, frozen, Ints
from ros_rops.kernels.inliers import count_near
from scipy.sparse import csr_array
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

# Pairs of transforms compared at once, at most; bounds the memory when all are alike.
_PAIRS = 1 << 19
# Members of a group that is fitted rather than averaged.
_FITTED = 3


@dataclass(frozen=True, slots=True)
class CcvGroups:
    """
    The plausible transform of every match, from its group of consistent matches.

    Parameters
    ----------
    transforms : (M, 4, 4) float64
        `T_target_source`.
    support : (M,) int32
        Members of the group, the match itself included.
    """

    transforms: Floats
    support: Ints


def ccv_transforms(
    source_positions: Floats,
    target_positions: Floats,
    transforms: Floats,
    config: CcvConfig,
    resolution: float,
    centre: Floats,
) -> CcvGroups:
    """
    Group consistent matches and estimate a plausible transform from each group (III-C).

    Groups of three or more are fitted to their matched points by least squares; smaller ones,
    and those whose points leave the rotation open (coincident, on a line), are averaged.

    Parameters
    ----------
    source_positions, target_positions : (M, 3) float64
        The matched features, each in its view's frame.
    transforms : (M, 4, 4) float64
        `T_target_source` of every match alone.
    config : CcvConfig
        Metric `euler` (the paper) compares angles about x, y and z as they are, without wrapping,
        and translation vectors; `so3` the angle between rotations and where they take `centre`.
    resolution : float
        What `mr` means, in the views' units.
    centre : (3,) float64
        Centroid of the source view, in its frame (metric `so3` only).

    Returns
    -------
    CcvGroups
        In the order of the matches.

    Raises
    ------
    ShapeError
        If the arrays do not fit together.
    ParameterError
        If `resolution` is not positive.
    """
    _check(source_positions, target_positions, transforms, centre)
    _check_length('resolution', resolution)
    euler = config.metric == 'euler'
    about = np.zeros(3) if euler else np.asarray(centre, dtype=np.float64)
    places = np.einsum('mij,j->mi', transforms[:, :3, :3], about) + transforms[:, :3, 3]
    result, support = transforms.copy(), np.ones(len(transforms), dtype=np.int32)
    if not len(transforms):
        return CcvGroups(frozen(result, np.float64), frozen(support, np.int32))
    # About a near origin: far ones cost digits.
    near, there = source_positions.mean(axis=0), target_positions.mean(axis=0)
    sums = _columns(source_positions - near, target_positions - there, transforms, places)
    for rows, members in _groups(transforms, places, config, config.distance_mr * resolution):
        size = np.diff(members.indptr)
        support[rows] = size
        result[rows[size > 1]] = _estimate(members[size > 1] @ sums, near, there, about)
    return CcvGroups(frozen(result, np.float64), frozen(support, np.int32))


def count_inliers(
    source: Floats, target: Floats, transforms: Floats, radius: float, *, threads: int = 1
) -> Ints:
    """
    Count the source points that each transform takes near the target.

    Parameters
    ----------
    source : (N, 3) float64
        The simplified source view (`ros_rops.core.simplify.simplify`).
    target : (P, 3) float64
        The simplified target view.
    transforms : (M, 4, 4) float64
        `T_target_source`.
    radius : float
        An inlier is nearer than this, in the views' units (the paper: 2 dres).
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    (M,) int32

    Raises
    ------
    ParameterError
        If `radius` is not positive.
    """
    return count_near(source, target, transforms, radius, threads=threads)


def best_by_count(counts: Ints, support: Ints) -> int | None:
    """
    Choose the transform with the most inliers.

    Parameters
    ----------
    counts : (M,) int32
        From `count_inliers`.
    support : (M,) int32
        Of the groups; decides between equal counts, then the earlier one wins.

    Returns
    -------
    int or None
        None where there is no transform or none has an inlier.
    """
    if not len(counts) or counts.max() <= 0:
        return None
    return int(np.lexsort((-support, -counts))[0])


def euler_angles(rotations: Floats) -> Floats:
    """Return the angles (M, 3) about x, then y, then z (fixed axes) of rotations (M, 3, 3)."""
    return np.stack([
        np.arctan2(rotations[:, 2, 1], rotations[:, 2, 2]),
        np.arcsin(np.clip(-rotations[:, 2, 0], -1.0, 1.0)),
        np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0]),
    ], axis=1)


def _groups(
    transforms: Floats, places: Floats, config: CcvConfig, distance: float
) -> Iterator[tuple[Ints, csr_array]]:
    """
    Yield rows and, as a sparse 0-1 matrix, which transforms belong to the group of each.

    Few transforms share a rotation, so the search goes by that and then looks at the places.
    """
    count = len(transforms)
    if config.metric == 'euler':
        keys, limit = euler_angles(transforms[:, :3, :3]), config.angle_rad
        tree = cKDTree(keys)
    else:
        keys = Rotation.from_matrix(transforms[:, :3, :3]).as_quat()
        # A rotation is two unit quaternions; the nearer ones are 2 sin(angle / 4) apart.
        tree, limit = cKDTree(np.concatenate([keys, -keys])), 2 * math.sin(config.angle_rad / 4)
    limit = float(np.nextafter(limit, 0))  # the search includes its limit
    order = tree.indices[tree.indices < count]
    size = max(_PAIRS // count, 1)
    for start in range(0, count, size):
        rows = order[start:start + size]
        found = cKDTree(keys[rows]).sparse_distance_matrix(tree, limit, output_type='ndarray')
        row, column = found['i'], found['j'] % count
        gap = places[rows[row]] - places[column]
        near = np.einsum('ij,ij->i', gap, gap) < distance ** 2
        row, column = row[near], column[near]
        yield rows, csr_array((np.ones(len(row)), (row, column)), shape=(len(rows), count))


def _columns(source: Floats, target: Floats, transforms: Floats, places: Floats) -> Floats:
    """Return what is summed over a group, (M, 28), in the order that `_estimate` reads."""
    count = len(source)
    product = target[:, :, None] * source[:, None, :]
    return np.concatenate([
        np.ones((count, 1)), source, target, product.reshape(count, 9),
        transforms[:, :3, :3].reshape(count, 9), places], axis=1)


def _estimate(sums: Floats, near: Floats, there: Floats, about: Floats) -> Floats:
    """Return the transforms of groups from their sums (G, 28)."""
    count = sums[:, 0]
    fitted, determined = fit_rigid(
        count, sums[:, 1:4], sums[:, 4:7], sums[:, 7:16].reshape(-1, 3, 3))
    fitted[:, :3, 3] += there - fitted[:, :3, :3] @ near
    turn, _ = nearest_rotations(sums[:, 16:25].reshape(-1, 3, 3))
    mean = rigid(turn, sums[:, 25:] / count[:, None] - turn @ about)
    chosen: NDArray = (determined & (count >= _FITTED))[:, None, None]
    return np.where(chosen, fitted, mean)


def _check(source: Floats, target: Floats, transforms: Floats, centre: Floats) -> None:
    count = len(transforms)
    if transforms.shape != (count, 4, 4):
        raise ShapeError(f'transforms: expected (M, 4, 4), got {transforms.shape}')
    if source.shape != (count, 3) or target.shape != (count, 3):
        raise ShapeError(
            f'source_positions, target_positions: expected ({count}, 3), '
            f'got {source.shape}, {target.shape}')
    if np.shape(centre) != (3,):
        raise ShapeError(f'centre: expected (3,), got {np.shape(centre)}')


def _check_length(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ParameterError(f'{name}: expected a length above 0, got {value!r}')
