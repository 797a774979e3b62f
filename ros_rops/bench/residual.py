# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Residual between overlapping views: judges poses without a reference.

For every ordered pair of views i, j with at least 30% of i's points (every 11th) within 2 dres
of j under the poses judged: the mean |point-to-plane distance| of those points to their nearest
neighbour in j, normals from the neighbours within 5 dres (at most 40); averaged over the pairs,
in dres. The definition knows nothing of how the poses were found, and is kept apart from the
code that finds them: its normals and matches are its own.
"""

from collections.abc import Mapping, Sequence
import itertools

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from scipy.spatial import cKDTree

STRIDE = 11
NEAR_DRES = 2.0
LEAST_SHARE = 0.3
SUPPORT_DRES = 5.0
MOST_NEIGHBOURS = 40

Floats = NDArray[np.float64]


class _Target:
    """A view that others are measured against; normals are made where they are needed."""

    def __init__(self, points: Floats, radius: float) -> None:
        self.points = points
        self.radius = radius
        self.tree = cKDTree(points)
        self.normals = np.zeros_like(points)
        self.known = np.zeros(len(points), dtype=bool)

    def normals_at(self, indices: NDArray[np.intp]) -> Floats:
        missing = np.unique(indices[~self.known[indices]])
        for part in np.array_split(missing, len(missing) // 20000 + 1):
            self.normals[part] = self._fit(part)
        self.known[missing] = True
        normals: Floats = self.normals[indices]
        return normals

    def _fit(self, indices: NDArray[np.intp]) -> Floats:
        if len(indices) == 0:
            return np.zeros((0, 3))
        most = min(MOST_NEIGHBOURS, len(self.points))
        _, found = self.tree.query(
            self.points[indices], k=np.arange(1, most + 1), distance_upper_bound=self.radius)
        inside = found < len(self.points)
        offsets = self.points[np.where(inside, found, 0)] - self.points[indices, None]
        weights = inside[..., None]
        count = np.maximum(weights.sum(1, keepdims=True), 1)
        offsets = (offsets - (offsets * weights).sum(1, keepdims=True) / count) * weights
        _, vectors = np.linalg.eigh(np.einsum('nki,nkj->nij', offsets, offsets))
        smallest: Floats = vectors[:, :, 0]
        return smallest


def pair_residuals(
    points_per_view: Sequence[Floats], poses: Sequence[Floats], dres: float
) -> Mapping[tuple[int, int], float]:
    """
    Return the residual of every ordered pair of views that overlaps enough.

    Parameters
    ----------
    points_per_view : sequence of (N, 3) float64
        All points of each view, in its own frame.
    poses : sequence of (4, 4) float64
        `T_common_view` of each view; the common frame is free.
    dres : float
        Mesh resolution of the set, in the units of the points.

    Returns
    -------
    mapping
        (i, j) to the mean absolute point-to-plane distance of i's points to j, in dres.

    Raises
    ------
    ShapeError
        If the poses are not one (4, 4) for every view, or `dres` is not positive.
    """
    if len(points_per_view) != len(poses) or any(np.shape(t) != (4, 4) for t in poses):
        raise ShapeError(
            f'poses: expected {len(points_per_view)} of shape (4, 4), '
            f'got {[np.shape(t) for t in poses]}')
    if not dres > 0:
        raise ShapeError(f'dres: expected a positive length, got {dres!r}')
    placed = [p @ t[:3, :3].T + t[:3, 3] for p, t in zip(points_per_view, poses, strict=True)]
    targets = [_Target(points, SUPPORT_DRES * dres) for points in placed]
    result: dict[tuple[int, int], float] = {}
    for i, j in itertools.permutations(range(len(placed)), 2):
        value = _pair(placed[i][::STRIDE], targets[j], dres)
        if value is not None:
            result[i, j] = value
    return result


def _pair(points: Floats, target: _Target, dres: float) -> float | None:
    if len(points) == 0 or len(target.points) == 0:
        return None
    distance, found = target.tree.query(points, distance_upper_bound=NEAR_DRES * dres)
    near = np.isfinite(distance)
    if near.mean() < LEAST_SHARE:
        return None
    offsets = points[near] - target.points[found[near]]
    along = np.einsum('nk,nk->n', offsets, target.normals_at(found[near]))
    return float(np.abs(along).mean() / dres)


def residual(points_per_view: Sequence[Floats], poses: Sequence[Floats], dres: float) -> float:
    """
    Return the mean residual between overlapping views, in dres (EVALUATION: Residual).

    Parameters and errors are those of `pair_residuals`; the average is over its pairs. NaN
    where no pair of views overlaps by 30%: there is nothing to measure.
    """
    values = list(pair_residuals(points_per_view, poses, dres).values())
    return float(np.mean(values)) if values else float('nan')
