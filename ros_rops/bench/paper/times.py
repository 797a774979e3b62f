# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Run times: of a pair by stage, of a whole set, beside the paper's minutes."""

from collections.abc import Mapping, Sequence
import time
from typing import Any

import numpy as np
from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.multiview import named_views, shuffled
from ros_rops.bench.paper.engine_pairs import engine_pairs, EngineRun, without_sets
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet
from ros_rops.pipeline.session import SECONDS, Session

# Minutes and views of a whole set (V-B3), MATLAB on a Core i7 of 3.5 GHz.
PAPER: Mapping[str, tuple[float, int]] = {
    'Chef': (21.82, 22), 'Chicken': (7.39, 16), 'Parasaurolophus': (24.54, 16),
    'T-Rex': (17.17, 21)}


def stage_seconds(run: EngineRun) -> dict[str, list[float]]:
    """Return the seconds of every stage of every pair that came to it."""
    stages: dict[str, list[float]] = {}
    for pair in run.pairs:
        for stage, seconds in pair.attempt.seconds.items():
            stages.setdefault(stage, []).append(seconds)
    return stages


def whole_set(laboratory: Laboratory, dataset: ReferenceSet) -> dict[str, Any]:
    """Register a set by a session, in a random order, as often as is asked; medians."""
    spent, stages, placed = [], [], 0
    for _ in range(laboratory.repeats):
        session = Session(laboratory.config, threads=laboratory.threads, units=dataset.units)
        start = time.perf_counter()
        for view in shuffled(named_views([dataset]), laboratory.seed):
            session.add(view)
        session.finish()
        spent.append(time.perf_counter() - start)
        stages.append(dict(session.stage_seconds))
        placed = sum(len(shape.views) for shape in session.objects)
    return {
        'seconds': float(np.median(spent)), 'runs': len(spent), 'placed': placed,
        'attempts': session.attempts,
        'stages': {
            stage: float(np.median([one[stage] for one in stages])) for stage in stages[0]}}


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Time the pairs and the session of every real set."""
    cases = []
    for dataset in laboratory.sets:
        found = engine_pairs(laboratory, dataset)
        laboratory.tell(f'{dataset.name}: session')
        cases.append({
            'set': dataset.name, 'views': len(dataset.views), 'pairs': len(found.pairs),
            'prepare': float(np.median(found.prepare_seconds)),
            'pair': float(np.median([pair.seconds for pair in found.pairs])),
            'stages': {
                stage: {'pairs': len(seconds), 'median': float(np.median(seconds))}
                for stage, seconds in stage_seconds(found).items()},
            'session': whole_set(laboratory, dataset)})
    return cases


def show(cases: Sequence[Case]) -> str:
    """Return the tables of pairs and of whole sets."""
    return f'{pair_table(cases)}\n{set_table(cases)}'


def pair_table(cases: Sequence[Case]) -> str:
    """Return medians of a view and a pair by stage."""
    stages = [stage for stage in SECONDS if any(stage in case['stages'] for case in cases)]
    rows = []
    for case in cases:
        cells: list[str | None] = []
        for stage in stages:
            one = case['stages'].get(stage)
            whole = one is not None and one['pairs'] == case['pairs']
            cells.append(None if one is None else f'{one["median"]:.3f}' + (
                '' if whole else f' (in {one["pairs"]})'))
        rows.append([
            case['set'], case['pairs'], f'{case["prepare"]:.3f}', *cells, f'{case["pair"]:.3f}'])
    return table(
        ['medians, s', 'pairs', 'prepare a view', *stages, 'a pair, all stages'], rows)


def set_table(cases: Sequence[Case]) -> str:
    """Return seconds of whole sets, ours and the paper's, and by stage."""
    stages = [
        stage for stage in SECONDS
        if any(case['session']['stages'].get(stage, 0.0) > 0 for case in cases)]
    rows: list[list[object]] = []
    for case in cases:
        one = case['session']
        rows.append([
            case['set'], f'{one["placed"]}/{case["views"]}', one['attempts'],
            f'{one["seconds"]:.1f}', f'{one["seconds"] / case["views"]:.2f}',
            *(f'{one["stages"][stage]:.2f}' for stage in stages)])
    for name, (minutes, views) in PAPER.items():
        rows.append([
            f'{name} (paper)', f'{views}/{views}', None, f'{60 * minutes:.0f}',
            f'{60 * minutes / views:.0f}', *(None for _ in stages)])
    return table(['whole set', 'placed', 'registrations', 's', 's/view', *stages], rows)


def notes(cases: Sequence[Case]) -> list[str]:
    """Say what the times of the paper are."""
    return without_sets(cases) or [
        "The paper's are of MATLAB on a Core i7 of 3.5 GHz and of sets with other views: an order "
        'of magnitude, not a ratio. Whether they hold the fine registration is not said; ours do.']


EXPERIMENT = Experiment(
    'times', 'Run times',
    'Views are in memory. *Match*: nearest features; *quick*: search among the best 20 poses and '
    'verdict; *thorough*: the search that follows where none of these is beyond doubt. A whole '
    'set goes through one session in a random order, fine registration included.',
    run, show, notes=notes)
