# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which views of an object stand right: the one verdict that cloud, surface and maps go by.

A view that does not fit the others is left out of the model, so that it has no second sheet beside
the first, if those that stay know better: they speak of its places, no one of them is in question
with it alone, and they are more than those that would go.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.errors import ParameterError
from ros_rops.modelling.joint import Joint
from ros_rops.modelling.misfits import Misfit, misfits_of, partners
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.residuals import collect_votes, scale_of, Votes


@dataclass(frozen=True, slots=True)
class Standing:
    """
    What the views of an object say of each other, and which of them are not believed.

    Parameters
    ----------
    votes : tuple of Votes
        For each view.
    joint : Joint or None
        None for a single view.
    noise : float
        Standard deviation of right views' distances to each other.
    misfits : tuple of Misfit
        Views that do not fit the others, the worst first.
    left_out : tuple of int
        Those of them that no model is made of, the worst first.
    """

    votes: tuple[Votes, ...]
    joint: Joint | None
    noise: float
    misfits: tuple[Misfit, ...]
    left_out: tuple[int, ...]

    def right(self, views: Sequence[PosedView]) -> tuple[PosedView, ...]:
        """Return those of the views (the same that were judged) that models are made of."""
        return tuple(view for k, view in enumerate(views) if k not in self.left_out)


def judge(
    views: Sequence[PosedView], config: Config, *, resolution: float, threads: int = 0
) -> Standing:
    """
    Find out which views stand right.

    Parameters
    ----------
    views : sequence of PosedView
        One or more.
    config : Config
        Group `fine`: matches, what counts as held.
    resolution : float
        Mean of the views' mesh resolutions (dres).
    threads : int
        0 takes all cores; no influence on the result.

    Raises
    ------
    ParameterError
        If there is no view, or `resolution` is not positive.
    """
    if not views:
        raise ParameterError('views: expected at least one, got none')
    if not (np.isfinite(resolution) and resolution > 0):
        raise ParameterError(f'resolution: expected a length above 0, got {resolution!r}')
    votes = collect_votes(views, resolution, threads=threads)
    joint = None
    if len(views) > 1:
        joint = Joint.of(views, resolution, config.fine, threads=threads)
    noise = scale_of(votes, 0.0 if joint is None else joint.roughness, resolution)
    misfits = () if joint is None else misfits_of(votes, joint, noise, resolution)
    return Standing(votes, joint, noise, misfits, _left_out(votes, misfits))


def _left_out(votes: Sequence[Votes], misfits: Sequence[Misfit]) -> tuple[int, ...]:
    """Return the misfits that the others outweigh; none if they would be half of all."""
    odd = {one.index for one in misfits}
    known = [
        one.index for one in misfits
        if one.rival is None and any(j not in odd for j in partners(votes, one.index))]
    return tuple(known) if 2 * len(known) < len(votes) else ()
