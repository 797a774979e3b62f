# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether one number became better or worse beyond noise, by its kind.

Wrong answers and work counted are compared as they are: the engine is deterministic, so that any
difference is one. Right answers known pair by pair are compared by McNemar's exact test, unless
asked to be strict; errors by a sign test over the pairs that both got right; seconds by the ratio
to the reference kernel of their own run.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
import math
from typing import Any

import numpy as np
from ros_rops.bench.compare_cases import Item, RELATIVE, Series
from ros_rops.bench.compare_kinds import Kind
from scipy.stats import binom

CHANCE = 0.05
"""Of a difference by luck: rarer ones are beyond noise."""
MANY = 6
"""So many values make an interval of their median; fewer only a range."""
SLOWER_MANY, SLOWER_FEW, SLOWER_ELSEWHERE = 0.15, 0.25, 0.40
"""How far medians of seconds, divided by the kernel's, drift by themselves."""
ERROR_SHARE, ERROR_LEAST = 0.10, 0.01
MEMORY_SHARE, MEMORY_LEAST = 0.15, 16.0
SHARE_LEAST = 0.005
COUNTLESS = 500
"""So many are features and the like, which rounding moves; fewer are pairs and views."""
NAMED = 4


class State(Enum):
    """What became of a number."""

    WORSE = 'worse'
    BETTER = 'better'
    SAME = 'same'
    UNKNOWN = 'not compared'
    ONLY_A = 'only in A'
    ONLY_B = 'only in B'


@dataclass(frozen=True, slots=True)
class Verdict:
    """
    What became of a number.

    Parameters
    ----------
    state : State
    a, b : str
        Its values.
    why : str
    changed : bool
        Worth a look, though the same within noise.
    """

    state: State
    a: str
    b: str
    why: str = ''
    changed: bool = False


@dataclass(frozen=True, slots=True)
class Judge:
    """
    How strictly numbers are judged.

    Parameters
    ----------
    machine_a, machine_b : mapping
        Facts of the machines, with the runs of the reference kernel.
    strict : bool
        Every right answer lost is worse: for the same data and seeds.
    slower : float or None
        By what share seconds, divided by the kernel's, may grow; None for what is usual here.
    """

    machine_a: Mapping[str, Any]
    machine_b: Mapping[str, Any]
    strict: bool = False
    slower: float | None = None

    def judge(self, kind: Kind, path: Sequence[str], a: Series, b: Series) -> Verdict:
        """Compare the series of a number; at least one value in each."""
        if kind is Kind.WRONG:
            return _wrong(a, b)
        if kind in (Kind.RIGHT, Kind.COST):
            return self._counted(kind, a, b)
        if kind is Kind.SECONDS:
            return self._seconds(path, a, b)
        limits = {Kind.ERROR: (ERROR_SHARE, ERROR_LEAST), Kind.SHARE: (0.0, SHARE_LEAST),
                  Kind.MEMORY: (MEMORY_SHARE, MEMORY_LEAST)}
        return _measured(kind, a, b, *limits[kind])

    def _counted(self, kind: Kind, a: Series, b: Series) -> Verdict:
        one, other = _paired(a, b)
        if kind is Kind.RIGHT and one and all(isinstance(v, bool) for v in (*one, *other)):
            return self._flags(a, b)
        up = State.WORSE if kind is Kind.COST else State.BETTER
        if len(one) > 1:
            return _repeated(one, other, up)
        values = float(np.sum(one)), float(np.sum(other))
        rise = values[1] - values[0]
        many = min(values) >= COUNTLESS and abs(rise) <= 2.6 * math.sqrt(sum(values))
        return Verdict(_state(0.0 if many else rise, up), *(f'{value:g}' for value in values))

    def _flags(self, a: Series, b: Series) -> Verdict:
        common = [item for item in a if item in b]
        lost = [item for item in common if a[item] and not b[item]]
        gained = [item for item in common if b[item] and not a[item]]
        counts = [f'{sum(bool(s[i]) for i in common)}/{len(common)}' for s in (a, b)]
        state, why = State.SAME, ''
        if lost or gained:
            chance = float(binom.sf(max(len(lost), len(gained)) - 1, len(lost) + len(gained), 0.5))
            beyond = chance <= CHANCE or self.strict
            state = _state(len(gained) - len(lost), State.BETTER) if beyond else State.SAME
            state = State.WORSE if self.strict and lost else state
            why = ', '.join(filter(None, [
                _listed('lost', lost), _listed('gained', gained), f'p = {chance:.2g}']))
        return Verdict(state, *counts, why, changed=bool(why))

    def _seconds(self, path: Sequence[str], a: Series, b: Series) -> Verdict:
        shown = [f'{_median(_values(series)):.3g}' for series in (a, b)]
        kernel, spread = (1.0, 0.0) if RELATIVE in path else self._kernel(path)
        if not kernel:
            return Verdict(
                State.UNKNOWN, *shown, 'no reference_seconds in ' + ' and '.join(
                    name for name, facts in (('A', self.machine_a), ('B', self.machine_b))
                    if not _runs(facts, 'reference_seconds')))
        one, other = (_positive(values) for values in _paired(a, b))
        if len(one) != len(other) or not len(one):
            return Verdict(State.UNKNOWN, *shown, 'no time measured')
        low, middle, high = interval(np.log(other / one) - math.log(kernel))
        limit = math.log1p(self._limit(len(one), spread))
        state = State.WORSE if low > limit else State.BETTER if high < -limit else State.SAME
        why = f'x {math.exp(middle):.2f}, limit x {math.exp(limit):.2f}'
        return Verdict(state, *shown, why if kernel == 1.0 else f'{why}, kernel x {kernel:.2f}')

    def _kernel(self, path: Sequence[str]) -> tuple[float, float]:
        """Return how much longer the kernel took in B, and its noise; zero if not known."""
        cpu = any('cpu' in name for name in path)
        key = 'reference_cpu_seconds' if cpu else 'reference_seconds'
        runs = [_runs(facts, key) for facts in (self.machine_a, self.machine_b)]
        if not all(runs):
            return 0.0, 0.0
        medians = [_median(values) for values in runs]
        spreads = [
            (np.quantile(values, 0.75) - np.quantile(values, 0.25)) / 2 / middle
            for values, middle in zip(runs, medians, strict=True)]
        return medians[1] / medians[0], float(np.sum(spreads))

    def _limit(self, count: int, spread: float) -> float:
        if self.slower is not None:
            return self.slower
        keys = ('cpu', 'cores')
        alike = all(self.machine_a.get(key) == self.machine_b.get(key) for key in keys)
        usual = SLOWER_MANY if count >= MANY else SLOWER_FEW
        return (usual if alike else SLOWER_ELSEWHERE) + spread


def _runs(facts: Mapping[str, Any], key: str) -> list[float]:
    values = facts.get(key)
    values = values if isinstance(values, list) else [values]
    return [float(v) for v in values if isinstance(v, (int, float)) and 0 < v < math.inf]


def _values(series: Series) -> list[float]:
    return [float(value) for value in series.values() if not isinstance(value, tuple)]


def _positive(values: Sequence[float]) -> np.ndarray:
    array = np.asarray(values, dtype=float)
    return array[array > 0]


def _paired(a: Series, b: Series) -> tuple[list[Any], list[Any]]:
    """Return the values of the same items; the medians of each where none is the same."""
    common = [item for item in a if item in b and _both_numbers(a[item], b[item])]
    if common:
        return [a[item] for item in common], [b[item] for item in common]
    return [_median(_values(a))], [_median(_values(b))]


def _both_numbers(*values: object) -> bool:
    return not any(isinstance(value, tuple) for value in values)


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _state(rise: float, up: State) -> State:
    down = State.BETTER if up is State.WORSE else State.WORSE
    return State.SAME if not rise else up if rise > 0 else down


def _name(item: Item) -> str:
    return ' - '.join(part for part in item[2:] if part) or ' '.join(item[:1])


def _listed(word: str, items: Sequence[Item]) -> str:
    if not items:
        return ''
    more = f' and {len(items) - NAMED} more' if len(items) > NAMED else ''
    return f'{len(items)} {word}: {"; ".join(map(_name, items[:NAMED]))}{more}'


def interval(values: np.ndarray) -> tuple[float, float, float]:
    """
    Return the median of `values` (N,) between the bounds of its interval by the sign test.

    Parameters
    ----------
    values : (N,) float64
        At least one. Of fewer than six, the bounds are the least and the most.

    Returns
    -------
    tuple of float
        Lower bound, median, upper bound; 99 % and more.
    """
    ordered = np.sort(values)
    count = len(ordered)
    cut = int(binom.ppf(0.005, count, 0.5)) if count >= MANY else 0
    cut = max(0, cut - 1) if count >= MANY else 0
    return float(ordered[cut]), float(np.median(ordered)), float(ordered[count - 1 - cut])


def _wrong(a: Series, b: Series) -> Verdict:
    """More wrong ones, or others than before, are worse whatever else."""
    names = [
        {(*item[:1], name) for item, value in series.items() if isinstance(value, tuple)
         for name in value} for series in (a, b)]
    counts = [len(found) + sum(_values(s)) for found, s in zip(names, (a, b), strict=True)]
    new = sorted(names[1] - names[0])
    state = State.WORSE if new or counts[1] > counts[0] else _state(
        counts[1] - counts[0], State.WORSE)
    why = '; '.join(' '.join(filter(None, name)) for name in new[:NAMED])
    return Verdict(state, f'{counts[0]:g}', f'{counts[1]:g}', f'new: {why}' if new else '')


def _repeated(one: Sequence[float], other: Sequence[float], up: State) -> Verdict:
    """Compare repeats of a count: right answers by the worst, work by a median out of range."""
    rise = min(other) - min(one)
    if up is State.WORSE:
        middle = _median(other)
        rise = max(0.0, middle - max(one)) + min(0.0, middle - min(one))
    return Verdict(_state(rise, up), _range(one), _range(other))


def _range(values: Sequence[float]) -> str:
    low, high = min(values), max(values)
    return f'{low:g}' if low == high else f'{low:g}-{high:g}'


def _measured(kind: Kind, a: Series, b: Series, share: float, least: float) -> Verdict:
    """Compare errors, shares, memory: beyond a share, a least change and the repeats."""
    one, other = (np.asarray(values, dtype=float) for values in _paired(a, b))
    before, after = _median(one), _median(other)
    shown = f'{before:.4g}', f'{after:.4g}'
    up = State.BETTER if kind is Kind.SHARE else State.WORSE
    if abs(after - before) <= max(share * abs(before), least):
        return Verdict(State.SAME, *shown)
    rise = other - one
    if len(rise) >= MANY:
        low, _, high = interval(rise)
        return Verdict(_state(max(0.0, low) + min(0.0, high), up), *shown, f'{len(rise)} values')
    if len(rise) > 1:
        low, high = float(rise.min()), float(rise.max())
        return Verdict(_state(max(0.0, low) + min(0.0, high), up), *shown)
    return Verdict(_state(after - before, up), *shown)
