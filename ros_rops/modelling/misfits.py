# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which views do not fit: found one at a time, so that a wrong one does not blame its neighbours.

A view stands out where most of what the others say of its places speaks against it, or where
they would move it by more than its mesh resolution. The worst is taken out, the others are heard
anew without it, until none stands out. Where only two views are left to speak of each other,
none can tell which of them is wrong: both stand out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Floats
from ros_rops.modelling.joint import Joint
from ros_rops.modelling.residuals import SIGMAS, silenced, Votes, weighted_median

CONTRADICTED = 0.25
"""Share of what is contradicted, of the points that others know, from which a view stands out."""
PULL_MR = 1.0
"""Motion that the others ask of it, in mesh resolutions, from which it stands out."""
FEWEST = 30
"""Points known to others that a share can be told of."""


@dataclass(frozen=True, slots=True)
class Misfit:
    """
    A view that stands out, and how far as it was taken out.

    Parameters
    ----------
    index : int
    contradicted : float
        Share of its points known to the views that were left.
    pull : float
        How far they would move it, a length.
    rival : int or None
        The other view, where the two cannot be told apart.
    """

    index: int
    contradicted: float
    pull: float
    rival: int | None = None


def misfits_of(
    votes: Sequence[Votes], joint: Joint, scale: float, resolution: float
) -> tuple[Misfit, ...]:
    """
    Return the views that do not fit the others, the worst first.

    Parameters
    ----------
    votes : sequence of V Votes
    joint : Joint
        Of the same views.
    scale : float
        Standard deviation of right views' distances (`residuals.scale_of`).
    resolution : float
    """
    found: list[Misfit] = []
    gone: list[int] = []
    while True:
        shares = contradictions(votes, scale, gone)
        pulls = joint.pulls(gone)
        # By contradictions first: of a view far off, a single step says little.
        worth = np.nan_to_num(shares) / CONTRADICTED
        out = (worth > 1.0) | (pulls > PULL_MR * resolution)
        out[gone] = False
        if not out.any():
            return tuple(found)
        ranked = np.where(out, worth + np.minimum(pulls / (PULL_MR * resolution), 1.0), -1.0)
        worst = int(np.argmax(ranked))
        rival = _rival(votes, worst, gone)
        found.append(Misfit(worst, float(shares[worst]), float(pulls[worst]), rival))
        gone.append(worst)
        if rival is not None:
            found.append(Misfit(rival, float(shares[rival]), float(pulls[rival]), worst))
            gone.append(rival)


def unheard(count: int, misfits: Sequence[Misfit]) -> list[set[int]]:
    """Return for each of `count` views whom not to hear: misfits, but for itself and a rival."""
    wrong = {one.index for one in misfits}
    rivals = {one.index: one.rival for one in misfits}
    return [wrong - {k, rivals.get(k)} for k in range(count)]


def contradictions(votes: Sequence[Votes], scale: float, without: Sequence[int] = ()) -> Floats:
    """
    Return the share (V,) of each view's points that is contradicted, of those that are known.

    NaN where fewer than `FEWEST` are known. The views in `without` are not heard.
    """
    shares = np.full(len(votes), np.nan)
    for i, one in enumerate(votes):
        residual = weighted_median(silenced(one.distance, without), one.weight)
        known = np.isfinite(residual)
        if np.count_nonzero(known) >= FEWEST:
            shares[i] = np.mean(np.abs(residual[known]) > SIGMAS * scale)
    return shares


def _rival(votes: Sequence[Votes], view: int, gone: Sequence[int]) -> int | None:
    """Return the only other view that this one and none else speaks of, if there is one."""
    around = [j for j in partners(votes, view) if j not in gone]
    if len(around) != 1:
        return None
    other = around[0]
    back = [j for j in partners(votes, other) if j not in gone]
    return other if back in ([view], []) else None


def partners(votes: Sequence[Votes], view: int) -> NDArray[np.intp]:
    """Return the views that know enough places of one to judge it."""
    counts = np.isfinite(votes[view].distance).sum(axis=1)
    return np.flatnonzero(counts >= FEWEST)
