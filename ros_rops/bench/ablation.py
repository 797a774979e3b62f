# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `ablation`: each choice of ours exchanged for the paper's, one at a time."""

import argparse
from collections.abc import Mapping, Sequence
from typing import Any

from ros_rops.bench.ablation_variants import GROUPS, Variant
from ros_rops.bench.contest import errors_in, PairRecord, prepare_all, Prepared, run_pairs
from ros_rops.bench.evaluation import overlap_bin, OVERLAP_BINS, PairTruth
from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.laboratory import add_laboratory_arguments, run_laboratory
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet

# Pairs that overlap by more tell little: the paper's choices together find all of the four sets.
EASY_OVERLAP = 0.6
# Pairs of a set that do not overlap enough, at most; all of them are to be refused.
UNRELATED = 15
# Overlaps of the pairs that count.
BINS = tuple(key for key, (_, high) in OVERLAP_BINS.items() if high <= EASY_OVERLAP)

ABOUT = f"""Every choice that the paper made otherwise, exchanged alone; parameters in
`ros_rops/bench/ablation_variants.py`. Counted is what is correct and accepted, of the pairs that
overlap by 0.1 to {EASY_OVERLAP} (beyond, even all of the paper's together find every pair of the
four sets). *wrong*: accepted but not correct, of these and of {UNRELATED} pairs a set that overlap
less, evenly spread. *time*: wall seconds of all pairs as a multiple of ours in the same run;
*prepare*: the same for the preparation of the views. Random starts make up for much that features
lose, so choices about features are measured on **RoPS alone** (no random starts, at most 20 poses
refined), those about the search on the **whole engine**."""


def chosen_pairs(pairs: Sequence[PairTruth]) -> list[PairTruth]:
    """Return the pairs that count and `UNRELATED` of those without overlap, evenly spread."""
    evaluated = [pair for pair in pairs if overlap_bin(pair.overlap) in BINS]
    others = [pair for pair in pairs if not pair.evaluated]
    count = min(UNRELATED, len(others))
    return evaluated + [others[k * len(others) // count] for k in range(count)]


def run_ablation(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Register the chosen pairs of every set by every variant."""
    return [case for dataset in laboratory.sets for case in _run_set(laboratory, dataset)]


def _run_set(laboratory: Laboratory, dataset: ReferenceSet) -> list[dict[str, Any]]:
    pairs = chosen_pairs(laboratory.pairs(dataset))
    prepared: dict[object, Prepared] = {}
    cases = []
    for group, (changes, variants) in GROUPS.items():
        for variant in variants:
            contestant = variant.contestant(
                laboratory.config, changes, threads=laboratory.threads)
            key = variant.preparation()
            if key not in prepared:
                prepared[key] = prepare_all(contestant, dataset.views, laboratory.tell)
            records = run_pairs(
                contestant, pairs, prepared[key], errors_in(dataset), laboratory.tell)
            cases.append(_case(group, variant, dataset.name, records, prepared[key]))
    return cases


def _case(
    group: str, variant: Variant, dataset: str, records: Sequence[PairRecord],
    prepared: Prepared,
) -> dict[str, Any]:
    evaluated = [record for record in records if record.truth.evaluated]
    binned = {
        key: [r for r in evaluated if overlap_bin(r.truth.overlap) == key]
        for key in BINS}
    return {
        'group': group, 'variant': variant.label, 'changes': dict(variant.changes),
        'dataset': dataset, 'pairs': len(evaluated),
        'right': sum(record.correct for record in evaluated),
        'pairs_by_overlap': {key: len(part) for key, part in binned.items()},
        'right_by_overlap': {
            key: sum(record.correct for record in part) for key, part in binned.items()},
        'unrelated': len(records) - len(evaluated),
        'wrong': sum(record.accepted and not record.correct for record in records),
        'seconds': sum(record.seconds for record in records),
        'seconds_prepare': sum(prepared.seconds.values()), 'views': len(prepared.seconds),
    }


def show_ablation(cases: Sequence[Case]) -> str:
    """Return a table for each group of variants."""
    groups = dict.fromkeys(str(case['group']) for case in cases)
    return '\n'.join(
        f'{group}:\n\n{_group_table([case for case in cases if case["group"] == group])}'
        for group in groups)


def _group_table(cases: Sequence[Case]) -> str:
    datasets = list(dict.fromkeys(case['dataset'] for case in cases))
    variants: dict[str, list[Case]] = {}
    for case in cases:
        variants.setdefault(case['variant'], []).append(case)
    ours = next(iter(variants.values()))
    return table(
        [cases[0]['group'], *datasets, 'together', *BINS, 'wrong', 'time', 'prepare'],
        [_row(label, part, ours) for label, part in variants.items()])


def _row(label: str, cases: Sequence[Case], ours: Sequence[Case]) -> list[object]:
    bins = [
        f'{sum(case["right_by_overlap"][key] for case in cases)}/'
        f'{sum(case["pairs_by_overlap"][key] for case in cases)}' for key in BINS]
    checked = _sum(cases, 'pairs') + _sum(cases, 'unrelated')
    return [
        label, *(f'{case["right"]}/{case["pairs"]}' for case in cases),
        f'{_sum(cases, "right"):.0f}/{_sum(cases, "pairs"):.0f}', *bins,
        f'{_sum(cases, "wrong"):.0f}/{checked:.0f}', _ratio(cases, ours, 'seconds'),
        _ratio(cases, ours, 'seconds_prepare')]


def _sum(cases: Sequence[Mapping[str, Any]], key: str) -> float:
    return float(sum(case[key] for case in cases))


def _ratio(cases: Sequence[Case], ours: Sequence[Case], key: str) -> str:
    whole = _sum(ours, key)
    return f'{_sum(cases, key) / whole:.2f}' if whole else '-'


EXPERIMENTS: tuple[Experiment, ...] = (
    Experiment('ablation', "Our choices exchanged for the paper's", ABOUT, run_ablation,
               show_ablation),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench ablation`."""
    add_laboratory_arguments(parser, EXPERIMENTS, count='+')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench ablation`; returns the exit code."""
    return run_laboratory('ablation', args, EXPERIMENTS)
