# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `multiview`: unordered views of one or several data sets through one `Session`."""

import argparse
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
import multiprocessing
import time
from typing import Any

import numpy as np
from ros_rops.bench.evaluate import evaluate, known_views, KnownView
from ros_rops.bench.judgement import Placement
from ros_rops.bench.machine import peak_rss_mib
from ros_rops.bench.run_folder import Run
from ros_rops.bench.settings import (
    add_common_arguments, config_of, load_all, report, SEED, teller)
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.core.types import RangeView, Units


@dataclass(frozen=True, slots=True)
class Job:
    """
    One session to run, in a process of its own.

    Parameters
    ----------
    datasets : tuple of str
        Names of the sets.
    order : str
        What the table calls the order.
    views : tuple of RangeView
        Named 'set/view', in the order in which they are added.
    known : mapping of str to KnownView
    config : Config
    threads : int
    case : str
    """

    datasets: tuple[str, ...]
    order: str
    views: tuple[RangeView, ...]
    known: Mapping[str, KnownView]
    config: Config
    threads: int
    case: str = 'multiview'

    @property
    def units(self) -> Units:
        """Units of the session: those of the first view."""
        return self.views[0].units


def named_views(sets: Sequence[ReferenceSet]) -> list[RangeView]:
    """Return all views of the sets, named 'set/view', which no two sets share."""
    return [
        replace(view, name=f'{one.name}/{name}')
        for one in sets for name, view in one.views.items()
    ]


def shuffled(views: Sequence[RangeView], seed: int) -> tuple[RangeView, ...]:
    """Return the views in the random order of a seed."""
    order = np.random.default_rng(seed).permutation(len(views))
    return tuple(views[k] for k in order)


def make_jobs(
    sets: Sequence[ReferenceSet], config: Config, *, orders: int, seed: int, threads: int
) -> list[Job]:
    """Return one job for each random order, or one for the natural order where `orders` is 0."""
    views = named_views(sets)
    sequences = {f'seed {seed + k}': shuffled(views, seed + k) for k in range(orders)}
    known = known_views(sets)
    names = tuple(one.name for one in sets)
    return [
        Job(names, order, sequence, known, config, threads)
        for order, sequence in (sequences or {'given': tuple(views)}).items()
    ]


def engine_session(job: Job) -> Any:
    """Return the engine's own session for a job."""
    from ros_rops.pipeline.session import Session

    return Session(job.config, threads=job.threads, units=job.units)


def run_job(
    job: Job, open_session: Callable[[Job], Any] = engine_session, *, coarse: bool = False,
    residuals: bool = True,
) -> dict[str, Any]:
    """
    Run one session and judge it; peak memory is read before the judging.

    Parameters
    ----------
    job : Job
    open_session : callable
        Makes what has the methods of `Session`.
    coarse : bool
        Judge the grown shapes too, before their fine registration: `coarse` holds the numbers.
    residuals : bool
        Measure the residual too, which takes seconds.

    Returns
    -------
    dict
        The numbers of the case as plain JSON values.
    """
    session = open_session(job)
    start, start_cpu = time.perf_counter(), time.process_time()
    for view in job.views:
        session.add(view)
    added = time.perf_counter()
    grown = None
    if coarse:
        session.settle()
        grown = run_of(session, job)
    session.finish()
    seconds, cpu = time.perf_counter() - start, time.process_time() - start_cpu
    peak = peak_rss_mib()
    found = run_of(session, job)
    evaluation = evaluate(found, job.known, residuals=residuals)
    before = {} if grown is None else {
        'coarse': evaluate(grown, job.known, residuals=residuals).numbers()}
    return {
        'case': job.case, 'by': 'ros_rops', 'datasets': list(job.datasets), 'order': job.order,
        **evaluation.numbers(), 'seconds': seconds, 'seconds_add': added - start,
        'seconds_finish': seconds - (added - start), 'cpu_seconds': cpu, 'peak_rss_mib': peak,
        'shapes': dict(Counter(p.shape for p in found.placements.values())),
        'sequence': [view.name for view in job.views], **before,
    }


def run_of(session: Any, job: Job) -> Run:
    """Return what `poses.json` of the session would say."""
    placements = {
        view.name: Placement(str(shape.id), np.asarray(view.T_object_view))
        for shape in session.objects for view in shape.views
    }
    statuses = {
        view.name: 'placed' if view.name in placements else 'pending' for view in job.views
    }
    return Run(
        units=job.units, mesh_resolution=session.mesh_resolution, placements=placements,
        statuses=statuses, centroids={}, attempts=session.attempts)


def run_apart(
    job: Job, open_session: Callable[[Job], Any] = engine_session, *, coarse: bool = False,
) -> dict[str, Any]:
    """Run a job in a fresh process, so that no other job's memory counts; as `run_job`."""
    context = multiprocessing.get_context('spawn')
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(run_job, job, open_session, coarse=coarse).result()


def run_all(jobs: Sequence[Job], tell: Callable[[str], None]) -> list[dict[str, Any]]:
    """Run jobs one after another, each in a process of its own."""
    cases = []
    for number, job in enumerate(jobs):
        tell(f'session {number + 1} of {len(jobs)}: {" + ".join(job.datasets)}, {job.order}')
        cases.append(run_apart(job))
    return cases


def multiview_table(cases: Sequence[Mapping[str, Any]]) -> str:
    """Return the table that `rops bench multiview` prints."""
    rows = []
    for case in cases:
        residuals = [o['residual_dres'] for o in case['objects'] if o['residual_dres'] is not None]
        rows.append([
            ' + '.join(case['datasets']), case['by'], case['order'],
            f'{case["placed"]}/{case["views"]}',
            case['wrong_placements'], case['wrong_merges'], case['splits'],
            case['mean_rotation_deg'], case['max_rotation_deg'], case['mean_translation_dres'],
            case['max_translation_dres'], ' '.join(f'{value:.4f}' for value in residuals) or None,
            case['attempts'], case['seconds'],
            None if case['peak_rss_mib'] is None else round(case['peak_rss_mib'])])
    return table(
        ['datasets', 'by', 'order', 'placed', 'wrong', 'merges', 'splits', 'deg', 'max deg',
         'dres', 'max dres', 'residual', 'attempts', 's', 'MiB'], rows)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench multiview`."""
    add_common_arguments(parser)
    parser.add_argument(
        '--mixed', action='store_true', help='all data sets in one session, not one after another')
    parser.add_argument(
        '--orders', type=int, default=0, metavar='N',
        help='N random orders (default: the natural order)')
    parser.add_argument('--seed', type=int, default=0, help='seed of the first order')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench multiview`; returns the exit code."""
    tell = teller(args)
    config = config_of(args, {SEED: args.seed})
    sets = load_all(args.datasets, tell)
    groups = [sets] if args.mixed else [[one] for one in sets]
    jobs = [
        job for group in groups
        for job in make_jobs(
            group, config, orders=args.orders, seed=args.seed, threads=args.threads)
    ]
    cases = run_all(jobs, tell)
    report(args, cases, multiview_table(cases))
    return 0
