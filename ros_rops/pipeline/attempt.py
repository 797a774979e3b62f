# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""One pairwise registration that a session attempted, and what it took."""

from collections.abc import Mapping
from dataclasses import dataclass
import time

from ros_rops.core.config import Config
from ros_rops.core.pairwise import PairResult, register
from ros_rops.core.station import Known
from ros_rops.core.surface import Surface
from ros_rops.core.types import Status


@dataclass(frozen=True, slots=True)
class Attempt:
    """
    A registration of a view or shape against a shape.

    Parameters
    ----------
    source, target : str
        Names of the sides; of a shape, that of its first view.
    status : Status
        PLACED, AMBIGUOUS or REFUSED.
    reason : str
        One sentence.
    numbers : mapping of str to float
        Counts of every stage and what the verdict rests on.
    seconds : mapping of str to float
        Wall time of the stages that ran: those that `register` tells of.
    source_views, target_views : tuple of str
        Names of the views that each side held then.
    """

    source: str
    target: str
    status: Status
    reason: str
    numbers: Mapping[str, float]
    seconds: Mapping[str, float]
    source_views: tuple[str, ...] = ()
    target_views: tuple[str, ...] = ()


class StageClock:
    """Wall seconds by stage, in `seconds`."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        """Count the time since the last call for `stage`."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._last
        self._last = now


def attempt(
    source: Surface, target: Surface, config: Config, *, threads: int = 0,
    known: Known | None = None, thorough: bool = True,
) -> tuple[PairResult, Attempt]:
    """Register as `register` does, and record it with the time that it took."""
    clock = StageClock()
    result = register(
        source, target, config, threads=threads, lap=clock.lap, known=known, thorough=thorough)
    return result, Attempt(
        result.source, result.target, result.status, result.reason, result.numbers,
        clock.seconds)
