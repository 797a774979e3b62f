# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Errors of correct pairs as histograms: how many lie below, and the bars."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from ros_rops.bench.experiment import Case
from ros_rops.bench.paper.drawing import drawing, saved
from ros_rops.bench.paper.engine_pairs import correct_errors
from ros_rops.bench.table import table

LIMITS = (0.25, 0.5, 1.0, 2.0)
BIN = 0.25
MOST = 5.0


def below(values: Sequence[float], limits: Sequence[float] = LIMITS) -> list[int]:
    """Count the values below each limit."""
    return [int(np.count_nonzero(np.asarray(values) < limit)) for limit in limits]


def bars(values: Sequence[float]) -> list[int]:
    """Count the values in bins of `BIN` from 0 to `MOST`, each without its upper end."""
    edges = BIN * np.arange(1, round(MOST / BIN) + 1)
    found = np.searchsorted(edges, values, side='right')
    counts = np.bincount(found[found < len(edges)], minlength=len(edges))
    return [int(count) for count in counts]


def error_table(cases: Sequence[Case]) -> str:
    """Return, for each set, means and how many correct pairs err by less than each limit."""
    errors = {case['set']: correct_errors(case) for case in cases}
    rows = [_row(name, one) for name, one in errors.items()]
    if len(rows) > 1:
        rows.append(_row('together', [pair for one in errors.values() for pair in one]))
    heads = [f'< {limit:g}' for limit in LIMITS]
    return table(
        ['set', 'correct', 'mean deg', *(f'{head} deg' for head in heads), 'mean dres',
         *(f'{head} dres' for head in heads)], rows)


def _row(name: str, errors: Sequence[tuple[float, float]]) -> list[object]:
    cells: list[object] = [name, len(errors)]
    for side in (0, 1):
        values = [pair[side] for pair in errors]
        cells += [float(np.mean(values)) if values else None, *below(values)]
    return cells


def plot_errors(cases: Sequence[Case], path: Path) -> None:
    """Draw both histograms of all sets, one upon the other."""
    errors: Mapping[str, list[tuple[float, float]]] = {
        case['set']: correct_errors(case) for case in cases}
    with drawing(columns=2) as (figure, axes):
        for side, name in enumerate(('rotation error, degrees', 'translation error, dres')):
            axis, low = axes.flat[side], np.zeros(round(MOST / BIN))
            for label, pairs in errors.items():
                height = np.array(bars([pair[side] for pair in pairs]))
                axis.bar(BIN * np.arange(len(low)), height, BIN, low, align='edge', label=label)
                low += height
            axis.set_xlabel(name)
            axis.set_ylabel('correct pairs')
            axis.set_xlim(0.0, MOST)
        if cases:
            axes.flat[0].legend(frameon=False)
        saved(figure, path)
