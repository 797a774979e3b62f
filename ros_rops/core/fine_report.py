# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How refined views fit each other, to find a wrong one and to say what is not held."""

import math

import numpy as np
from ros_rops.core import fine_system
from ros_rops.core.fine_problem import Problem
from ros_rops.core.fine_types import EdgeFit, FineResult, ViewFit
from ros_rops.core.types import Bools, frozen
from ros_rops.kernels.fine import PairSums


def report(
    problem: Problem, radius: float, mean: float, iterations: int, converged: bool
) -> FineResult:
    """Measure the fit within the first radius, on the few samples, and put it all together."""
    wide = max(problem.config.radius_start_mr, problem.config.radius_mr)
    sums = problem.sums(problem.few, wide, wide)
    keep = problem.holding(sums)
    if iterations == 0:
        problem.components = fine_system.components_of(
            len(problem.poses), problem.pairs, keep)
    # Rims within the wide radius of each other do not join what the last round found apart.
    ends = problem.components[problem.pairs]
    keep &= ends[:, 0] == ends[:, 1]
    system = fine_system.assemble(problem.pairs, sums, keep, problem.frames(), problem.centre)
    stiffness = fine_system.stiffness_of(system)
    return FineResult(
        poses=tuple(frozen(pose, np.float64) for pose in problem.poses),
        views=tuple(
            _view_fit(problem, sums, keep, stiffness, v)
            for v in range(len(problem.poses))),
        edges=edges_of(problem, sums, keep),
        residual_mr=mean,
        radius_mr=radius,
        iterations=iterations,
        converged=converged,
    )


def _view_fit(
    problem: Problem, sums: PairSums, keep: Bools, stiffness: fine_system.Stiffness, v: int
) -> ViewFit:
    mine = keep & (problem.pairs == v).any(axis=1)
    used, near = sums.used[mine].sum(), sums.near[mine].sum()
    least = float(stiffness.values[v, 0])
    return ViewFit(
        residual_mr=ratio(sums.absolute[mine].sum(), used * problem.resolution),
        agreement=ratio(used, near),
        stiffness=least,
        weakest=frozen(stiffness.motions[v, :, 0], np.float64),
        constrained=least > 0.0 and least >= problem.config.least_stiffness,
        component=int(problem.components[v]),
    )


def edges_of(problem: Problem, sums: PairSums, keep: Bools) -> tuple[EdgeFit, ...]:
    """Return how each pair that counts (P,) fits, both directions together."""
    row = {(int(i), int(j)): p for p, (i, j) in enumerate(problem.pairs)}
    edges = []
    for (i, j), p in row.items():
        if i > j or not keep[p]:
            continue
        back = row[j, i]
        used = sums.used[p] + sums.used[back]
        edges.append(EdgeFit(
            source=i, target=j, matches=int(used),
            overlap=ratio(used, sums.tried[p] + sums.tried[back]),
            residual_mr=ratio(
                sums.absolute[p] + sums.absolute[back], used * problem.resolution)))
    return tuple(edges)


def ratio(part: float, whole: float) -> float:
    """Divide, NaN where there is nothing."""
    return float(part) / float(whole) if whole > 0 else math.nan
