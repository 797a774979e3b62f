# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Experiment `peers_views`: all views of a set, ours and Open3D's all pairs with a pose graph."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import time
from typing import Any

import numpy as np
from ros_rops.bench.evaluate import evaluate
from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.judgement import Placement
from ros_rops.bench.machine import peak_rss_mib
from ros_rops.bench.multiview import Job, make_jobs, run_job
from ros_rops.bench.peers.apart import run_apart
from ros_rops.bench.peers.extras import open3d_missing
from ros_rops.bench.peers.open3d_views import multiway, Way
from ros_rops.bench.peers.roster import OURS
from ros_rops.bench.run_folder import Run
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet

EXACT, QUICK = 'Open3D all pairs + pose graph', 'the same, ICP on thinned clouds'
WAYS = {EXACT: Way(), QUICK: Way(thinned=True)}
NEEDS = ('open3d',)
MUST, AIM = {'residual': 1.0, 'seconds': 5.0}, {'residual': 0.97, 'seconds': 20.0}
NUMBERS = (
    'views', 'placed', 'wrong_placements', 'splits', 'mean_rotation_deg', 'max_rotation_deg',
    'mean_translation_dres', 'max_translation_dres', 'attempts', 'seconds', 'cpu_seconds',
    'peak_rss_mib')


@dataclass(frozen=True, slots=True)
class Whole:
    """A set for Open3D, and which of its ways."""

    job: Job
    dres: float
    by: str


def run_open3d(given: Whole) -> dict[str, Any]:
    """Register all views of a set with Open3D; returns the keys of `run_job`."""
    job = given.job
    start, start_cpu = time.perf_counter(), time.process_time()
    poses = multiway(job.views, given.dres, WAYS[given.by])
    seconds, cpu = time.perf_counter() - start, time.process_time() - start_cpu
    peak, count = peak_rss_mib(), len(job.views)
    names = [view.name for view in job.views]
    run = Run(
        job.units, given.dres,
        {name: Placement('0', T) for name, T in zip(names, poses, strict=True)},
        dict.fromkeys(names, 'placed'), {}, count * (count - 1) // 2)
    return {**evaluate(run, job.known).numbers(), 'seconds': seconds, 'cpu_seconds': cpu,
            'peak_rss_mib': peak}


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Measure ours and Open3D's ways on every set; Open3D missing is a line too."""
    absent = open3d_missing()
    cases: list[dict[str, Any]] = [{'by': 'Open3D', 'missing': absent}] if absent else []
    for dataset in laboratory.sets:
        job, = make_jobs(
            [dataset], laboratory.config, orders=0, seed=laboratory.seed,
            threads=laboratory.threads)
        laboratory.tell(f'{dataset.name}: {OURS}')
        cases.append(_case(
            dataset, OURS, laboratory, run_job, job, ('ros_rops.pipeline.session',)))
        for by in () if absent else WAYS:
            laboratory.tell(f'{dataset.name}: {by}')
            cases.append(_case(
                dataset, by, laboratory, run_open3d, Whole(job, dataset.dres, by), NEEDS))
    return cases


def _case(
    dataset: ReferenceSet, by: str, laboratory: Laboratory,
    work: Callable[[Any], dict[str, Any]], job: Any, modules: tuple[str, ...],
) -> dict[str, Any]:
    rounds = []
    for _ in range(laboratory.repeats):
        rounds.append(run_apart(work, job, modules=modules, threads=laboratory.threads))
    numbers, libraries = rounds[0]
    seconds = [found['seconds'] for found, _ in rounds]
    return {
        'set': dataset.name, 'by': by, **{key: numbers[key] for key in NUMBERS},
        'residual_dres': numbers['objects'][0]['residual_dres'],
        'seconds': float(np.median(seconds)), 'seconds_of_rounds': seconds,
        'libraries_mib': libraries}


def by_set(cases: Sequence[Case]) -> dict[str, dict[str, Case]]:
    """Return the lines of each set by contestant."""
    found: dict[str, dict[str, Case]] = {}
    for case in cases:
        if 'set' in case:
            found.setdefault(str(case['set']), {})[str(case['by'])] = case
    return found


def show(cases: Sequence[Case]) -> str:
    """Return the table of all sets."""
    rows = []
    for contestants in by_set(cases).values():
        ours = contestants.get(OURS)
        for case in contestants.values():
            against = _against(ours, case)
            rows.append([
                case['set'], case['by'], f'{case["placed"]}/{case["views"]}',
                case['wrong_placements'], case['mean_rotation_deg'], case['max_rotation_deg'],
                case['mean_translation_dres'], case['max_translation_dres'],
                case['residual_dres'], against.get('residual'), case['attempts'],
                case['seconds'], against.get('seconds'), round(case['peak_rss_mib']),
                round(case['libraries_mib'])])
    return table(
        ['set', 'by', 'placed', 'wrong', 'deg', 'max deg', 'dres', 'max dres', 'residual',
         'ours / its', 'registrations', 's', 'its s / ours', 'MiB', 'of it libraries'], rows)


def _against(ours: Case | None, case: Case) -> dict[str, float]:
    """Return our residual over a peer's, and its seconds over ours."""
    if ours is None or case['by'] == OURS:
        return {}
    found = {'seconds': case['seconds'] / ours['seconds']}
    if ours['residual_dres'] and case['residual_dres']:
        found['residual'] = ours['residual_dres'] / case['residual_dres']
    return found


def notes(cases: Sequence[Case]) -> list[str]:
    """Return what is missing, and for each set whether the numbers asked for are reached."""
    found = [str(case['missing']) for case in cases if 'missing' in case]
    for name, contestants in by_set(cases).items():
        if OURS not in contestants or EXACT not in contestants:
            continue
        against = _against(contestants[OURS], contestants[EXACT])
        for key, sign, unit in (('residual', -1.0, 'of its'), ('seconds', 1.0, 'times faster')):
            got = against.get(key)
            if got is not None and sign * got < sign * AIM[key]:
                missed = 'must' if sign * got < sign * MUST[key] else 'aim'
                limit = (MUST if missed == 'must' else AIM)[key]
                found.append(
                    f'{name}: {key} {got:.3f} {unit}, the {missed} of {limit:g} is not reached')
    return found


VIEWS = Experiment(
    'peers_views', 'Many views, against Open3D',
    'All views of a set into one object. Open3D: FPFH and RANSAC on all pairs, point-to-plane ICP '
    'on all points, then its pose graph, the most exact way that it has; and the same with ICP on '
    'the voxelized clouds, as in its tutorial, which is quicker. It places every view. '
    '*residual*: distance between overlapping surfaces, which needs no reference; *ours / its* '
    'must be 1, the aim is 0.97. *its s / ours* must be 5, the aim is 20. One process each, '
    'libraries imported before the clock starts; medians of the rounds.',
    run, show, notes=notes)
