# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fine pairwise registration: variants of ICP (Guo et al. 2014, III-D)."""

from dataclasses import dataclass
import math

import numpy as np
from ros_rops.core.config import IcpConfig
from ros_rops.core.errors import ParameterError, ShapeError
from ros_rops.core.se3 import fit_rigid, move, rigid
from ros_rops.core.types import Floats
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

# Pairs below which a rigid motion is not determined: by points, by planes.
_FEWEST_POINTS, _FEWEST_PLANES = 3, 6
# A motion whose share of the stiffness is below this is not held by the planes: not made.
_STIFFNESS = 1e-8


@dataclass(frozen=True, slots=True)
class IcpResult:
    """
    What a fine registration came to.

    Parameters
    ----------
    T_target_source : (4, 4) float64
        The last transform reached; the start where `pairs` are too few to move it.
    residual_mr : float
        Mean distance of the pairs (to the plane for `point_to_plane_icp`) at that transform, in
        mesh resolutions; infinite without pairs.
    iterations : int
        Steps made.
    converged : bool
        The last step, or the last two together, moved the sample by less than the tolerance.
    pairs : int
        Pairs of the last sample within the rejection distance.
    """

    T_target_source: Floats
    residual_mr: float
    iterations: int
    converged: bool
    pairs: int


def paper_icp(
    source_points: Floats,
    target_points: Floats,
    T_target_source: Floats,
    resolution: float,
    config: IcpConfig,
    *,
    tree: cKDTree | None = None,
) -> IcpResult:
    """
    Refine a transform by the paper's variant of ICP: point to point, growing samples (III-D).

    Parameters
    ----------
    source_points : (N, 3) float64
    target_points : (P, 3) float64
    T_target_source : (4, 4) float64
        Where to start.
    resolution : float
        `dres`, in the points' units.
    config : IcpConfig
        The sample of an iteration is the first `sample_size` points (eq. 8) of one random order
        of all, and never smaller than the one before.
    tree : cKDTree, optional
        Of `target_points`, if there is one already.

    Returns
    -------
    IcpResult

    Raises
    ------
    ShapeError
        If an array has the wrong shape.
    ParameterError
        If `resolution` is not positive.
    """
    return _icp(
        source_points, target_points, None, T_target_source, resolution, config, tree)


def point_to_plane_icp(
    source_points: Floats,
    target_points: Floats,
    target_normals: Floats,
    T_target_source: Floats,
    resolution: float,
    config: IcpConfig,
    *,
    tree: cKDTree | None = None,
) -> IcpResult:
    """
    Refine a transform by the distances to the target's tangent planes (Chen and Medioni 1992).

    Samples and rejection as in `paper_icp`. Motions that the planes do not hold (along a plane,
    about a sphere's centre) are not made.

    Parameters
    ----------
    source_points : (N, 3) float64
    target_points : (P, 3) float64
    target_normals : (P, 3) float64
        Unit; points with a normal of zeros take no part.
    T_target_source : (4, 4) float64
        Where to start.
    resolution : float
        `dres`, in the points' units.
    config : IcpConfig
    tree : cKDTree, optional
        Of `target_points`, if there is one already.

    Returns
    -------
    IcpResult

    Raises
    ------
    ShapeError
        If an array has the wrong shape.
    ParameterError
        If `resolution` is not positive.
    """
    if target_normals.shape != target_points.shape:
        raise ShapeError(
            f'target_normals: expected {target_points.shape}, got {target_normals.shape}')
    return _icp(
        source_points, target_points, target_normals, T_target_source, resolution, config, tree)


def sample_size(residual_mr: float, config: IcpConfig) -> int:
    """
    Return how many points to sample (eq. 8).

    n_m = -1/2 log(eps_{m-1} / dres) (n_max - n_min) + n_min, kept between the two. The logarithm
    is the natural one: n_max then belongs to a residual of e^-2 = 0.14 dres, about what range
    scans leave; with base 10 it would take 0.01 dres, which none reaches.

    Parameters
    ----------
    residual_mr : float
        eps_{m-1} / dres, 0 or more.
    config : IcpConfig
    """
    if residual_mr <= 0:
        return config.n_max
    grown = -0.5 * math.log(residual_mr) * (config.n_max - config.n_min) + config.n_min
    return round(min(max(grown, config.n_min), config.n_max))


@dataclass(frozen=True, slots=True)
class _Pairs:
    """Sampled points as moved and, for the planes with `normals`, the points nearest to them."""

    moved: Floats
    target: Floats
    normals: Floats | None

    @property
    def residual(self) -> float:
        """Mean distance of the pairs, infinite without any."""
        if not len(self.moved):
            return math.inf
        gap = self.moved - self.target
        if self.normals is None:
            return float(np.linalg.norm(gap, axis=1).mean())
        return float(np.abs(np.einsum('ij,ij->i', gap, self.normals)).mean())


@dataclass(frozen=True, slots=True)
class _Search:
    """Source points in the random order of the samples, and the target to search."""

    source: Floats
    target: Floats
    normals: Floats | None
    tree: cKDTree
    reject: float

    def pairs(self, transform: Floats, size: int) -> _Pairs:
        """Pair the first `size` points with their nearest, as moved by `transform`."""
        moved = move(transform, self.source[:size])
        if not len(self.target):
            return _Pairs(moved[:0], moved[:0], self.normals)
        distance, nearest = self.tree.query(moved, distance_upper_bound=self.reject)
        near = np.flatnonzero(distance < self.reject)
        moved, nearest = moved[near], nearest[near]
        if self.normals is None:
            return _Pairs(moved, self.target[nearest], None)
        known = self.normals[nearest].any(axis=1)
        moved, nearest = moved[known], nearest[known]
        return _Pairs(moved, self.target[nearest], self.normals[nearest])


def _icp(
    source: Floats, target: Floats, normals: Floats | None, start: Floats, resolution: float,
    config: IcpConfig, tree: cKDTree | None,
) -> IcpResult:
    _check(source, target, start, resolution)
    order = np.random.default_rng(config.seed).permutation(len(source))[:config.n_max]
    search = _Search(
        source[order], target, normals, cKDTree(target) if tree is None else tree,
        config.reject_mr * resolution)
    transform, converged, count = start.astype(np.float64), False, 0
    # Nothing is known of the residual yet: it counts as large.
    size, last = config.n_min, None
    pairs = search.pairs(transform, size)
    while count < config.iterations and not converged:
        motion = _step(pairs)
        if motion is None:
            break
        transform, count = motion @ transform, count + 1
        # A few matches that flip to and fro make it swing between two poses for ever.
        steps = [motion] if last is None else [motion, motion @ last]
        shift = min(_size(move(step, pairs.moved) - pairs.moved) for step in steps)
        converged, last = shift <= config.tolerance_mr * resolution, motion
        # Never fewer than before: samples that come and go would keep it swinging.
        size = max(size, sample_size(pairs.residual / resolution, config))
        pairs = search.pairs(transform, size)
    return IcpResult(transform, pairs.residual / resolution, count, converged, len(pairs.moved))


def _size(vectors: Floats) -> float:
    """Return the root mean square length of vectors (N, 3)."""
    return math.sqrt(np.einsum('ij,ij->', vectors, vectors) / len(vectors))


def _step(pairs: _Pairs) -> Floats | None:
    """Return the motion (4, 4) that brings the pairs together, None where they hold none."""
    fewest = _FEWEST_POINTS if pairs.normals is None else _FEWEST_PLANES
    if len(pairs.moved) < fewest:
        return None
    # About a near origin: far ones cost digits.
    centre = pairs.moved.mean(axis=0)
    moved, target = pairs.moved - centre, pairs.target - centre
    motion = _to_points(moved, target) if pairs.normals is None else _to_planes(
        moved, target, pairs.normals)
    if motion is not None:
        motion[:3, 3] += centre - motion[:3, :3] @ centre
    return motion


def _to_points(moved: Floats, target: Floats) -> Floats | None:
    motions, determined = fit_rigid(
        np.array([float(len(moved))]), moved.sum(axis=0)[None], target.sum(axis=0)[None],
        np.einsum('ni,nj->ij', target, moved)[None])
    return motions[0] if determined[0] else None


def _to_planes(moved: Floats, target: Floats, normals: Floats) -> Floats | None:
    """Solve for the small motion, lengths in units of the sample's size; None if it has none."""
    unit = _size(moved)
    if unit == 0:
        return None
    rows = np.concatenate([np.cross(moved / unit, normals), normals], axis=1)
    gaps = np.einsum('ij,ij->i', target - moved, normals) / unit
    # einsum: the sums of a BLAS product depend on its threads.
    values, vectors = np.linalg.eigh(np.einsum('ni,nj->ij', rows, rows))
    held = values > _STIFFNESS * values[-1]
    vectors = vectors[:, held]
    pull = np.einsum('ni,n->i', rows, gaps)
    motion = vectors @ ((vectors.T @ pull) / values[held])
    return rigid(Rotation.from_rotvec(motion[:3]).as_matrix(), motion[3:] * unit)


def _check(source: Floats, target: Floats, start: Floats, resolution: float) -> None:
    for name, points in (('source_points', source), ('target_points', target)):
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError(f'{name}: expected (N, 3), got {points.shape}')
    if start.shape != (4, 4):
        raise ShapeError(f'T_target_source: expected (4, 4), got {start.shape}')
    if not (math.isfinite(resolution) and resolution > 0):
        raise ParameterError(f'resolution: expected a length above 0, got {resolution!r}')
