# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Pairwise registration (Guo et al. 2014, III): match, search, verdict."""

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.hypotheses import consistent, half_turned, matched
from ros_rops.core.pair_result import Lap, PairResult
from ros_rops.core.paper_pairwise import register_paper
from ros_rops.core.search import Candidates, random_transforms, search
from ros_rops.core.settling import settled
from ros_rops.core.station import Known
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Status
from ros_rops.core.verdict import judge, Verdict

__all__ = ['PairResult', 'register']

# Part of the random starts that join the quick search.
QUICK_SHARE = 5
# Poses that agree with what is known, beside those of the matches.
PROPOSED = 2000


def register(
    source: Surface,
    target: Surface,
    config: Config,
    *,
    threads: int = 0,
    lap: Lap = lambda stage: None,
    known: Known | None = None,
) -> PairResult:
    """
    Find the pose of `source` in the frame of `target`, or say why there is none.

    Matched features give hypotheses; the best few are refined. Only if none of these is beyond
    doubt, random pairings join in and many are refined. Method `paper` is `register_paper`.

    Parameters
    ----------
    source, target : Surface
    config : Config
    threads : int
        0 takes all cores; no influence on the result.
    lap : callable
        Called with 'match', 'quick', if it was needed 'thorough', and 'settle' when that stage
        has ended (method `paper`: 'match', 'ccv', 'icp').
    known : Known, optional
        What the station knows of the pose: proposes and objects (not with method `paper`).

    Returns
    -------
    PairResult
    """
    settings = config.pairwise
    if settings.method == 'paper':
        return register_paper(source, target, config, threads=threads, lap=lap)
    from_matches, matches = _from_matches(source, target, config, threads)
    lap('match')
    starts = random_transforms(
        source, target, settings.random_starts, np.random.default_rng(settings.seed))
    # A few random starts at once: the matches alone may not show the other pose of a symmetry.
    few = np.concatenate([from_matches, starts[:len(starts) // QUICK_SHARE]])
    everything = np.concatenate([from_matches, starts])
    if known is not None:
        proposed = known.starts(
            source, target, PROPOSED, np.random.default_rng(settings.seed))
        few, everything = (
            np.concatenate([proposed, poses[known.admits(poses, source, target)]])
            for poses in (few, everything))
    candidates = search(
        source, target, few, min(settings.quick, settings.refined), settings, threads=threads,
        known=known)
    verdict = judge(source, target, candidates, config.verdict, known, threads=threads)
    lap('quick')
    if settings.refined > settings.quick and not _beyond_doubt(verdict, config):
        candidates = search(
            source, target, everything, settings.refined, settings, threads=threads,
            known=known)
        verdict = judge(source, target, candidates, config.verdict, known, threads=threads)
        lap('thorough')
    verdict = settled(
        source, target, verdict, candidates, config, threads=threads, known=known)
    lap('settle')
    return _result(source, target, verdict, candidates, matches)


def _from_matches(
    source: Surface, target: Surface, config: Config, threads: int
) -> tuple[Floats, int]:
    """Return the poses that matched features propose, and how many matches there were."""
    if not config.pairwise.matches:
        return np.empty((0, 4, 4)), 0
    pairs = matched(source, target, config, threads=threads)
    poses = pairs.transforms
    if config.pairwise.hypotheses == 'ccv':
        poses = consistent(source, target, pairs, config.ccv).transforms
    if config.pairwise.half_turns:
        poses = np.concatenate([poses, half_turned(target, pairs)])
    return poses, len(pairs.matches)


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
