# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Experiment `peers_pairs`: every pair of views by itself, ours and the peers'."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from ros_rops.bench.contest import PairRecord, Prepared
from ros_rops.bench.evaluation import overlap_bin, OVERLAP_BINS, PairTruth
from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.peers.extras import missing
from ros_rops.bench.peers.pair_run import PairJob, PairRounds, run_peer
from ros_rops.bench.peers.roster import OURS, ROSTER
from ros_rops.bench.scores import scores, share
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.errors import InputError

# What a peer says of its own answer; the sign says that more is better, or less.
OWN_SCORES = {'fitness': 1.0, 'inlier_rmse': -1.0, 'inliers': 1.0}
RECALL_BELOW, RECALL_MORE = 0.75, 0.2


def run(
    laboratory: Laboratory, names: Sequence[str] = tuple(ROSTER)
) -> list[dict[str, Any]]:
    """
    Measure the contestants of these names on all sets; who cannot take part is a line too.

    Raises
    ------
    InputError
        If a set has fewer than two views.
    """
    roster = {name: peer for name, peer in ROSTER.items() if name in (OURS, *names)}
    absent = {name: missing(name, peer.needs) for name, peer in roster.items()}
    cases: list[dict[str, Any]] = [
        {'by': name, 'missing': why} for name, why in absent.items() if why]
    for dataset in laboratory.sets:
        pairs = tuple(laboratory.pairs(dataset))
        if not pairs:
            raise InputError(f'{dataset.name}: expected at least two views, got one')
        ours: PairRounds | None = None
        for name, peer in roster.items():
            if absent[name]:
                continue
            laboratory.tell(f'{dataset.name}: {name}')
            rounds = run_peer(peer, PairJob(
                name, dataset, pairs, laboratory.config, laboratory.threads, laboratory.repeats))
            ours = rounds if name == OURS else ours
            cases.append(case_of(name, dataset, rounds, ours))
    return cases


def case_of(
    name: str, dataset: ReferenceSet, rounds: PairRounds, ours: PairRounds | None
) -> dict[str, Any]:
    """Return the line of one contestant on one set; `ours` is what it is held against."""
    records = rounds.records[0]
    numbers = scores(records, Prepared({}, {}))
    kept = {key: numbers[key] for key in (
        'pairs', 'pairs_all', 'correct', 'accepted', 'pairs_by_overlap', 'rotation_deg',
        'translation_dres', 'raw_translation_dres')}
    return {
        'set': dataset.name, 'by': name, **kept,
        'correct_by_overlap': {key: sum(
            one.correct and overlap_bin(one.truth.overlap) == key for one in records)
            for key in OVERLAP_BINS},
        'correct_of_rounds': [correct_evaluated(one) for one in rounds.records],
        'right_accepted': sum(one.correct for one in records),
        'missed': [pair_name(one.truth) for one in records
                   if one.truth.evaluated and not one.correct],
        'own_threshold': best_threshold(records),
        'seconds_view': float(np.median(rounds.seconds_of_views())),
        'seconds_pair': float(np.median(rounds.seconds_of_pairs())),
        'ratio': None if ours is None else ratio(ours.seconds(), rounds.seconds()),
        'peak_rss_mib': rounds.peak_rss_mib, 'libraries_mib': rounds.libraries_mib,
        'repeats': len(rounds.records),
    }


def pair_name(pair: PairTruth) -> str:
    """Return a pair in one word."""
    return f'{pair.name_i} > {pair.name_j}'


def correct_evaluated(records: Sequence[PairRecord]) -> int:
    """Count the evaluated pairs that are accepted and right."""
    return sum(one.correct and one.truth.evaluated for one in records)


def best_threshold(records: Sequence[PairRecord]) -> dict[str, Any] | None:
    """
    Return what a contestant could keep without a wrong pair, had it the best threshold.

    The threshold is chosen with the truth at hand, on that score of its own which serves it
    best: more than anybody has in the field.

    Returns
    -------
    dict or None
        "score" and "correct"; None where nothing is wrong, so that no threshold is wanted, or
        it gives no score.
    """
    accepted = [one for one in records if one.accepted]
    wrong = [one for one in accepted if not one.correct]
    right = [one for one in accepted if one.correct and one.truth.evaluated]
    found = []
    for score, sign in OWN_SCORES.items():
        if wrong and all(score in one.numbers for one in accepted):
            bar = max(sign * one.numbers[score] for one in wrong)
            found.append((sum(sign * one.numbers[score] > bar for one in right), score))
    if not found:
        return None
    correct, score = max(found)
    return {'score': score, 'correct': correct}


def ratio(ours: Sequence[float], theirs: Sequence[float]) -> dict[str, float]:
    """Return how many times our seconds a peer took: quartiles over the pairs, and in total."""
    each = np.array(theirs) / np.array(ours)
    lower, median, upper = (float(value) for value in np.quantile(each, (0.25, 0.5, 0.75)))
    return {
        'median': median, 'lower': lower, 'upper': upper,
        'total': float(np.sum(theirs) / np.sum(ours))}


def show(cases: Sequence[Case]) -> str:
    """Return the tables: recall and errors, then seconds and memory."""
    done = [case for case in cases if 'set' in case]
    recalls, costs = [], []
    for case in done:
        bins = case['correct_by_overlap'], case['pairs_by_overlap']
        own, accepted = case['own_threshold'], case['accepted']
        recalls.append([
            case['set'], case['by'], f'{case["correct"]}/{case["pairs"]}',
            share(case['correct'], case['pairs']),
            *(f'{bins[0][key]}/{bins[1][key]}' for key in OVERLAP_BINS),
            f'{accepted - case["right_accepted"]} of {accepted}',
            share(case['right_accepted'], accepted),
            f'{own["correct"]} by {own["score"]}' if own else None,
            case['rotation_deg'], case['translation_dres']])
        costs.append([
            case['set'], case['by'], case['seconds_view'], case['seconds_pair'],
            *_ratio_cells(case), round(case['peak_rss_mib']), round(case['libraries_mib'])])
    return (
        table(['set', 'by', 'correct', 'recall', *OVERLAP_BINS, 'wrong', 'precision',
               'at best threshold', 'deg', 'dres'], recalls) + '\n'
        + table(['set', 'by', 's/view', 's/pair', 'x ours, median', 'quartiles', 'in total',
                 'MiB', 'of it libraries'], costs))


def _ratio_cells(case: Case) -> list[str | None]:
    found = case['ratio']
    if case['by'] == OURS or found is None:
        return [None, None, None]
    return [f'{found["median"]:.2f}', f'{found["lower"]:.2f}-{found["upper"]:.2f}',
            f'{found["total"]:.2f}']


def notes(cases: Sequence[Case]) -> list[str]:
    """Return who is missing, what falls short of the numbers asked for, who varies."""
    found = [str(case['missing']) for case in cases if 'missing' in case]
    done = [case for case in cases if 'set' in case]
    for name in dict.fromkeys(case['set'] for case in done):
        here = [case for case in done if case['set'] == name]
        mine = [share(case['correct'], case['pairs']) for case in here if case['by'] == OURS]
        peers = [share(case['correct'], case['pairs']) or 0.0
                 for case in here if case['by'] != OURS]
        if mine and mine[0] is not None and peers:
            found += _verdict(str(name), mine[0], max(peers))
    found += [
        f'{case["set"]}, {case["by"]}: correct {case["correct_of_rounds"]} in the rounds'
        for case in done if len(set(case['correct_of_rounds'])) > 1]
    return found


def _verdict(name: str, mine: float, best: float) -> list[str]:
    wanted = best + RECALL_MORE if best < RECALL_BELOW else best
    if mine >= wanted - 1e-9:
        return []
    return [f'{name}: recall {mine:.3f}, best peer {best:.3f}, asked for {wanted:.3f}']


PAIRS = Experiment(
    'peers_pairs', 'Pairs, against other programs',
    'All pairs of a set, every contestant in a process of its own, one after the other in the '
    'same run, on as many processors. Peers: voxels of 2.5 dres, FPFH radius 15 dres '
    '(KISS-Matcher: 5 of its voxels, as it comes; lengths scaled so that its voxel is its '
    'default), then two rounds of ICP or GICP reaching 6 and 2.5 dres. *wrong*: accepted but not '
    'correct, of all accepted. Open3D accepts every pair; KISS-Matcher what it calls valid with '
    'five final inliers or more, the rule of its examples. *at best threshold*: correct pairs '
    'that a peer would keep were it thresholded, knowing the truth, by that one of its own scores '
    'that serves it best, with nothing wrong accepted. *x ours*: seconds of a pair with both '
    'views prepared over ours, pair by pair. Medians of the rounds; memory is the peak of the '
    'process, its libraries and all views included.',
    run, show, notes=notes)
