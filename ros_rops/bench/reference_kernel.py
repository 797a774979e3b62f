# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
A fixed piece of work that other seconds are divided by, so that machines can be compared.

It does what the engine does most: looks up memory in an order that no cache foresees, searches,
and calculates with floats; one thread. It is NumPy's alone, so that no change of ours, of the
engine or of the way it is compiled, can change it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
import time
from typing import Any

import numpy as np
from ros_rops.bench.machine import machine_facts
from ros_rops.core.types import Floats, Ints

RUNS = 7
_TABLE, _LOOK_UPS, _SORTED, _SEARCHES, _SUMS, _ROUNDS = (
    1 << 21, 200_000, 1 << 19, 20_000, 1 << 13, 300)


@dataclass(frozen=True, slots=True, eq=False)
class _Work:
    """What is looked up and calculated with, and room for the results."""

    table: Floats
    places: Ints
    found: Floats
    ordered: Floats
    keys: Floats
    numbers: Floats
    one: Floats
    other: Floats


@lru_cache(maxsize=1)
def _work() -> _Work:
    rng = np.random.default_rng(0)
    numbers = rng.random(_SUMS)
    return _Work(
        rng.random(_TABLE), rng.integers(0, _TABLE, _LOOK_UPS), np.empty(_LOOK_UPS),
        np.sort(rng.random(_SORTED)), rng.random(_SEARCHES), numbers, np.empty_like(numbers),
        np.empty_like(numbers))


def run_kernel() -> float:
    """Do the work once; returns a number that depends on all of it."""
    work = _work()
    work.table.take(work.places, out=work.found, mode='clip')
    found = np.searchsorted(work.ordered, work.keys)
    for _ in range(_ROUNDS):
        np.multiply(work.numbers, 1.0000001, out=work.one)
        np.add(work.one, work.numbers, out=work.other)
        np.sqrt(work.other, out=work.one)
        np.minimum(work.one, work.other, out=work.other)
    return float(work.found.sum() + found.sum() + work.other.sum())


def kernel_seconds(runs: int = RUNS) -> tuple[list[float], list[float]]:
    """Return the wall seconds and the CPU seconds of so many runs, after one that counts not."""
    run_kernel()
    wall, cpu = [], []
    for _ in range(runs):
        start, start_cpu = time.perf_counter(), time.thread_time()
        run_kernel()
        wall.append(time.perf_counter() - start)
        cpu.append(time.thread_time() - start_cpu)
    return wall, cpu


def measured_machine() -> Mapping[str, Any]:
    """Return `machine_facts` with `reference_seconds` and `reference_cpu_seconds`, each run."""
    wall, cpu = kernel_seconds()
    return {**machine_facts(), 'reference_seconds': wall, 'reference_cpu_seconds': cpu}
