# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fig. 9: errors of correct pairs of rendered views, whose poses are exact."""

from collections.abc import Sequence
from typing import Any

from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.paper.engine_pairs import pair_case, run_engine
from ros_rops.bench.paper.histograms import error_table, plot_errors
from ros_rops.bench.paper.rendered import rendered_set
from ros_rops.bench.table import table

# Pairs of each model registered at most; 24 views have about 200 that overlap by 10%.
MOST_PAIRS = 100


def spread(pairs: Sequence[PairTruth], most: int) -> list[PairTruth]:
    """Choose at most `most` evaluated pairs, evenly over their order by overlap."""
    evaluated = sorted((pair for pair in pairs if pair.evaluated), key=lambda one: one.overlap)
    if len(evaluated) <= most:
        return evaluated
    return [evaluated[k * len(evaluated) // most] for k in range(most)]


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Render each mesh from 24 sides and register the chosen pairs."""
    cases: list[dict[str, Any]] = []
    for model in laboratory.models:
        laboratory.tell(f'rendering {model.name}')
        dataset = rendered_set(model)
        truths = laboratory.pairs(dataset)
        chosen = spread(truths, MOST_PAIRS)
        cases.append({
            **pair_case(dataset, run_engine(laboratory, dataset, chosen)),
            'evaluated': sum(pair.evaluated for pair in truths)})
    if not cases:
        return [{'missing': 'no mesh to render views from (--mesh)'}]
    return cases


def measured(cases: Sequence[Case]) -> list[Case]:
    """Leave out lines that say what is missing."""
    return [case for case in cases if 'missing' not in case]


def show(cases: Sequence[Case]) -> str:
    """Return how many are correct, and the errors."""
    found = measured(cases)
    rows = [
        [case['set'], case['views'], case['evaluated'], len(case['pairs']),
         sum(deg is not None for _, deg, _ in case['pairs']), case['wrong']] for case in found]
    return '\n'.join([
        table(['set', 'views', 'pairs evaluated', 'registered', 'accepted', 'wrong'], rows),
        error_table(found),
        'The paper (four sets): most below 0.5 degrees and 0.5 dres.\n'])


def notes(cases: Sequence[Case]) -> list[str]:
    """Say what is missing, and which pairs were taken."""
    missing = [case['missing'] for case in cases if 'missing' in case]
    return missing or [
        f'At most {MOST_PAIRS} evaluated pairs of a mesh, every so many in their order by '
        'overlap. Views look down by 15 degrees; the paper states azimuths alone.']


EXPERIMENT = Experiment(
    'fig9', 'Fig. 9: errors of correct pairs, rendered views',
    '24 views around each mesh, 15 degrees apart, no noise, exact poses; as Fig. 4.',
    run, show, lambda cases, path: plot_errors(measured(cases), path), notes)
