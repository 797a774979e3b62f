# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Multi-view fine registration: all views of a shape together (Guo et al. 2014, IV-B).

`simultaneous` minimises the symmetric point-to-plane distance between all overlapping views at
once by Gauss-Newton; `williams` is the paper's choice, the registration of corresponding point
sets (Williams and Bennamoun 2001). Matches are renewed in every round. The first view of each
connected group of views keeps its pose: the common frame stays where it was.
"""

from collections.abc import Sequence
import math

import numpy as np
from ros_rops.core.config import FineConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.fine_pairs import pairs_to_match
from ros_rops.core.fine_prior import FinePrior
from ros_rops.core.fine_problem import Problem
from ros_rops.core.fine_report import ratio, report
from ros_rops.core.fine_types import EdgeFit, FineResult, FineView, ViewFit
from ros_rops.core.types import Floats
from ros_rops.kernels.fine import PairSums

__all__ = ['EdgeFit', 'FineResult', 'FineView', 'ViewFit', 'refine_shape']

# From one round to the next the radius shrinks to this share at most, so that views that start
# farther off than the others are not left behind.
SHRINK = 0.5
# The poses have settled for the few samples: time for the many.
SETTLED_MR = 0.05
# Distances below this multiple of the mean residual weigh as squares (efficient under noise),
# larger ones as absolute values (robust).
SOFT = 1.5


def refine_shape(
    views: Sequence[FineView],
    poses: Sequence[Floats],
    resolution: float,
    config: FineConfig,
    *,
    threads: int = 0,
    prior: FinePrior | None = None,
) -> FineResult:
    """
    Refine the poses of all views of a shape together (IV-B).

    Parameters
    ----------
    views : sequence of FineView
    poses : sequence of (4, 4) float64
        `T_object_view` of each view, good to about `radius_start_mr`.
    resolution : float
        Mesh resolution of the shape, in the units of the points.
    config : FineConfig
    threads : int
        0: as many as the machine has. The result is the same, byte for byte, for any number.
    prior : FinePrior, optional
        What the station knows (method `simultaneous` only).

    Returns
    -------
    FineResult
        Views that nothing holds (no overlap, or along an unconstrained motion) keep their
        poses and are reported so.

    Raises
    ------
    ShapeError
        If there is no view, the poses are not rigid or not one for each view, or the
        resolution is not a positive length.
    """
    start = _checked(views, poses, resolution)
    problem = Problem(views, start, resolution, config, threads, prior)
    problem.pairs = pairs_to_match(
        *problem.placed_samples(), float(np.median(problem.sizes)), config.partners)
    radius, mean, iterations, converged = _rounds(problem)
    problem.put_back()
    return report(problem, radius, mean, iterations, converged)


def _rounds(problem: Problem) -> tuple[float, float, int, bool]:
    """Run the rounds; return last radius and mean residual (mr), their number, convergence."""
    config = problem.config
    radius, mean = max(config.radius_start_mr, config.radius_mr), math.nan
    samples, soft = problem.few, radius
    for done in range(config.iterations):
        sums = problem.sums(samples, radius, soft)
        if done == 0:
            sums = _drop_far_pairs(problem, sums)
        mean = ratio(sums.absolute.sum(), sums.used.sum() * problem.resolution)
        moved = problem.step(sums, samples, radius)
        wanted = max(config.radius_mr, config.noise_factor * (0.0 if math.isnan(mean) else mean))
        shrunk = min(radius, max(wanted, SHRINK * radius))
        settled = shrunk > 0.9 * radius
        if settled and samples is problem.many and moved <= config.tolerance_mr:
            return radius, mean, done + 1, True
        if settled and moved <= SETTLED_MR:
            samples = problem.many
        radius, soft = shrunk, SOFT * max(0.0 if math.isnan(mean) else mean, 1e-3)
    return radius, mean, config.iterations, False


def _drop_far_pairs(problem: Problem, sums: PairSums) -> PairSums:
    """Forget the pairs of views that are nowhere near each other."""
    close = problem.both_ways(sums.near) > 0
    problem.pairs = problem.pairs[close]
    return PairSums(*(part[close] for part in sums))


def _checked(views: Sequence[FineView], poses: Sequence[Floats], resolution: float) -> Floats:
    if len(views) == 0 or len(views) != len(poses):
        raise ShapeError(
            f'poses: expected one for each of at least one view, '
            f'got {len(poses)} for {len(views)}')
    if not (math.isfinite(resolution) and resolution > 0):
        raise ShapeError(f'resolution: expected a positive length, got {resolution!r}')
    for index, pose in enumerate(poses):
        if np.shape(pose) != (4, 4) or not np.isfinite(pose).all():
            raise ShapeError(f'poses[{index}]: expected a finite (4, 4), got {np.shape(pose)}')
        turn = np.asarray(pose)[:3, :3]
        if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-3 or np.linalg.det(turn) < 0:
            raise ShapeError(f'poses[{index}]: not a rigid transform')
    return np.array(poses, dtype=np.float64)
