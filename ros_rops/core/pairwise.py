# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Pairwise registration (Guo et al. 2014, III): match, search, verdict."""

from dataclasses import replace

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.efforts import beyond_doubt, plain, QUICK_SHARE, Task
from ros_rops.core.pair_result import Lap, PairResult
from ros_rops.core.paper_pairwise import register_paper
from ros_rops.core.search import Candidates
from ros_rops.core.station import Known
from ros_rops.core.surface import Surface
from ros_rops.core.types import Status
from ros_rops.core.verdict import Verdict

__all__ = ['PairResult', 'register']


def register(
    source: Surface,
    target: Surface,
    config: Config,
    *,
    threads: int = 0,
    lap: Lap = lambda stage: None,
    known: Known | None = None,
    thorough: bool = True,
) -> PairResult:
    """
    Find the pose of `source` in the frame of `target`, or say why there is none.

    Nearest features give hypotheses; the best few are refined. Where none of these is plain, all
    matches do; where none of those is beyond doubt, random pairings join in and many are
    refined. Method `paper` is `register_paper`.

    Parameters
    ----------
    source, target : Surface
    config : Config
    threads : int
        0 takes all cores; no influence on the result.
    lap : callable
        Called with 'match', 'glance', if they were needed 'match', 'quick' and 'thorough', and
        'settle' when that stage has ended (method `paper`: 'match', 'ccv', 'icp').
    known : Known, optional
        What the station knows of the pose: proposes and objects (not with method `paper`).
    thorough : bool
        Whether to go on where the nearest matches alone make no pose plain; if not, another
        pose is AMBIGUOUS.

    Returns
    -------
    PairResult
    """
    settings = config.pairwise
    if settings.method == 'paper':
        return register_paper(source, target, config, threads=threads, lap=lap)
    task = Task(source, target, config, known, threads)
    starts = task.starts()
    # A few random starts at once: the matches alone may not show the other pose of a symmetry.
    few = starts[:len(starts) // QUICK_SHARE]
    quick = min(settings.quick, settings.refined)
    proposals = task.nearest()
    lap('match')
    found = task.look(np.concatenate([proposals.poses, few]), quick)
    lap('glance')
    if thorough and proposals.matches and not plain(found.verdict, config):
        proposals = task.all_matches()
        lap('match')
        found = task.look(np.concatenate([proposals.poses, few]), quick)
        lap('quick')
    more = thorough and settings.refined > settings.quick
    if more and not beyond_doubt(found.verdict, config):
        found = task.look(np.concatenate([proposals.poses, starts]), settings.refined)
        lap('thorough')
    verdict = task.settle(found)
    lap('settle')
    if not thorough:
        verdict = _plain(verdict, config)
    return _result(source, target, verdict, found.candidates, proposals.matches)


def _plain(verdict: Verdict, config: Config) -> Verdict:
    """Doubt a placed pose that is not plain."""
    if verdict.status is not Status.PLACED or plain(verdict, config):
        return verdict
    return replace(
        verdict, status=Status.AMBIGUOUS, T_target_source=None,
        reason=f'{verdict.reason}: not so plain that it is believed before other views came')


def _result(
    source: Surface,
    target: Surface,
    verdict: Verdict,
    candidates: Candidates,
    matches: int,
) -> PairResult:
    counts = {
        'keypoints_source': float(len(source.features.indices)),
        'keypoints_target': float(len(target.features.indices)),
        'matches': float(matches),
        'hypotheses': float(candidates.hypotheses),
        'refined': float(candidates.refined),
        'distinct': float(len(candidates.poses)),
    }
    return PairResult(
        source.name, target.name, verdict.status, verdict.T_target_source, verdict.reason,
        {**counts, **verdict.numbers})
