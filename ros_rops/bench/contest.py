# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A way of registering pairs, the project's own or a peer's, and what it made of each pair."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
import time
from typing import Any

from ros_rops.bench.errors import pair_errors, PairErrors
from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.truth import ReferenceSet, units_factor
from ros_rops.core.config import Config
from ros_rops.core.types import Floats, RangeView, Status


@dataclass(frozen=True, slots=True)
class Answer:
    """
    What a contestant says about a pair.

    Parameters
    ----------
    status : Status
        `PLACED` where the contestant itself says that the pair is registered.
    T_target_source : (4, 4) float64 or None
    reason : str
        Why it is not registered.
    numbers : mapping of str to float
        Its scores and counts.
    """

    status: Status
    T_target_source: Floats | None
    reason: str = ''
    numbers: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Contestant:
    """
    A program under test.

    Parameters
    ----------
    name : str
    prepare : callable
        One view to whatever `register` takes.
    register : callable
        (source, target) to an answer.
    """

    name: str
    prepare: Callable[[RangeView], Any]
    register: Callable[[Any, Any], Answer]


@dataclass(frozen=True, slots=True)
class Prepared:
    """All views prepared, by name, and the seconds that each took."""

    views: Mapping[str, Any]
    seconds: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class PairRecord:
    """
    What became of one pair.

    Parameters
    ----------
    truth : PairTruth
    status : Status
    reason : str
    errors : PairErrors or None
        None without a transform or without a reference.
    seconds : float
        Wall seconds of the registration, preparation left out.
    seconds_with_prepare : float
        The same with the preparation of both views.
    numbers : mapping of str to float
    """

    truth: PairTruth
    status: Status
    reason: str
    errors: PairErrors | None
    seconds: float
    seconds_with_prepare: float
    numbers: Mapping[str, float] = field(default_factory=dict)

    @property
    def accepted(self) -> bool:
        """Whether the contestant itself says that the pair is registered."""
        return self.status is Status.PLACED

    @property
    def correct(self) -> bool:
        """Whether the pair is accepted, and rightly."""
        return self.accepted and self.errors is not None and self.errors.correct


def engine(config: Config, *, threads: int = 0) -> Contestant:
    """Return the project's own engine as a contestant."""
    from ros_rops.core.pairwise import register
    from ros_rops.pipeline.prepare import prepare

    def answer(source: Any, target: Any) -> Answer:
        result = register(source.surface, target.surface, config, threads=threads)
        return Answer(result.status, result.T_target_source, result.reason, result.numbers)

    return Contestant('ros_rops', lambda view: prepare(view, config, threads=threads), answer)


def prepare_all(
    contestant: Contestant, views: Mapping[str, RangeView], tell: Callable[[str], None]
) -> Prepared:
    """Prepare every view once."""
    products, seconds = {}, {}
    for number, (name, view) in enumerate(views.items()):
        tell(f'{contestant.name}: preparing view {number + 1} of {len(views)}')
        start = time.perf_counter()
        products[name] = contestant.prepare(view)
        seconds[name] = time.perf_counter() - start
    return Prepared(products, seconds)


def run_pairs(
    contestant: Contestant,
    pairs: Sequence[PairTruth],
    prepared: Prepared,
    errors_of: Callable[[PairTruth, Floats], PairErrors | None],
    tell: Callable[[str], None],
) -> list[PairRecord]:
    """
    Register all pairs, i as the source and j as the target.

    Parameters
    ----------
    contestant : Contestant
    pairs : sequence of PairTruth
    prepared : Prepared
        All views of the pairs.
    errors_of : callable
        Errors of a transform of a pair, None where there is no reference.
    tell : callable
        Told the progress.
    """
    records = []
    for number, pair in enumerate(pairs):
        tell(f'{contestant.name}: pair {number + 1} of {len(pairs)}')
        source, target = prepared.views[pair.name_i], prepared.views[pair.name_j]
        start = time.perf_counter()
        answer = contestant.register(source, target)
        seconds = time.perf_counter() - start
        before = prepared.seconds[pair.name_i] + prepared.seconds[pair.name_j]
        T = answer.T_target_source
        records.append(PairRecord(
            pair, answer.status, answer.reason, None if T is None else errors_of(pair, T),
            seconds, before + seconds, dict(answer.numbers)))
    return records


def errors_in(dataset: ReferenceSet) -> Callable[[PairTruth, Floats], PairErrors | None]:
    """Return the function that measures a transform of a pair of this set."""
    centroids = {name: view.points.mean(axis=0) for name, view in dataset.views.items()}

    def errors_of(pair: PairTruth, T: Floats) -> PairErrors | None:
        if pair.T_j_i is None:
            return None
        return pair_errors(T, pair.T_j_i, centroids[pair.name_i], dataset.dres)

    return errors_of


def cross_pairs(
    sets: Sequence[ReferenceSet],
) -> list[tuple[str, dict[str, RangeView], list[PairTruth]]]:
    """
    Return, for every two sets in the same units, their views and the pairs between them.

    Views are named 'set/view'. Nothing overlaps, nothing has a reference: whatever is accepted
    is wrong.
    """
    result = []
    for k, first in enumerate(sets):
        for second in sets[k + 1:]:
            if units_factor(first.units, second.units) != 1.0:
                continue
            views = {
                f'{one.name}/{name}': view
                for one in (first, second) for name, view in one.views.items()
            }
            pairs = [
                PairTruth(f'{first.name}/{i}', f'{second.name}/{j}', 0.0, None)
                for i in first.views for j in second.views
            ]
            result.append((f'{first.name} x {second.name}', views, pairs))
    return result
