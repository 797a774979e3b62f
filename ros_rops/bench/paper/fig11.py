# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fig. 11: pairwise registrations against the number of views, by three strategies."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.multiview import run_job
from ros_rops.bench.paper.drawing import drawing, saved
from ros_rops.bench.paper.many_views import (
    job_of, most_registrations, NO_MESH, OURS, rendered, RIVALS)
from ros_rops.bench.paper.table4 import span
from ros_rops.bench.rivals.view_graph import Book
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet

# Random orders, whose first views are the subsets. The rivals have the first.
ORDERS = 3
FEWEST = 4
KEPT = ('views', 'placed', 'wrong_placements', 'wrong_merges', 'splits', 'attempts')
STYLES = {OURS.name: 'o-', RIVALS[0].name: 's--', RIVALS[1].name: '^:'}


def sizes(views: int) -> list[int]:
    """Return how many views are taken, the last time all of them."""
    return [*range(FEWEST, views, 2 if views <= 12 else 4), views]


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Count on every real set, and on 24 rendered views of the first mesh."""
    models = [rendered(laboratory, model) for model in laboratory.models[:1]]
    cases = [
        case for dataset in (*laboratory.sets, *models) for order in range(ORDERS)
        for case in run_order(laboratory, dataset, order)]
    return cases if models else [*cases, {'missing': NO_MESH}]


def run_order(
    laboratory: Laboratory, dataset: ReferenceSet, order: int
) -> list[dict[str, Any]]:
    """Count for growing parts of one order; the rivals share what they registered."""
    book, cases = Book(), []
    for most in sizes(len(dataset.views)):
        job = job_of(laboratory, [dataset], laboratory.seed + order, most)
        openers = {OURS.name: OURS.open_session}
        if order == 0:
            openers.update({
                rival.name: partial(rival.open_session, book=book) for rival in RIVALS})
        for name, opener in openers.items():
            laboratory.tell(f'{dataset.name}, order {order + 1}, {most} views: {name}')
            case = run_job(job, opener, residuals=False)
            cases.append({
                'set': dataset.name, 'by': name, 'order': order + 1,
                **{key: case[key] for key in KEPT}})
    return cases


def measured(cases: Sequence[Case]) -> list[Case]:
    """Leave out lines that say what is missing."""
    return [case for case in cases if 'missing' not in case]


def by_size(cases: Sequence[Case], name: str, by: str, key: str = 'attempts') -> list[list[int]]:
    """Return a number of one set and strategy by rising number of views, over the orders."""
    found = [case for case in cases if (case['set'], case['by']) == (name, by)]
    return [
        [case[key] for case in found if case['views'] == views]
        for views in sorted({case['views'] for case in found})]


def show(cases: Sequence[Case]) -> str:
    """Return the counts by number of views."""
    found = measured(cases)
    rows: list[list[object]] = []
    for name in dict.fromkeys(case['set'] for case in found):
        counts = {by: by_size(found, name, by) for by in STYLES}
        views = [values[0] for values in by_size(found, name, OURS.name, 'views')]
        for k, number in enumerate(views):
            here = [c for c in found if (c['set'], c['views']) == (name, number)]
            rows.append([
                name, number, *(span(values[k], 0) for values in counts.values()),
                *(span([c['placed'] for c in here if c['by'] == by], 0) for by in STYLES),
                sum(c['wrong_placements'] for c in here)])
    rows.append(['Chicken (paper)', 20, 19, 117, 190, 20, 20, 20, None])
    return table(
        ['registrations', 'views', *STYLES, *(f'placed: {by}' for by in STYLES), 'wrong'], rows)


def plot(cases: Sequence[Case], path: Path) -> None:
    """Draw the counts, a panel a set."""
    found = measured(cases)
    names = list(dict.fromkeys(case['set'] for case in found))
    columns = min(3, len(names))
    with drawing(columns, -(-len(names) // columns)) as (figure, axes):
        for axis, name in zip(axes.flat, names, strict=False):
            views = [values[0] for values in by_size(found, name, OURS.name, 'views')]
            for by, style in STYLES.items():
                counts = by_size(found, name, by)
                axis.plot(views, [max(values) for values in counts], style, label=by, ms=4)
            axis.set(title=name, xlabel='views', ylabel='registrations', ylim=(0, None))
        for axis in axes.flat[len(names):]:
            axis.set_axis_off()
        axes.flat[0].legend(frameon=False)
        saved(figure, path)


def notes(cases: Sequence[Case]) -> list[str]:
    """Say what ours took at most, and what is missing."""
    ours = [case for case in measured(cases) if case['by'] == OURS.name]
    apart = [case for case in ours if case['placed'] < case['views'] or case['splits']]
    return [
        most_registrations(ours),
        f'The first views of a random order need not overlap enough: in {len(apart)} of '
        f'{len(ours)} sessions of ours some stay alone or in a second shape, of at most '
        f'{max((case["views"] for case in apart), default=0)} views.',
        *(case['missing'] for case in cases if 'missing' in case)]


EXPERIMENT = Experiment(
    'fig11', 'Fig. 11: registrations against the number of views',
    f'The first views of {ORDERS} random orders by ours (the range over the orders; the plot '
    'shows the most), of the first by the rivals. A registration counts when a view or shape is '
    "matched, refined and judged against another; ours' quick votes and the rivals' tests of "
    'surface consistency are none.',
    run, show, plot, notes)
