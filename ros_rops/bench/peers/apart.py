# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A process of its own for each contestant: its memory, its libraries, so many processors."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
import importlib
import multiprocessing
import os
from typing import Any

from ros_rops.bench.machine import peak_rss_mib


@contextmanager
def processors(threads: int) -> Iterator[None]:
    """
    Let what is started inside use `threads` processors at most, 0 for all there are.

    Libraries that take no number of threads look at the processors they may run on.
    """
    if threads <= 0 or not hasattr(os, 'sched_setaffinity'):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(before)[:threads])
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def run_apart(
    run: Callable[[Any], Any], job: Any, *, modules: Sequence[str], threads: int
) -> tuple[Any, float]:
    """
    Run a function of a module in a fresh process.

    Parameters
    ----------
    run : callable
        Of `job`; both are sent there.
    job : object
    modules : sequence of str
        Imported first.
    threads : int
        0 takes all cores.

    Returns
    -------
    object
        What `run` returned.
    float
        MiB of that process with its libraries, before it had any data.
    """
    context = multiprocessing.get_context('spawn')
    with processors(threads), ProcessPoolExecutor(1, mp_context=context) as pool:
        libraries = pool.submit(imported, tuple(modules)).result()
        return pool.submit(run, job).result(), libraries


def imported(modules: tuple[str, ...]) -> float:
    """Import modules; returns the peak memory in MiB afterwards."""
    for name in modules:
        importlib.import_module(name)
    return peak_rss_mib()
