# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Pairwise registration (Guo et al. 2014, III): match, search, verdict."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ros_rops.core.config import Config
from ros_rops.core.matching import match, match_transforms
from ros_rops.core.search import Candidates, random_transforms, search
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Status
from ros_rops.core.verdict import judge, Verdict


@dataclass(frozen=True, slots=True)
class PairResult:
    """
    Outcome of one pairwise registration.

    Parameters
    ----------
    source, target : str
        Names of the sides.
    status : Status
        PLACED, AMBIGUOUS or REFUSED.
    T_target_source : (4, 4) float64 or None
        None unless placed.
    reason : str
        One sentence.
    numbers : mapping of str to float
        Counts of every stage and what the verdict rests on.
    """

    source: str
    target: str
    status: Status
    T_target_source: Floats | None
    reason: str
    numbers: Mapping[str, float]


def register(
    source: Surface,
    target: Surface,
    config: Config,
    *,
    threads: int = 0,
    lap: Callable[[str], None] = lambda stage: None,
) -> PairResult:
    """
    Find the pose of `source` in the frame of `target`, or say why there is none.

    Matched features give hypotheses; the best few are refined. Only if none of these is beyond
    doubt, random pairings join in and many are refined.

    Parameters
    ----------
    source, target : Surface
    config : Config
    threads : int
        0 takes all cores; no influence on the result.
    lap : callable
        Called with 'match', 'quick' and, if it was needed, 'thorough' when that stage has ended.

    Returns
    -------
    PairResult
    """
    settings = config.pairwise
    matched = _matched(source, target, config, threads)
    lap('match')
    candidates = search(
        source, target, matched, min(settings.quick, settings.refined), settings,
        threads=threads)
    verdict = judge(source, target, candidates, config.verdict)
    lap('quick')
    if settings.refined > settings.quick and not _beyond_doubt(verdict, config):
        starts = random_transforms(
            source, target, settings.random_starts, np.random.default_rng(settings.seed))
        candidates = search(
            source, target, np.concatenate([matched, starts]), settings.refined, settings,
            threads=threads)
        verdict = judge(source, target, candidates, config.verdict)
        lap('thorough')
    return _result(source, target, verdict, candidates, len(matched))


def _matched(
    source: Surface, target: Surface, config: Config, threads: int
) -> Floats:
    if not config.pairwise.matches:
        return np.empty((0, 4, 4))
    matches = match(
        source.features, target.features, config.matching, threads=threads)
    return match_transforms(source.features, target.features, matches)


def _beyond_doubt(verdict: Verdict, config: Config) -> bool:
    return (
        verdict.status is Status.PLACED
        and verdict.numbers['score'] >= config.verdict.score_sure)


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
