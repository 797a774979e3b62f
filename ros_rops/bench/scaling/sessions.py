# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""One session measured: seconds, memory of its own, registrations, what was placed."""

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
import multiprocessing
from pathlib import Path
import resource
import time
from typing import Any

import numpy as np
from ros_rops.bench.evaluate import evaluate
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.machine import peak_rss_mib
from ros_rops.bench.multiview import engine_session, Job, run_of, shuffled
from ros_rops.bench.resolution import mesh_resolution
from ros_rops.bench.synthetic import known_captures
from ros_rops.recordings.synthetic import Capture

# Of everybody's code and tables that the first registration loads.
WARM_UP_VIEWS = 2
TIMES = ('seconds', 'seconds_add', 'seconds_finish', 'cpu_seconds')


def session_job(captures: Sequence[Capture], laboratory: Laboratory) -> Job:
    """Return the session over captures of some objects, in a random order."""
    dres = float(np.mean([mesh_resolution(one.view) for one in captures]))
    return Job(
        tuple(dict.fromkeys(one.object_name for one in captures)), f'seed {laboratory.seed}',
        shuffled([one.view for one in captures], laboratory.seed),
        known_captures(list(captures), dres), laboratory.config, laboratory.threads,
        case='scaling')


def measured(job: Job, repeats: int) -> dict[str, Any]:
    """Measure a session in processes of its own; of repeated times the medians count."""
    context = multiprocessing.get_context('spawn')
    cases = []
    for _ in range(max(repeats, 1)):
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            cases.append(pool.submit(measure, job).result())
    return cases[0] | {
        name: float(np.median([case[name] for case in cases])) for name in TIMES}


def measure(job: Job) -> dict[str, Any]:
    """
    Run a session warm and judge it.

    Returns
    -------
    dict
        Plain JSON values. `session_mib`: how far the peak of the process lies above what it held,
        views included, when the session began.
    """
    warm_up(job)
    before = resident_mib()
    session = engine_session(job)
    start, start_cpu = time.perf_counter(), time.process_time()
    for view in job.views:
        session.add(view)
    added = time.perf_counter()
    session.finish()
    end, cpu = time.perf_counter(), time.process_time() - start_cpu
    peak = peak_rss_mib()
    numbers = evaluate(run_of(session, job), job.known, residuals=False).numbers()
    return {
        'objects': len(job.datasets), 'names': list(job.datasets),
        'points_per_view': float(np.mean([len(view.points) for view in job.views])),
        **{name: numbers[name] for name in (
            'views', 'placed', 'wrong_placements', 'wrong_merges', 'splits',
            'max_rotation_deg', 'max_translation_dres', 'attempts')},
        'attempts_by_word': dict(Counter(one.status.value for one in session.trace)),
        'seconds': end - start, 'seconds_add': added - start, 'seconds_finish': end - added,
        'cpu_seconds': cpu, 'stage_seconds': dict(session.stage_seconds),
        'peak_rss_mib': peak, 'session_mib': peak - before}


def warm_up(job: Job) -> None:
    """Register two views before anything is measured."""
    session = engine_session(job)
    for view in job.views[:WARM_UP_VIEWS]:
        session.add(view)
    session.finish()


def resident_mib() -> float:
    """Return the memory that this process holds now, in MiB; its peak where nobody tells that."""
    try:
        pages = int(Path('/proc/self/statm').read_text(encoding='utf-8').split()[1])
        return pages * resource.getpagesize() / 2**20
    except (OSError, ValueError, IndexError):
        return peak_rss_mib()
