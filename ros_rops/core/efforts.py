# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How hard a pose is looked for: what is proposed, and what comes of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from ros_rops.core.config import Config, MatchingConfig
from ros_rops.core.hypotheses import consistent, half_turned, matched
from ros_rops.core.search import Candidates, random_transforms, search
from ros_rops.core.settling import settled
from ros_rops.core.station import Known
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Status
from ros_rops.core.verdict import against, judge, Verdict

# Part of the random starts that join before the thorough search.
QUICK_SHARE = 5
# Poses that agree with what is known, beside those of the matches.
PROPOSED = 2000
# A pose is plain if its score is so many times beyond doubt, and what speaks against it is less
# than this share of what may.
PLAIN = 2.0
PLAIN_AGAINST = 0.5


@dataclass(frozen=True, slots=True)
class Proposals:
    """
    What matched features propose.

    Parameters
    ----------
    poses : (H, 4, 4) float64
        `T_target_source`.
    matches : int
        How many there were.
    """

    poses: Floats
    matches: int


@dataclass(frozen=True, slots=True)
class Found:
    """
    What a search came to.

    Parameters
    ----------
    candidates : Candidates
    verdict : Verdict
        On the best of them.
    """

    candidates: Candidates
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class Task:
    """
    Two surfaces to be registered.

    Parameters
    ----------
    source, target : Surface
    config : Config
    known : Known or None
        What the station knows of the pose.
    threads : int
        0 takes all cores; no influence on the result.
    """

    source: Surface
    target: Surface
    config: Config
    known: Known | None
    threads: int

    def nearest(self) -> Proposals:
        """Match every feature of the source with its nearest alone (III-B)."""
        return self._matched(
            replace(self.config.matching, neighbours=1, both_directions=False))

    def all_matches(self) -> Proposals:
        """Match the features of both as configured."""
        return self._matched(self.config.matching)

    def starts(self) -> Floats:
        """Pair frames at random, the same ones every time: poses (H, 4, 4)."""
        settings = self.config.pairwise
        return random_transforms(
            self.source, self.target, settings.random_starts,
            np.random.default_rng(settings.seed))

    def look(self, hypotheses: Floats, most: int) -> Found:
        """Search hypotheses (H, 4, 4), refine `most` of them, and judge what comes of it."""
        settings = self.config.pairwise
        candidates = search(
            self.source, self.target, self._agreeing(hypotheses), most, settings,
            threads=self.threads, known=self.known)
        return Found(candidates, judge(
            self.source, self.target, candidates, self.config.verdict, self.known,
            threads=self.threads))

    def settle(self, found: Found) -> Verdict:
        """Refine what was found until it stays."""
        return settled(
            self.source, self.target, found.verdict, found.candidates, self.config,
            threads=self.threads, known=self.known)

    def _matched(self, matching: MatchingConfig) -> Proposals:
        if not self.config.pairwise.matches:
            return Proposals(np.empty((0, 4, 4)), 0)
        config = replace(self.config, matching=matching)
        pairs = matched(self.source, self.target, config, threads=self.threads)
        poses = pairs.transforms
        if config.pairwise.hypotheses == 'ccv':
            poses = consistent(self.source, self.target, pairs, config.ccv).transforms
        if config.pairwise.half_turns:
            poses = np.concatenate([poses, half_turned(self.target, pairs)])
        return Proposals(poses, len(pairs.matches))

    def _agreeing(self, hypotheses: Floats) -> Floats:
        """Leave out what contradicts what is known, and add what it proposes."""
        if self.known is None:
            return hypotheses
        proposed = self.known.starts(
            self.source, self.target, PROPOSED,
            np.random.default_rng(self.config.pairwise.seed))
        admitted = self.known.admits(hypotheses, self.source, self.target)
        return np.concatenate([proposed, hypotheses[admitted]])


def beyond_doubt(verdict: Verdict, config: Config) -> bool:
    """Tell whether a pose is placed at a score beyond doubt, which ends the search."""
    return (
        verdict.status is Status.PLACED
        and verdict.numbers['score'] >= config.verdict.score_sure)


def plain_score(config: Config) -> float:
    """Return the least score of a plain pose."""
    return PLAIN * config.verdict.score_sure


def plain(verdict: Verdict, config: Config) -> bool:
    """Tell whether a pose is so far beyond doubt that no other need be looked for."""
    return (
        verdict.status is Status.PLACED
        and verdict.numbers['score'] >= plain_score(config)
        and verdict.numbers['rival'] <= PLAIN_AGAINST * config.verdict.rival
        and unopposed(verdict.numbers))


def unopposed(numbers: Mapping[str, float]) -> bool:
    """Tell whether hardly any ray contradicts a pose."""
    return against(numbers) <= PLAIN_AGAINST * numbers['contradiction_most']
