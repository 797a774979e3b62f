# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether the views of a shape agree with each other once they are refined together.

Each view was placed by the views before it; a wrong one can look right to those. Together, a fold
shows: views that come to lie on each other without having been registered to each other fit far
worse than the others.
"""

from collections.abc import Callable, Collection

import numpy as np
from ros_rops.core.fine_types import EdgeFit, FineResult

# Two views that share less have too few matches to contradict each other.
LEAST_OVERLAP = 0.05

# A view stands out if its residual exceeds so many times the median of the object's views, or its
# agreement falls below this share of their median. One of three cannot be told from the others.
OUTSTANDING_RESIDUAL = 1.4
OUTSTANDING_AGREEMENT = 0.7
FEWEST_VIEWS = 4


def outstanding_view(result: FineResult, known: Collection[int]) -> int | None:
    """
    Return the view that fits worst, if it fits far worse than the others.

    Parameters
    ----------
    result : FineResult
    known : collection of int
        Views that are not asked for.
    """
    if len(result.views) < FEWEST_VIEWS:
        return None
    residuals = np.array([view.residual_mr for view in result.views])
    agreement = np.array([view.agreement for view in result.views])
    if np.isnan(residuals).any() or np.isnan(agreement).any():
        return None
    worse = np.maximum(
        residuals / np.median(residuals) / OUTSTANDING_RESIDUAL,
        OUTSTANDING_AGREEMENT * np.median(agreement) / np.maximum(agreement, 1e-9))
    worse[list(known)] = 0.0
    worst = int(np.argmax(worse))
    return worst if worse[worst] > 1.0 else None


def agreeing_groups(
    result: FineResult, conflict: float, limit: Callable[[int, int], float]
) -> list[list[int]]:
    """
    Part the views of a shape into groups without a contradiction.

    Two views contradict each other if their residual is above `conflict` times the median of all
    pairs that overlap, and above what a pair may have. Groups join along the pairs that fit best,
    unless that would bring a contradiction into one.

    Parameters
    ----------
    result : FineResult
    conflict : float
    limit : callable
        Most residual (mr) that a pair of views, by index, may have.

    Returns
    -------
    list of list of int
        Indices of the views, the largest group first; one group if all agree.
    """
    edges = [edge for edge in result.edges if edge.overlap >= LEAST_OVERLAP]
    median = float(np.median([edge.residual_mr for edge in edges])) if edges else 0.0

    def contradicts(edge: EdgeFit) -> bool:
        most = max(conflict * median, limit(edge.source, edge.target))
        return edge.residual_mr > most

    against = {(edge.source, edge.target) for edge in edges if contradicts(edge)}
    if not against:
        return [list(range(len(result.poses)))]
    groups = {view: {view} for view in range(len(result.poses))}
    for edge in sorted(result.edges, key=lambda edge: (edge.residual_mr, edge.source)):
        one, other = groups[edge.source], groups[edge.target]
        if one is other or (edge.source, edge.target) in against:
            continue
        if edge.overlap < LEAST_OVERLAP or _clash(one, other, against):
            continue
        one |= other
        groups.update(dict.fromkeys(other, one))
    distinct = {min(group): sorted(group) for group in groups.values()}
    return sorted(distinct.values(), key=lambda group: (-len(group), group))


def _clash(one: set[int], other: set[int], against: set[tuple[int, int]]) -> bool:
    return any((min(a, b), max(a, b)) in against for a in one for b in other)
