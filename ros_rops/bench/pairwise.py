# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `pairwise`: every pair of views of a data set registered by itself."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ros_rops.bench.contest import (
    Contestant, cross_pairs, engine, errors_in, PairRecord, prepare_all, run_pairs)
from ros_rops.bench.evaluation import evaluate_pairs, OVERLAP_BINS, PairTruth
from ros_rops.bench.scores import details, scores
from ros_rops.bench.settings import (
    add_common_arguments, config_of, load_all, MODES, report, SEED,
    teller)
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet

Tell = Callable[[str], None]


def run_set(
    dataset: ReferenceSet, contestant: Contestant, pairs: Sequence[PairTruth], tell: Tell
) -> tuple[dict[str, Any], list[PairRecord]]:
    """
    Register all pairs i < j of a data set.

    Parameters
    ----------
    dataset : ReferenceSet
    contestant : Contestant
    pairs : sequence of PairTruth
        All pairs of the set (`evaluate_pairs`), which several contestants share.
    tell : callable
        Told the progress.

    Returns
    -------
    dict
        The numbers of `scores` and every pair.
    list of PairRecord
    """
    prepared = prepare_all(contestant, dataset.views, tell)
    records = run_pairs(contestant, pairs, prepared, errors_in(dataset), tell)
    numbers = {
        'case': 'pairwise', 'dataset': dataset.name, 'by': contestant.name,
        **scores(records, prepared), 'details': details(records),
    }
    return numbers, records


def run_cross(
    sets: Sequence[ReferenceSet], contestant: Contestant, tell: Tell
) -> list[dict[str, Any]]:
    """Register all pairs of views of different sets in the same units; none may be accepted."""
    cases = []
    for name, views, pairs in cross_pairs(sets):
        prepared = prepare_all(contestant, views, tell)
        records = run_pairs(contestant, pairs, prepared, lambda pair, T: None, tell)
        cases.append({
            'case': 'pairwise', 'dataset': name, 'by': contestant.name, 'cross': True,
            **scores(records, prepared), 'details': details(records),
        })
    return cases


def pairwise_table(cases: Sequence[Mapping[str, Any]]) -> str:
    """Return the table that `rops bench pairwise` prints."""
    rows = []
    for case in cases:
        low, middle, high = (
            f'{_count(case, key)}/{case["pairs_by_overlap"][key]}' for key in OVERLAP_BINS)
        rows.append([
            case['dataset'], case['by'], case['mode'], case['seed'],
            f'{case["correct"]}/{case["pairs"]}', case['recall'], low, middle, high,
            case['accepted'], len(case['wrong_accepted']), case['pairs_all'],
            case['rotation_deg'], case['translation_dres'], case['seconds_prepare'],
            case['seconds_per_pair']])
    return table(
        ['dataset', 'by', 'mode', 'seed', 'correct', 'recall', *OVERLAP_BINS, 'accepted',
         'wrong', 'of', 'deg', 'dres', 's/view', 's/pair'], rows)


def _count(case: Mapping[str, Any], key: str) -> int:
    recall: float = case['recall_by_overlap'][key] or 0.0
    return round(recall * int(case['pairs_by_overlap'][key]))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench pairwise`."""
    add_common_arguments(parser)
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument(
        '--features-only', dest='mode', action='store_const', const='features-only',
        default='default', help='no random starts, at most 20 candidates refined')
    mode.add_argument(
        '--control', dest='mode', action='store_const', const='control',
        help='random starts only, at most 20 candidates refined')
    parser.add_argument(
        '--cross', action='store_true',
        help='pairs of views of different data sets (in the same units) instead')
    parser.add_argument(
        '--seed', type=int, nargs='+', default=[0], help='seeds of the engine, one run each')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench pairwise`; returns the exit code."""
    tell = teller(args)
    configs = [config_of(args, {**MODES[args.mode], SEED: seed}) for seed in args.seed]
    sets = load_all(args.datasets, tell)
    pairs = {} if args.cross else {one.name: evaluate_pairs(one) for one in sets}
    cases = []
    for seed, config in zip(args.seed, configs, strict=True):
        contestant = engine(config, threads=args.threads)
        marks = {'mode': args.mode, 'seed': seed}
        if args.cross:
            cases += [{**case, **marks} for case in run_cross(sets, contestant, tell)]
            continue
        for one in sets:
            numbers, _ = run_set(one, contestant, pairs[one.name], tell)
            cases.append({**numbers, **marks})
    report(args, cases, pairwise_table(cases))
    return 0
