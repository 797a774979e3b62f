# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Case `short`: a minute's measurement of everything, held against a stored one.

Views of two procedural objects, rendered when asked for, with noise, their poses exact: every pair
with the defaults and with RoPS alone, and all views mixed in one session. Counts and errors are
compared as they are; CPU seconds by their ratio to a reference kernel run beside each measurement,
so that neither another machine nor a loaded one matters.

    rops bench short --against test/baseline/short.json     what is worse than the stored one
    rops bench short --json test/baseline/short.json        store a new one: to be committed with
                                                            the change that makes it differ
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
import sys
import time
from typing import Any

import numpy as np
from ros_rops.bench.compare import compare, compare_table, worse
from ros_rops.bench.compare_cases import Measured, read_measured
from ros_rops.bench.compare_verdicts import Judge
from ros_rops.bench.contest import Contestant, engine, errors_in, prepare_all, run_pairs
from ros_rops.bench.evaluation import evaluate_pairs, PairTruth
from ros_rops.bench.multiview import make_jobs, run_apart
from ros_rops.bench.paper.rendered import rendered_set
from ros_rops.bench.reference_kernel import kernel_seconds, measured_machine
from ros_rops.bench.scores import details, scores
from ros_rops.bench.settings import (
    add_common_arguments, config_of, derive, MODES, plain, report, SEED, teller)
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.recordings.simulate_models import read_models

Tell = Callable[[str], None]
OBJECTS = ('procedural:blob', 'procedural:bracket')
VIEWS, STEP_DEG, PIXELS, NOISE_MR = 7, 25.0, 220, 0.3
SHORT_MODES = ('default', 'features-only')
SLOWER = 0.3
"""Medians of CPU seconds over the kernel's scattered by less than half of it (test/baseline)."""
# Kept of a session: what does not depend on how busy the machine is.
_SESSION = (
    'views', 'placed', 'wrong_views', 'wrong_merges', 'splits', 'max_rotation_deg',
    'max_translation_dres', 'errors', 'attempts', 'cpu_seconds', 'peak_rss_mib')
_PAIR = ('source', 'target', 'overlap', 'status', 'reason', 'correct', 'errors')


class Stopwatch:
    """
    CPU seconds of calls, each beside those of the reference kernel.

    The kernel runs right before, so that both find the machine as busy.
    """

    def __init__(self) -> None:
        self.readings: list[dict[str, float]] = []

    def timed(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """Return `call` with its time taken whenever it is made."""
        def measured(*given: Any) -> Any:
            _, cpu = kernel_seconds(1)
            start = time.process_time()
            result = call(*given)
            self.readings.append({
                'cpu_seconds': time.process_time() - start, 'reference_seconds': cpu[0]})
            return result

        return measured


def run_pairwise(
    dataset: ReferenceSet, pairs: Sequence[PairTruth], mode: str, config: Config, *,
    threads: int, tell: Tell,
) -> list[dict[str, Any]]:
    """Return the case of the views' preparation and that of all pairs."""
    ours = engine(derive(config, MODES[mode]), threads=threads)
    views, registered = Stopwatch(), Stopwatch()
    contestant = Contestant(ours.name, views.timed(ours.prepare), registered.timed(ours.register))
    prepared = prepare_all(contestant, dataset.views, tell)
    records = run_pairs(contestant, pairs, prepared, errors_in(dataset), tell)
    marks = {'case': 'short', 'dataset': dataset.name, 'by': ours.name, 'mode': mode}
    found = [
        {**{key: one[key] for key in _PAIR}, **reading}
        for one, reading in zip(details(records), registered.readings, strict=True)]
    return [
        {**marks, 'what': 'views', 'details': [
            {'view': name, **reading}
            for name, reading in zip(dataset.views, views.readings, strict=True)]},
        {**marks, 'what': 'pairs', **_without_seconds(scores(records, prepared)),
         'details': found}]


def _without_seconds(numbers: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in numbers.items() if 'seconds' not in key}


def run_session(
    sets: Sequence[ReferenceSet], config: Config, *, seed: int, threads: int, tell: Tell
) -> dict[str, Any]:
    """Return the case of all views mixed in one session, in a process of its own."""
    tell('all views in one session')
    job, = make_jobs(sets, config, orders=1, seed=seed, threads=threads)
    before = kernel_seconds()[1]
    found = run_apart(job)
    return {
        'case': 'short', 'what': 'session', 'by': found['by'], 'datasets': found['datasets'],
        **{key: found[key] for key in _SESSION},
        'reference_seconds': float(np.median(before + kernel_seconds()[1]))}


def run_short(config: Config, *, seed: int, threads: int, tell: Tell) -> list[dict[str, Any]]:
    """Return all cases."""
    sets = [
        rendered_set(
            model, views=VIEWS, step_deg=STEP_DEG, noise_mr=NOISE_MR, seed=seed, pixels=PIXELS)
        for model in read_models(OBJECTS, size=0.2)]
    cases = []
    for one in sets:
        pairs = evaluate_pairs(one, threads=1)
        for mode in SHORT_MODES:
            cases += run_pairwise(one, pairs, mode, config, threads=threads, tell=tell)
    return [*cases, run_session(sets, config, seed=seed, threads=threads, tell=tell)]


def short_table(cases: Sequence[Mapping[str, Any]]) -> str:
    """Return the table that `rops bench short` prints; times in runs of the reference kernel."""
    rows = []
    for case in cases:
        if case['what'] == 'session':
            rows.append([
                ' + '.join(case['datasets']), 'session', f'{case["placed"]}/{case["views"]}',
                len(case['wrong_views']) + case['wrong_merges'],
                case['max_rotation_deg'], case['max_translation_dres'], case['attempts'],
                case['cpu_seconds'] / case['reference_seconds'], round(case['peak_rss_mib'])])
            continue
        times = [one['cpu_seconds'] / one['reference_seconds'] for one in case['details']]
        pairs = case['what'] == 'pairs'
        rows.append([
            case['dataset'], f'{case["what"]}, {case["mode"]}',
            f'{case["correct"]}/{case["pairs"]}' if pairs else None,
            len(case['wrong_accepted']) if pairs else None,
            case.get('rotation_deg'), case.get('translation_dres'),
            case.get('pairs_all'), float(np.median(times)), None])
    return table(
        ['data', 'what', 'right', 'wrong', 'deg', 'dres', 'attempts', 'kernels', 'MiB'], rows)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench short`."""
    add_common_arguments(parser, count=None)
    parser.add_argument(
        '--against', type=Path, metavar='FILE',
        help='stored by --json: say what is worse, any right answer lost included; exit code 1')
    parser.add_argument(
        '--slower', type=float, default=SLOWER, metavar='SHARE',
        help=f'how much more CPU time, in units of the kernel, is noise (default: {SLOWER})')
    parser.add_argument('--seed', type=int, default=0, help='of poses, noise and the order')
    parser.set_defaults(threads=1)


def run(args: argparse.Namespace) -> int:
    """Run `rops bench short`; returns 0, or 1 if something is worse than `--against`."""
    stored = read_measured(args.against) if args.against else None
    tell = teller(args)
    cases = run_short(
        config_of(args, {SEED: args.seed}), seed=args.seed, threads=args.threads, tell=tell)
    facts = {key: value for key, value in measured_machine().items() if key != 'system'}
    report(args, cases, short_table(cases), facts=facts)
    if stored is None:
        return 0
    here = Measured('this run', facts, plain(cases))
    lines = compare(stored, here, Judge(stored.machine, facts, True, args.slower))
    sys.stdout.write(f'\n{compare_table(lines, everything=False)}')
    return int(worse(lines, strict=True))
