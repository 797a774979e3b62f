# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The engine on every pair of a set, once for all experiments that show it."""

from collections.abc import Sequence
from dataclasses import dataclass
import time
from typing import Any

from ros_rops.bench.contest import errors_in
from ros_rops.bench.errors import PairErrors
from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.experiment import Case, Laboratory
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.types import Status
from ros_rops.pipeline.attempt import Attempt, attempt
from ros_rops.pipeline.prepare import prepare


@dataclass(frozen=True, slots=True)
class EnginePair:
    """
    What the engine made of one pair.

    Parameters
    ----------
    truth : PairTruth
    attempt : Attempt
        Its word, and the seconds by stage.
    errors : PairErrors or None
        None where it is not registered.
    """

    truth: PairTruth
    attempt: Attempt
    errors: PairErrors | None

    @property
    def accepted(self) -> bool:
        """Whether the engine says that the pair is registered."""
        return self.attempt.status is Status.PLACED

    @property
    def correct(self) -> bool:
        """Whether it is, within 5 degrees and 5 dres."""
        return self.errors is not None and self.errors.correct

    @property
    def seconds(self) -> float:
        """Of all stages, preparation left out."""
        return sum(self.attempt.seconds.values())


@dataclass(frozen=True, slots=True)
class EngineRun:
    """All pairs of a set, and the seconds that the preparation of each view took."""

    pairs: tuple[EnginePair, ...]
    prepare_seconds: tuple[float, ...]


def run_engine(
    laboratory: Laboratory, dataset: ReferenceSet, truths: Sequence[PairTruth]
) -> EngineRun:
    """Register these pairs of a set, i as the source and j as the target."""
    surfaces, spent = {}, []
    for name in dict.fromkeys(name for one in truths for name in (one.name_i, one.name_j)):
        laboratory.tell(f'{dataset.name}: preparing {name}')
        start = time.perf_counter()
        surfaces[name] = prepare(
            dataset.views[name], laboratory.config, threads=laboratory.threads).surface
        spent.append(time.perf_counter() - start)
    errors_of, pairs = errors_in(dataset), []
    for number, truth in enumerate(truths):
        laboratory.tell(f'{dataset.name}: pair {number + 1} of {len(truths)}')
        result, record = attempt(
            surfaces[truth.name_i], surfaces[truth.name_j], laboratory.config,
            threads=laboratory.threads)
        T = result.T_target_source
        pairs.append(EnginePair(truth, record, None if T is None else errors_of(truth, T)))
    return EngineRun(tuple(pairs), tuple(spent))


def engine_pairs(laboratory: Laboratory, dataset: ReferenceSet) -> EngineRun:
    """Return the engine's run over all pairs of a real set, those without overlap included."""
    return laboratory.once(
        f'engine pairs {dataset.name}',
        lambda: run_engine(laboratory, dataset, laboratory.pairs(dataset)))


def pair_case(dataset: ReferenceSet, run: EngineRun) -> dict[str, Any]:
    """
    Return the run as one line of a result.

    `pairs` holds overlap, degrees and dres (None where not registered) of every evaluated pair;
    `accepted` and `wrong` count all pairs, those that overlap by less than 10% included.
    """
    accepted = [pair for pair in run.pairs if pair.accepted]
    return {
        'set': dataset.name, 'dres': dataset.dres, 'views': len(dataset.views),
        'pairs_all': len(run.pairs), 'accepted': len(accepted),
        'wrong': sum(not pair.correct for pair in accepted),
        'pairs': [
            [pair.truth.overlap, *(
                (None, None) if pair.errors is None
                else (pair.errors.rotation_deg, pair.errors.translation_dres))]
            for pair in run.pairs if pair.truth.evaluated],
    }


def engine_cases(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Return the engine's run over all pairs of every real set."""
    return [pair_case(one, engine_pairs(laboratory, one)) for one in laboratory.sets]


def without_sets(cases: Sequence[Case]) -> list[str]:
    """Say so where there was no data set to measure on."""
    return [] if cases else ['no data set with real views was given']


def correct_errors(case: Case) -> list[tuple[float, float]]:
    """Return degrees and dres of the evaluated pairs of a line that are correct."""
    return [
        (deg, dres) for _, deg, dres in case['pairs']
        if deg is not None and PairErrors(deg, dres, dres).correct]
