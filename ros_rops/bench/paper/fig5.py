# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fig. 5: correct and incorrect pairs by overlap."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from ros_rops.bench.errors import PairErrors
from ros_rops.bench.experiment import Case, Experiment
from ros_rops.bench.paper.drawing import drawing, saved
from ros_rops.bench.paper.engine_pairs import engine_cases, without_sets
from ros_rops.bench.table import table

# Lower ends of the bins, in percent; pairs that overlap by less are not evaluated.
BINS = tuple(range(10, 100, 10))


def by_overlap(case: Case) -> tuple[list[int], list[int]]:
    """Count correct and incorrect pairs in each bin; 100% belongs to the last."""
    counts = ([0] * len(BINS), [0] * len(BINS))
    for overlap, deg, dres in case['pairs']:
        right = deg is not None and PairErrors(deg, dres, dres).correct
        # Rounded: 0.3 is in the bin that begins at 30%.
        at = min(int(round(100.0 * overlap, 9) // 10) - 1, len(BINS) - 1)
        counts[0 if right else 1][at] += 1
    return counts


def show(cases: Sequence[Case]) -> str:
    """Return correct pairs of all by bin."""
    rows = []
    for case in cases:
        right, wrong = by_overlap(case)
        rows.append([
            case['set'],
            *(f'{a}/{a + b}' if a + b else None for a, b in zip(right, wrong, strict=True)),
            f'{sum(right)}/{sum(right) + sum(wrong)}', f'{case["wrong"]} of {case["pairs_all"]}'])
    heads = [f'{low}-{low + 10}%' for low in BINS]
    return table(['set', *heads, 'all', 'wrong accepted'], rows) + (
        '\nThe paper: above 60% all, between 30 and 60% about three quarters, below 20% several '
        'correct.\n')


def plot(cases: Sequence[Case], path: Path) -> None:
    """Draw correct and incorrect pairs by overlap, a panel for each set."""
    with drawing(columns=2, rows=max((len(cases) + 1) // 2, 1)) as (figure, axes):
        for axis, case in zip(axes.flat, cases, strict=False):
            right, wrong = by_overlap(case)
            at = np.array(BINS) + 5
            axis.bar(at - 1.8, right, 3.6, label='correct', color='tab:blue')
            axis.bar(at + 1.8, wrong, 3.6, label='incorrect', color='tab:red')
            axis.set_title(case['set'])
            axis.set_xlabel('overlap, %')
            axis.set_ylabel('pairs')
            axis.set_xlim(10, 100)
        for axis in axes.flat[len(cases):]:
            axis.set_visible(False)
        if cases:
            axes.flat[0].legend(frameon=False)
        saved(figure, path)


EXPERIMENT = Experiment(
    'fig5', 'Fig. 5: correct pairs by overlap',
    'The same run as Fig. 4: correct (accepted, within 5 degrees and 5 dres) of the evaluated '
    'pairs whose overlap lies in each tenth; the others are refused, ambiguous or wrong. *Wrong '
    'accepted*: of all pairs, those that overlap by less included.',
    engine_cases, show, plot, without_sets)
