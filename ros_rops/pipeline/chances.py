# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What is known of how plausible it is that two shapes fit, and which were tried."""

from collections.abc import Callable, Collection, Mapping, MutableMapping
from dataclasses import dataclass
import time

from ros_rops.core.config import Config
from ros_rops.core.shape_growing import plausibility, promise, Shape

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

    plausibility: float
    views: int


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
        self._values: dict[Pair, float] = {}
        self._careful: set[Pair] = set()
        self._tried: set[Pair] = set()
        self._promises: dict[Pair, float] = {}
        self._vain: dict[Pair, Vain] = {}

    def of(
        self, pairs: Collection[Pair], shape: Callable[[int], Shape], least: float, *,
        careful: bool = False, again: bool = False,
    ) -> list[Chance]:
        """
        Pairs (rising keys) not yet tried that are plausible enough, the most so first.

        What was tried in vain before the shapes grew is left out unless they have become more
        plausible or far larger since, or `again` is set.
        """
        found = []
        for a, b in pairs:
            if (a, b) in self._tried:
                continue
            small, large = sorted((a, b), key=lambda k: (shape(k).size, -k))
            value = self._value(small, large, shape, careful)
            if value >= least and (again or self._is_new(a, b, value, shape)):
                found.append(Chance(value, small, large))
        return sorted(found, key=lambda c: (-c.plausibility, c.smaller, c.larger))

    def best(
        self, pairs: Collection[Pair], shape: Callable[[int], Shape], least: float
    ) -> Chance | None:
        """Return the most plausible pair; of several, the first that keeps its promise."""
        for chance in self.of(pairs, shape, least):
            # One alone is tried without asking.
            if len(pairs) == 1 or (
                    self.promise_of(chance, shape) >= self._config.growth.plausible):
                return chance
            # That counts as tried in vain until the shapes have grown.
            self.fail(chance, shape(chance.smaller).size + shape(chance.larger).size)
        return None

    def best_partner(
        self, key: int, chances: Collection[Chance], shape: Callable[[int], Shape], least: float
    ) -> Chance | None:
        """
        Return the pair of `key` that promises most, and at least `least`.

        Parts of one object promise each other most; to try all that look alike would cost the
        square of the number of objects.
        """
        mine = [chance for chance in chances if key in (chance.smaller, chance.larger)]
        best = max(mine, key=lambda chance: self.promise_of(chance, shape), default=None)
        return best if best and self.promise_of(best, shape) >= least else None

    def promise_of(self, chance: Chance, shape: Callable[[int], Shape]) -> float:
        """Return what a plausible pair scores once its poses are refined, asked for once."""
        pair = pair_of(chance.smaller, chance.larger)
        if pair not in self._promises:
            started = time.perf_counter()
            self._promises[pair] = promise(
                shape(chance.smaller).surface, shape(chance.larger).surface, self._config,
                threads=self._threads)
            self._seconds['screen'] += time.perf_counter() - started
        return self._promises[pair]

    def spend(self, chance: Chance) -> None:
        """Note that a pair is tried now."""
        self._tried.add(pair_of(chance.smaller, chance.larger))

    def fail(self, chance: Chance, views: int) -> None:
        """Note that a pair, of so many views together, did not fit."""
        self._vain[pair_of(chance.smaller, chance.larger)] = Vain(chance.plausibility, views)

    def inherit(self, key: int, *parts: int) -> None:
        """Let a shape know what its parts were tried with in vain."""
        for (a, b), vain in list(self._vain.items()):
            if (a in parts) != (b in parts):
                pair = pair_of(b if a in parts else a, key)
                known = self._vain.get(pair, vain)
                self._vain[pair] = Vain(
                    max(vain.plausibility, known.plausibility), max(vain.views, known.views))

    def renew(self, keys: Collection[int]) -> bool:
        """Let the pairs of these shapes be tried again; return whether any was tried."""
        stale = {pair for pair in self._tried if not set(keys).isdisjoint(pair)}
        self._tried -= stale
        self._careful -= stale
        for pair in stale:
            self._values.pop(pair, None)
            self._vain.pop(pair, None)
            self._promises.pop(pair, None)
        return bool(stale)

    def hopes(self, small: int, large: int) -> dict[int, float]:
        """Tell what either of two shapes could hope for from each third one."""
        hopes: dict[int, float] = {}
        for pair, value in self._values.items():
            if pair in self._tried or len({small, large}.intersection(pair)) != 1:
                continue
            other = pair[0] if pair[1] in (small, large) else pair[1]
            if value >= self._config.growth.plausible:
                hopes[other] = max(value, hopes.get(other, value))
        return hopes

    def hope(self, key: int, hopes: Mapping[int, float]) -> None:
        """Let a new shape hope for as much."""
        self._values.update({pair_of(other, key): value for other, value in hopes.items()})

    def forget(self, key: int) -> None:
        """Drop a shape that is no more."""
        self._values = {k: v for k, v in self._values.items() if key not in k}
        self._careful = {k for k in self._careful if key not in k}
        self._tried = {k for k in self._tried if key not in k}
        self._vain = {k: v for k, v in self._vain.items() if key not in k}
        self._promises = {k: v for k, v in self._promises.items() if key not in k}

    def _is_new(
        self, a: int, b: int, value: float, shape: Callable[[int], Shape]
    ) -> bool:
        vain = self._vain.get((a, b))
        return (
            vain is None or value >= self._config.growth.better * vain.plausibility
            or shape(a).size + shape(b).size >= self._config.growth.larger * vain.views)

    def _value(
        self, small: int, large: int, shape: Callable[[int], Shape], careful: bool
    ) -> float:
        """Look the value up or compute it; `careful` asks all features once more."""
        pair = pair_of(small, large)
        if pair not in (self._careful if careful else self._values):
            started = time.perf_counter()
            value = plausibility(
                shape(small).surface, shape(large).surface, self._config, careful=careful,
                threads=self._threads)
            self._values[pair] = max(value, self._values.get(pair, value))
            if careful:
                self._careful.add(pair)
            self._seconds['screen'] += time.perf_counter() - started
        return self._values[pair]


def pair_of(a: int, b: int) -> Pair:
    """Name two shapes the same way, whichever comes first."""
    return min(a, b), max(a, b)
