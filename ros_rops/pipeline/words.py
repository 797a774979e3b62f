# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The most telling outcome of a registration for every view."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
import math

import numpy as np
from ros_rops.core.config import VerdictConfig
from ros_rops.core.efforts import unopposed
from ros_rops.core.pairwise import PairResult
from ros_rops.core.types import Status
from ros_rops.core.verdict import against
from ros_rops.pipeline.reports import ViewReport

# Residuals below this are alike (mr): where a surface has creases, views of it at the right pose
# differ by as much as by their meshes, and elsewhere by a third of it.
ALIKE_MR = 0.1


class Words:
    """What is to be said of each view, by name."""

    def __init__(self) -> None:
        self._words: dict[str, PairResult] = {}

    def placed(self, names: Iterable[str], result: PairResult) -> None:
        """Note the pose by which views came to an object; the first counts."""
        for name in names:
            known = self._words.get(name)
            if known is None or known.status is not Status.PLACED:
                self._words[name] = result

    def refused(self, name: str, result: PairResult) -> None:
        """Note why a view stays alone, if that tells more than what is known."""
        known = self._words.get(name)
        if known is None or _telling(result) > _telling(known):
            self._words[name] = result

    def say(self, name: str, target: str, reason: str) -> None:
        """Say something of a view that stays alone, until more is known."""
        self._words[name] = PairResult(name, target, Status.REFUSED, None, reason, {})

    def forget(self, name: str) -> None:
        """Forget a view."""
        self._words.pop(name, None)

    def report(self, name: str, object_id: int | None) -> ViewReport:
        """Return the current word on a view; `object_id` is None for one that is alone."""
        word = self._words.get(name)
        if object_id is not None:
            reason = word.reason if word else 'the others were registered to it'
            return ViewReport(
                name, Status.PLACED, object_id, reason, word.numbers if word else {})
        if word is None:
            return ViewReport(
                name, Status.PENDING, None, 'waits for views that overlap it', {})
        status = Status.AMBIGUOUS if word.status is Status.AMBIGUOUS else Status.PENDING
        return ViewReport(
            name, status, None, f'against {word.target}: {word.reason}', word.numbers)


def refused(result: PairResult, reason: str) -> PairResult:
    """Return a result without its pose, for a reason that lies outside of the pair."""
    return replace(result, status=Status.REFUSED, T_target_source=None, reason=reason)


def objection(
    result: PairResult, past: Sequence[float], config: VerdictConfig, *, several: bool
) -> str:
    """
    Return what a session has against a pose that two shapes alone would bear out, '' if nothing.

    Parameters
    ----------
    result : PairResult
    past : sequence of float
        Residuals (mr) by which the two shapes grew, or the session's others.
    config : VerdictConfig
    several : bool
        Whether there are other shapes: of many strangers some fit each other by chance.
    """
    return outlier(result, past, config.outlier) or (opposed(result) if several else '')


def outlier(result: PairResult, past: Sequence[float], most: float) -> str:
    """Return why a pose fits too badly for what the shapes are like within, '' if it does not."""
    residual = result.numbers.get('residual_mr', 0.0)
    usual = max(float(np.median(past)), ALIKE_MR) if past else math.inf
    if result.status is not Status.PLACED or residual <= most * usual:
        return ''
    return (
        f'residual {residual:.2f} mr, while other views fit each other within '
        f'{usual:.2f}')


def opposed(result: PairResult) -> str:
    """Return why a pose is doubted where other shapes may fit as well, '' if it is not."""
    if result.status is not Status.PLACED or unopposed(result.numbers):
        return ''
    return (
        f'what the rays contradict is {against(result.numbers):.2f} of what matches: too much '
        'where there are other shapes that it may belong to')


def _telling(word: PairResult) -> float:
    return word.numbers.get('score', -1.0)
