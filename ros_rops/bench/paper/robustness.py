# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What sets made worse leave of the pairwise registration: the runs behind Fig. 6 and 8."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from ros_rops.bench.contest import (
    Answer, Contestant, engine, errors_in, PairRecord, prepare_all, Prepared, run_pairs)
from ros_rops.bench.evaluation import overlap_bin, OVERLAP_BINS, PairTruth
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.rivals.descriptor import Descriptor, exchanged
from ros_rops.bench.rivals.descriptors import rival_descriptors
from ros_rops.bench.scores import scores
from ros_rops.bench.settings import derive, MODES
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.errors import ViewError
from ros_rops.core.types import RangeView, Status

ENGINE, ROPS = 'engine', 'RoPS'
# Pairs without overlap, of a set, and pairs of a bin of overlap that descriptors are compared on.
SAMPLED, COMPARED_PAIRS = 20, 12


@dataclass(frozen=True, slots=True)
class Disturbance:
    """
    A way of making a set worse.

    Parameters
    ----------
    unit : str
        Of the levels, as a table shows it.
    labels : mapping of float to str
        Levels in the order in which they are run, and their names; the first leaves a set as it
        is.
    compared : tuple of float
        Levels at which descriptors are compared.
    asked : mapping of float to (float, float)
        Shares of the undisturbed recall that must and that should be left.
    worsened : callable
        (set, seed) to the set at each level.
    paper : str
        What the paper says.
    missing : callable
        Why it cannot be done here, None where it can.
    """

    unit: str
    labels: Mapping[float, str]
    compared: tuple[float, ...]
    asked: Mapping[float, tuple[float, float]]
    worsened: Callable[[ReferenceSet, int], Iterator[ReferenceSet]]
    paper: str
    missing: Callable[[], str | None] = field(default=lambda: None)


def robustness_cases(laboratory: Laboratory, disturbance: Disturbance) -> list[dict[str, Any]]:
    """Run the engine on every set at every level, and descriptors alone on the last set."""
    absent = disturbance.missing()
    if absent is not None:
        return [{'missing': absent}]
    rivals = rival_descriptors(laboratory.config.rops.radius_mr) if laboratory.sets else ()
    cases: list[dict[str, Any]] = [
        {'by': one.name, 'missing': why} for one in rivals if (why := one.missing())]
    rivals = tuple(one for one in rivals if one.missing() is None)
    for dataset in laboratory.sets:
        last = dataset is laboratory.sets[-1]
        worsened = disturbance.worsened(dataset, laboratory.seed)
        for level, worse in zip(disturbance.labels, worsened, strict=True):
            compared = rivals if last and level in disturbance.compared else None
            cases += [
                {'level': level, **case}
                for case in _at_level(laboratory, dataset, worse, compared)]
    return cases


def _at_level(
    laboratory: Laboratory, dataset: ReferenceSet, worse: ReferenceSet,
    rivals: Sequence[Descriptor] | None,
) -> list[dict[str, Any]]:
    """Measure; the set as it was once for all disturbances."""
    if worse is not dataset:
        return _measured(laboratory, dataset, worse, rivals)
    return laboratory.once(
        f'robustness undisturbed {dataset.name}',
        lambda: _measured(laboratory, dataset, worse, rivals))


def _measured(
    laboratory: Laboratory, dataset: ReferenceSet, worse: ReferenceSet,
    rivals: Sequence[Descriptor] | None,
) -> list[dict[str, Any]]:
    """Run the engine; and RoPS and its rivals alone, unless `rivals` is None."""
    config, threads = laboratory.config, laboratory.threads
    errors_of, truths = errors_in(dataset), laboratory.pairs(dataset)

    def case(
        name: str, mode: str, prepared: Prepared, pairs: Sequence[PairTruth]
    ) -> dict[str, Any]:
        contestant = forgiving(engine(derive(config, MODES[mode]), threads=threads))
        records = run_pairs(contestant, pairs, prepared, errors_of, laboratory.tell)
        return {
            'set': dataset.name, 'by': name, **counted(records, prepared),
            **_of_views(prepared, dataset.dres)}

    prepared = prepare_all(
        forgiving(engine(config, threads=threads)), worse.views, laboratory.tell)
    cases = [case(ENGINE, 'default', prepared, tried(truths, laboratory.seed))]
    if rivals is not None:
        pairs = compared_pairs(truths, laboratory.seed)
        cases.append(case(ROPS, 'features-only', prepared, pairs))
        for one in rivals:
            laboratory.tell(f'{dataset.name}: {one.name}')
            views = {
                name: _described(view, one, threads) for name, view in prepared.views.items()}
            other = Prepared(views, prepared.seconds)
            cases.append(case(one.name, 'features-only', other, pairs))
    return cases


def _described(view: Any, descriptor: Descriptor, threads: int) -> Any:
    if view is None or not len(view.surface.features.indices):
        return view
    return exchanged(view, descriptor, threads=threads)


def forgiving(contestant: Contestant) -> Contestant:
    """Return a contestant that refuses pairs of a view that it could not prepare."""
    def prepare(view: RangeView) -> Any:
        try:
            return contestant.prepare(view)
        except ViewError:
            return None

    def register(source: Any, target: Any) -> Answer:
        if source is None or target is None:
            return Answer(Status.REFUSED, None, 'a view could not be prepared')
        return contestant.register(source, target)

    return Contestant(contestant.name, prepare, register)


def _sample(pairs: Sequence[PairTruth], most: int, seed: int) -> list[PairTruth]:
    """Return at most so many pairs in their order, the same ones at the same seed."""
    if len(pairs) <= most:
        return list(pairs)
    kept = np.random.default_rng(seed).choice(len(pairs), most, replace=False)
    return [pairs[k] for k in sorted(kept)]


def tried(truths: Sequence[PairTruth], seed: int) -> list[PairTruth]:
    """Return all evaluated pairs, and a sample of up to 20 that overlap by less."""
    evaluated = [pair for pair in truths if pair.evaluated]
    return evaluated + _sample([pair for pair in truths if not pair.evaluated], SAMPLED, seed)


def compared_pairs(truths: Sequence[PairTruth], seed: int) -> list[PairTruth]:
    """Return at most 12 evaluated pairs of each bin of overlap."""
    return [
        pair for key in OVERLAP_BINS
        for pair in _sample(
            [one for one in truths if overlap_bin(one.overlap) == key], COMPARED_PAIRS, seed)]


def counted(records: Sequence[PairRecord], prepared: Prepared) -> dict[str, Any]:
    """Count pairs: right ones by overlap, wrong ones by whether they are evaluated."""
    right = [overlap_bin(one.truth.overlap) for one in records if one.correct]
    wrong = [one.truth for one in records if one.accepted and not one.correct]
    numbers = scores(records, prepared)
    kept = (
        'pairs', 'correct', 'pairs_by_overlap', 'rotation_deg', 'translation_dres',
        'seconds_per_pair', 'seconds_prepare', 'missed')
    return {
        **{key: numbers[key] for key in kept},
        'correct_by_overlap': {key: right.count(key) for key in OVERLAP_BINS},
        'sampled': len(records) - numbers['pairs'],
        'wrong': [[pair.name_i, pair.name_j] for pair in wrong if pair.evaluated],
        'wrong_sampled': [[pair.name_i, pair.name_j] for pair in wrong if not pair.evaluated]}


def _of_views(prepared: Prepared, dres: float) -> dict[str, Any]:
    """Return means over the views that could be prepared; mr of the meshes, in dres."""
    surfaces = [view.surface for view in prepared.views.values() if view is not None]
    keypoints = [len(one.features.indices) for one in surfaces]
    return {
        'prepared': len(surfaces), 'unprepared': len(prepared.views) - len(surfaces),
        'keypoints': float(np.mean(keypoints)) if keypoints else None,
        'mr_dres': float(np.mean([one.resolution for one in surfaces])) / dres
        if surfaces else None}
