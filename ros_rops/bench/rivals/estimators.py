# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Rivals of CCV (Guo et al. 2014, V-A1): least squares, RANSAC and its one-match variant.

All take the same matches and, but for least squares, judge a pose as CCV does: by the points of
the simplified source that it brings within `ccv.inlier_mr` of the simplified target.
"""

from dataclasses import dataclass

import numpy as np
from ros_rops.bench.rivals.estimator import Estimator
from ros_rops.core.ccv import best_by_count, count_inliers
from ros_rops.core.config import CcvConfig, Config
from ros_rops.core.hypotheses import consistent, Matched
from ros_rops.core.se3 import fit_rigid, move
from ros_rops.core.simplify import simplify
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Ints
from scipy.spatial import cKDTree

ITERATIONS = (500, 1000, 5000, 10000)
# Matches drawn in an iteration of RANSAC.
DRAWN = 3
# Single matches tried at most, as many as the longest RANSAC has iterations.
SINGLES = 10000
# Rounds of refinement with the inliers; in practice five do.
ROUNDS = 30


@dataclass(frozen=True, slots=True)
class Simplified:
    """The simplified surfaces (III-C), and how near an inlier is."""

    source: Floats
    target: Floats
    radius: float
    threads: int = 1

    @classmethod
    def of(cls, source: Surface, target: Surface, config: CcvConfig) -> 'Simplified':
        """Simplify both sides as `core.paper_pairwise` does."""
        unit = 0.5 * (source.resolution + target.resolution)
        cell = config.simplify_mr * unit
        return cls(
            simplify(source.evidence.vertices().points, cell),
            simplify(target.evidence.vertices().points, cell), config.inlier_mr * unit)

    def count(self, transforms: Floats) -> Ints:
        """Count the inliers (M,) of transforms (M, 4, 4)."""
        return count_inliers(
            self.source, self.target, transforms, self.radius, threads=self.threads)

    def refit(self, transform: Floats) -> Floats | None:
        """Fit a transform to its inlier point pairs; None where these leave it open."""
        distance, nearest = cKDTree(self.target).query(
            move(transform, self.source), distance_upper_bound=self.radius)
        near = distance < self.radius
        return fit(self.source[near], self.target[nearest[near]])


def fit(source: Floats, target: Floats) -> Floats | None:
    """Fit a rigid transform to matched points (N, 3) by least squares, None if undetermined."""
    transforms, determined = _fit_sets(source[None], target[None])
    return transforms[0] if determined[0] else None


def _fit_sets(source: Floats, target: Floats) -> tuple[Floats, np.ndarray]:
    """Fit a transform to each set of matched points (M, N, 3)."""
    many, count = source.shape[:2]
    if count < DRAWN:
        return np.zeros((many, 4, 4)), np.zeros(many, dtype=bool)
    # About near origins: far ones cost digits.
    near, there = source.mean(axis=1, keepdims=True), target.mean(axis=1, keepdims=True)
    p, q = source - near, target - there
    fitted, determined = fit_rigid(
        np.full(many, float(count)), p.sum(axis=1), q.sum(axis=1),
        np.einsum('mni,mnj->mij', q, p))
    fitted[:, :3, 3] += there[:, 0] - np.einsum('mij,mj->mi', fitted[:, :3, :3], near[:, 0])
    return fitted, determined


def matched_points(source: Surface, target: Surface, pairs: Matched) -> tuple[Floats, Floats]:
    """Return the positions of the matched features, (M, 3) each."""
    return (
        source.features.positions[pairs.matches.source],
        target.features.positions[pairs.matches.target])


def least_squares(
    source: Surface, target: Surface, pairs: Matched, config: Config, rng: np.random.Generator
) -> Floats | None:
    """Fit one transform to all matches (LSF)."""
    return fit(*matched_points(source, target, pairs))


def draw(count: int, iterations: int, rng: np.random.Generator) -> Ints:
    """Draw rows (iterations, 3) of different matches out of `count`, at least 3."""
    first, second, third = (rng.integers(0, count - k, iterations) for k in range(DRAWN))
    second = second + (second >= first)
    low, high = np.minimum(first, second), np.maximum(first, second)
    third = third + (third >= low)
    third = third + (third >= high)
    return np.stack([first, second, third], axis=1)


def ransac(
    source: Surface, target: Surface, pairs: Matched, config: Config, rng: np.random.Generator,
    iterations: int,
) -> Floats | None:
    """
    Fit a transform to three matches at random, many times; refine the best with its inliers.

    As V-A1 describes it: the most inliers win, the earlier one of equals.
    """
    if len(pairs.matches) < DRAWN:
        return None
    p, q = matched_points(source, target, pairs)
    rows = draw(len(p), iterations, rng)
    transforms, determined = _fit_sets(p[rows], q[rows])
    transforms = transforms[determined]
    surfaces = Simplified.of(source, target, config.ccv)
    best = best_by_count(surfaces.count(transforms), np.zeros(len(transforms), np.int32))
    if best is None:
        return None
    refined = surfaces.refit(transforms[best])
    return transforms[best] if refined is None else refined


def one_match(
    source: Surface, target: Surface, pairs: Matched, config: Config, rng: np.random.Generator
) -> Floats | None:
    """
    Take every match's own pose for a sample; refine the best with its inliers while they grow.

    Stands for the variant of Masuda 2009; see `MASUDA`.
    """
    transforms = pairs.transforms
    if len(transforms) > SINGLES:
        transforms = transforms[rng.choice(len(transforms), SINGLES, replace=False)]
    surfaces = Simplified.of(source, target, config.ccv)
    counts = surfaces.count(transforms)
    best = best_by_count(counts, np.zeros(len(counts), np.int32))
    if best is None:
        return None
    pose, most = transforms[best], int(counts[best])
    for _ in range(ROUNDS):
        refined = surfaces.refit(pose)
        count = 0 if refined is None else int(surfaces.count(refined[None])[0])
        if refined is None or count <= most:
            break
        pose, most = refined, count
    return pose


def ccv(
    source: Surface, target: Surface, pairs: Matched, config: Config, rng: np.random.Generator
) -> Floats | None:
    """Return the pose of the group of consistent matches with the most inliers (III-C)."""
    return _best_group(source, target, pairs, config)[0]


def ccv_refit(
    source: Surface, target: Surface, pairs: Matched, config: Config, rng: np.random.Generator
) -> Floats | None:
    """Refine the pose of CCV with its inliers once, as `ransac` does its own."""
    pose, surfaces = _best_group(source, target, pairs, config)
    if pose is None:
        return None
    refined = surfaces.refit(pose)
    return pose if refined is None else refined


def _best_group(
    source: Surface, target: Surface, pairs: Matched, config: Config
) -> tuple[Floats | None, Simplified]:
    groups = consistent(source, target, pairs, config.ccv)
    surfaces = Simplified.of(source, target, config.ccv)
    best = best_by_count(surfaces.count(groups.transforms), groups.support)
    return (None if best is None else groups.transforms[best]), surfaces


def _ransac_of(iterations: int) -> Estimator:
    return Estimator(
        f'RANSAC-{iterations}', 'Fischler and Bolles 1981, as Guo et al. 2014 use it (V-A1)',
        lambda source, target, pairs, config, rng: ransac(
            source, target, pairs, config, rng, iterations))


LSF = Estimator('LSF', 'Guo et al. 2014, V-A1', least_squares)
RANSACS = tuple(_ransac_of(iterations) for iterations in ITERATIONS)
# The article could not be had: Guo et al. say no more than that it is a variant of RANSAC and
# that its parameters were taken. Its title says that features are height maps on the tangent
# plane in log-polar coordinates; matched with their angle, one such pair fixes a pose. So does a
# pair of ours by its frames. What was built on that is the strongest form of the idea: every
# match is tried, and the best refined until its inliers stop growing.
MASUDA = Estimator(
    'RANSAC [17]', 'after Masuda 2009 (CVIU 113(11)), the article itself not seen', one_match)
CCV = Estimator('CCV', 'Guo et al. 2014, III-C', ccv)
# V-A1 may be read so that the best pose of CCV is refined as RANSAC's is; III-C has no such step.
CCV_REFIT = Estimator('CCV, refit', 'Guo et al. 2014, III-C and V-A1', ccv_refit)

ESTIMATORS: tuple[Estimator, ...] = (CCV, CCV_REFIT, LSF, *RANSACS, MASUDA)
