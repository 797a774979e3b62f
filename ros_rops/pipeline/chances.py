# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What is known of how plausible it is that two shapes fit, and which were tried."""

from collections.abc import Callable, Collection, Mapping, MutableMapping
from dataclasses import dataclass
import math
import time

from ros_rops.core.config import Config
from ros_rops.core.shape_growing import promise, Prospect, prospect, Shape

Pair = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Chance:
    """A pair of shapes (by key) and how plausible it is that they fit."""

    plausibility: float
    smaller: int
    larger: int


@dataclass(frozen=True, slots=True)
class Vain:
    """How plausible two shapes were when they did not fit, and how many views they had."""

    plausibility: float = -math.inf
    views: int = 0


@dataclass(slots=True)
class _Record:
    """What is known of a pair; None where nobody asked yet."""

    plausibility: float | None = None
    careful: bool = False
    prospect: Prospect | None = None
    promise: float | None = None
    tried: bool = False
    tried_thoroughly: bool = False
    vain: Vain | None = None


class Chances:
    """
    The votes of features on pairs of shapes, asked for once each.

    Parameters
    ----------
    config : Config
    threads : int
    seconds : mutable mapping of str to float
        Wall seconds by stage, added to.
    """

    def __init__(
        self, config: Config, threads: int, seconds: MutableMapping[str, float]
    ) -> None:
        self._config = config
        self._threads = threads
        self._seconds = seconds
        self._records: dict[Pair, _Record] = {}

    def of(
        self, pairs: Collection[Pair], shape: Callable[[int], Shape], least: float, *,
        careful: bool = False, again: bool = False, thorough: bool = False,
    ) -> list[Chance]:
        """
        Pairs (rising keys) not yet tried that are plausible enough, the most so first.

        What was tried in vain before the shapes grew is left out unless they have become more
        plausible or far larger since, or `again` is set. `thorough` asks for those not yet tried
        thoroughly.
        """
        found = []
        for pair in pairs:
            record = self._record(*pair)
            if record.tried_thoroughly if thorough else record.tried:
                continue
            small, large = sorted(pair, key=lambda k: (shape(k).size, -k))
            value = self._plausibility(record, small, large, shape, careful)
            views = shape(small).size + shape(large).size
            if value >= least and (again or self._is_new(record, value, views)):
                found.append(Chance(value, small, large))
        return sorted(found, key=lambda c: (-c.plausibility, c.smaller, c.larger))

    def best(
        self, pairs: Collection[Pair], shape: Callable[[int], Shape], least: float,
        promise_least: Callable[[Chance], float],
    ) -> Chance | None:
        """Return the most plausible pair that promises enough, of the few first."""
        for chance in self.of(pairs, shape, least)[:self._config.growth.tries]:
            if self.promise_of(chance, shape) >= promise_least(chance):
                return chance
            # That counts as tried in vain until the shapes have grown.
            self.fail(chance, shape(chance.smaller).size + shape(chance.larger).size)
        return None

    def likeliest(
        self, keys: Collection[int], shape: Callable[[int], Shape]
    ) -> list[Pair]:
        """For every shape the few others, not tried thoroughly, that its votes speak for."""
        pairs: set[Pair] = set()
        for key in keys:
            others = [pair_of(key, k) for k in keys if k != key]
            chances = self.of(others, shape, -1.0, again=True, thorough=True)
            pairs.update(
                pair_of(c.smaller, c.larger) for c in chances[:self._config.growth.partners])
        return sorted(pairs)

    def best_couple(
        self, chances: Collection[Chance], shape: Callable[[int], Shape], least: float
    ) -> Chance | None:
        """
        Return the pair that promises most, and at least `least`, of those who prefer each other.

        Parts of one object promise each other most; to try all that look alike would cost the
        square of the number of objects.
        """
        ranked = sorted(
            chances, key=lambda c: (-self.promise_of(c, shape), c.smaller, c.larger))
        taken: set[int] = set()
        for chance in ranked:
            if self.promise_of(chance, shape) < least:
                return None
            if taken.isdisjoint((chance.smaller, chance.larger)):
                return chance
            taken.update((chance.smaller, chance.larger))
        return None

    def promise_of(self, chance: Chance, shape: Callable[[int], Shape]) -> float:
        """Return what a plausible pair scores once its poses are refined, asked for once."""
        record = self._record(chance.smaller, chance.larger)
        if record.promise is None:
            started = time.perf_counter()
            small, large = shape(chance.smaller).surface, shape(chance.larger).surface
            # What only was hoped for has no poses yet.
            found = record.prospect or prospect(
                small, large, self._config, threads=self._threads)
            record.promise = promise(
                small, large, found.poses, self._config, threads=self._threads)
            self._seconds['screen'] += time.perf_counter() - started
        return record.promise

    def spend(self, chance: Chance, *, thorough: bool) -> None:
        """Note that a pair is tried now."""
        record = self._record(chance.smaller, chance.larger)
        record.tried = True
        record.tried_thoroughly |= thorough

    def fail(self, chance: Chance, views: int) -> None:
        """Note that a pair, of so many views together, did not fit."""
        self._record(chance.smaller, chance.larger).vain = Vain(chance.plausibility, views)

    def inherit(self, key: int, *parts: int) -> None:
        """Let a shape know what its parts were tried with in vain."""
        for (a, b), record in list(self._records.items()):
            if record.vain and (a in parts) != (b in parts):
                heir = self._record(b if a in parts else a, key)
                known = heir.vain or Vain()
                heir.vain = Vain(
                    max(record.vain.plausibility, known.plausibility),
                    max(record.vain.views, known.views))

    def renew(self, keys: Collection[int]) -> bool:
        """Let the pairs of these shapes be tried again; return whether any was tried."""
        stale = [
            pair for pair, record in self._records.items()
            if record.tried and not set(keys).isdisjoint(pair)]
        for pair in stale:
            del self._records[pair]
        return bool(stale)

    def hopes(self, small: int, large: int) -> dict[int, float]:
        """Tell what either of two shapes could hope for from each third one."""
        hopes: dict[int, float] = {}
        for pair, record in self._records.items():
            if record.tried or len({small, large}.intersection(pair)) != 1:
                continue
            other = pair[0] if pair[1] in (small, large) else pair[1]
            value = record.plausibility
            if value is not None and value >= self._config.growth.plausible:
                hopes[other] = max(value, hopes.get(other, value))
        return hopes

    def hope(self, key: int, hopes: Mapping[int, float]) -> None:
        """Let a new shape hope for as much."""
        for other, value in hopes.items():
            self._record(other, key).plausibility = value

    def forget(self, key: int) -> None:
        """Drop a shape that is no more."""
        self._records = {
            pair: record for pair, record in self._records.items() if key not in pair}

    def _record(self, a: int, b: int) -> _Record:
        return self._records.setdefault(pair_of(a, b), _Record())

    def _is_new(self, record: _Record, value: float, views: int) -> bool:
        growth, vain = self._config.growth, record.vain
        return (
            vain is None or value >= growth.better * vain.plausibility
            or views >= growth.larger * vain.views)

    def _plausibility(
        self, record: _Record, small: int, large: int, shape: Callable[[int], Shape],
        careful: bool,
    ) -> float:
        """Look the value up or compute it; `careful` asks all features once more."""
        if record.plausibility is None or (careful and not record.careful):
            started = time.perf_counter()
            found = prospect(
                shape(small).surface, shape(large).surface, self._config, careful=careful,
                threads=self._threads)
            if record.plausibility is None or found.plausibility > record.plausibility:
                record.plausibility, record.prospect = found.plausibility, found
            record.careful |= careful
            self._seconds['screen'] += time.perf_counter() - started
        return record.plausibility


def pair_of(a: int, b: int) -> Pair:
    """Name two shapes the same way, whichever comes first."""
    return min(a, b), max(a, b)
