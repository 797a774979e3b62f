# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which shape tries which, and when: a registration is paid for only where it has a chance.

Every view starts as a shape of its own. A newcomer tries the shapes whose matched features make
it plausible, best first; where two fit they become one, which is then a newcomer itself. What is
left waits, and tries again when the shapes have grown.
"""

from collections import Counter
from collections.abc import Callable, Collection, Mapping, MutableMapping, Sequence
from dataclasses import replace
import itertools
import math
import time

from ros_rops.core.config import Config
from ros_rops.core.efforts import plain_score
from ros_rops.core.errors import ViewError
from ros_rops.core.pairwise import PairResult
from ros_rops.core.shape_growing import grow, Shape
from ros_rops.core.types import Floats, Status, Units
from ros_rops.pipeline.attempt import Attempt, attempt
from ros_rops.pipeline.chances import Chance, Chances, Pair, pair_of
from ros_rops.pipeline.reports import ViewReport
from ros_rops.pipeline.shapes import Shapes
from ros_rops.pipeline.station import StationWatch
from ros_rops.pipeline.words import objection, refused, Words

# An object that is so many times as plausible as it must be is tried before views that wait.
LIKELY = 2.0
# Of more shapes than these, some that are strangers fit each other by chance.
SEVERAL = 8


class Growth:
    """
    The shapes of a session, single views among them.

    Parameters
    ----------
    config : Config
    threads : int
    seconds : mutable mapping of str to float
        Wall seconds by stage, added to.
    watch : StationWatch
        Told of what was placed, asked for what is known of poses.
    joined : callable
        Called when shapes have become one, before what waits is tried against it.
    """

    def __init__(
        self, config: Config, threads: int, seconds: MutableMapping[str, float],
        watch: StationWatch, joined: Callable[[], None] = lambda: None,
    ) -> None:
        self.trace: list[Attempt] = []
        self._config = config
        self._threads = threads
        self._seconds = seconds
        self._shapes = Shapes(config, threads)
        self._parted = False
        self._asked: Counter[int] = Counter()
        self._objected: set[int] = set()
        self._searches: Counter[int] = Counter()
        self._chances = Chances(config, threads, seconds)
        self._watch = watch
        self._joined = joined
        self._words = Words()
        self._residuals: dict[int, list[float]] = {}

    def arrive(self, shape: Shape, units: Units) -> None:
        """Take a new view in, in `units`, and let it, and what it changes, find its place."""
        self._shapes.surfaces[shape.surface.name] = shape.surface
        self._watch.arrive(shape.surface, units)
        self._grow_from(self._shapes.insert(shape), self._config.growth.plausible)

    def settle(self) -> None:
        """Try what has a chance at all, best first, until nothing fits any more."""
        self._searches.clear()
        self._settle()

    def _settle(self) -> None:
        while True:
            pairs = self._chances.likeliest(self._shapes.keys, self._shapes.of)
            if chance := self._best_of_a_view(pairs, thorough=False):
                self._try(chance)
            elif chance := (
                    self._best_of_a_view(pairs, thorough=True) or self._best_couple(pairs)):
                self._try(chance, thorough=True)
            else:
                return

    def _best_of_a_view(self, pairs: Collection[Pair], *, thorough: bool) -> Chance | None:
        """Return the most plausible untried pair of a view that has no place yet."""
        # What fits nothing would try everything thoroughly.
        most = self._config.growth.partners if thorough else math.inf
        free = {
            key for key in self._shapes.keys
            if key not in self._shapes.object_ids and self._searches[key] < most}
        chances = self._chances.of(
            [pair for pair in pairs if not free.isdisjoint(pair)],
            self._shapes.of, self._config.growth.least, careful=True, again=True,
            thorough=thorough)
        return chances[0] if chances else None

    def _best_couple(self, pairs: Collection[Pair]) -> Chance | None:
        """Return two objects that prefer each other; who was asked before must promise more."""
        chances = self._chances.of(
            pairs, self._shapes.of, self._config.growth.least, careful=True, again=True,
            thorough=True)
        verdict = self._config.verdict
        for most, least in (
                (1, verdict.score_least), (self._config.growth.tries, verdict.score_sure)):
            free = {key for key in self._shapes.object_ids if self._asked[key] < most}
            couple = self._chances.best_couple(
                [c for c in chances if {c.smaller, c.larger} <= free], self._shapes.of, least)
            if couple:
                self._asked.update((couple.smaller, couple.larger))
                return couple
        return None

    def reconsider(self) -> bool:
        """Try again what did not fit before poses became better; whether shapes became one."""
        before = len(self._shapes)
        # Better poses may leave nothing to object to.
        while self._objected:
            del self._asked[self._objected.pop()]
        if self._chances.renew(self._shapes.outdated) or self._parted:
            self._parted = False
            self._settle()
        return len(self._shapes) < before

    @property
    def placed_share(self) -> float:
        """Share of the views that belong to an object; 1 without views."""
        return self._shapes.placed_share

    def forget_trials(self) -> None:
        """Let all be tried again."""
        self._asked.clear()
        self._chances.renew(self._shapes.keys)

    def objects(self) -> dict[int, Shape]:
        """Shapes of two or more views by object id."""
        return self._shapes.objects()

    def move(self, object_id: int, poses: Mapping[str, Floats]) -> None:
        """Give the views of an object better poses; its surface follows when it is needed."""
        self._shapes.move(object_id, poses)
        self._watch.learn(self.objects())

    def holds(self, name: str) -> bool:
        """Whether a view is in one of the shapes."""
        return self._shapes.holds(name)

    def take_back(self, name: str) -> None:
        """Remove a view; what it held together stays together."""
        key = self._shapes.key_of(name)
        poses = {k: pose for k, pose in self._shapes.members(key).items() if k != name}
        # Before anything is forgotten: it may fail for want of memory.
        rest = poses and self._shapes.regrown(poses)
        object_id = self._shapes.object_ids.get(key) if len(poses) > 1 else None
        self._words.forget(name)
        del self._shapes.surfaces[name]
        self._forget(key)
        if rest:
            self._shapes.insert(rest, object_id)

    def take_apart(
        self, object_id: int, groups: Sequence[Sequence[str]], reason: str
    ) -> None:
        """
        Make a shape of each group of an object's views; the first keeps the object's id.

        A view left alone waits; `reason` is the word on it until another place is tried.
        """
        key = self._shapes.key_of_object(object_id)
        poses = self._shapes.members(key)
        past = self._residuals.get(key, [])
        self._forget(key)
        self._parted = True
        for place, names in enumerate(groups):
            part = self._shapes.regrown({name: poses[name] for name in names})
            if len(names) == 1:
                self._shapes.insert(part)
                self._words.say(names[0], f'object {object_id}', reason)
            elif place == 0:
                self._residuals[self._shapes.insert(part, object_id)] = past
            else:
                self._shapes.insert(part, self._shapes.new_object())

    def report(self, name: str) -> ViewReport:
        """Return the current word on a view."""
        key = self._shapes.key_of(name)
        return self._words.report(name, self._shapes.object_ids.get(key))

    def _grow_from(self, key: int, least: float) -> None:
        """Let one shape, and what becomes of it, try the others: likely objects first."""
        tries = 0
        while tries < self._config.growth.tries:
            chance = self._best_of(key, least)
            if chance is None:
                return
            # Where a view has nothing else to try, all that can be done is done at once.
            merged = self._try(chance, thorough=self._expected(chance))
            tries += 1
            if merged is not None:
                key, tries = merged, 0

    def _best_of(self, key: int, least: float) -> Chance | None:
        others = [k for k in self._shapes.keys if k != key]
        objects = [pair_of(k, key) for k in others if k in self._shapes.object_ids]
        waiting = [pair_of(k, key) for k in others if k not in self._shapes.object_ids]
        first = self._chances.best(objects, self._shapes.of, least, self._promise_least)
        if first and first.plausibility >= LIKELY * least:
            return first
        second = self._chances.best(waiting, self._shapes.of, least, self._promise_least)
        return max(filter(None, (first, second)), key=lambda c: c.plausibility, default=None)

    def _promise_least(self, chance: Chance) -> float:
        """Return what a pair must promise: less than is plain would be doubted."""
        return -math.inf if self._expected(chance) else plain_score(self._config)

    def _expected(self, chance: Chance) -> bool:
        return self._shapes.is_expected(chance.smaller, chance.larger)

    def _try(self, chance: Chance, *, thorough: bool = False) -> int | None:
        """Register the smaller shape to the larger; return the key of what they became."""
        small, large = self._shapes.of(chance.smaller), self._shapes.of(chance.larger)
        self._chances.spend(chance, thorough=thorough)
        if thorough:
            self._searches.update((chance.smaller, chance.larger))
        result, record = attempt(
            small.surface, large.surface, self._config, threads=self._threads,
            known=self._watch.known(small, large), thorough=thorough)
        record = replace(
            record, source_views=tuple(small.members), target_views=tuple(large.members))
        for stage, seconds in record.seconds.items():
            self._seconds[stage] += seconds
        past = [
            *self._residuals.get(chance.smaller, ()), *self._residuals.get(chance.larger, ())]
        # Two views that nothing is known of are held to what the session's sensors are like.
        usual = past or list(itertools.chain.from_iterable(self._residuals.values()))
        against = objection(
            result, usual, self._config.verdict, several=len(self._shapes) > SEVERAL)
        if against:
            result = refused(result, against)
            self._objected |= {chance.smaller, chance.larger}
        merged = None
        try:
            merged = self._grown(small, large, result)
        except ViewError as error:
            # Only together do the two extend too far: the pose is of no use then.
            result = refused(result, str(error))
        self.trace.append(replace(record, status=result.status, reason=result.reason))
        if merged is None:
            self._chances.fail(chance, small.size + large.size)
            if small.size == 1:
                self._words.refused(small.first, result)
            return None
        self._words.placed((*small.members, *large.members), result)
        key = self._merge(chance.smaller, chance.larger, merged)
        self._residuals[key] = [*past, result.numbers['residual_mr']]
        self._joined()
        return key

    def _grown(self, small: Shape, large: Shape, result: PairResult) -> Shape | None:
        if result.status is not Status.PLACED or result.T_target_source is None:
            return None
        started = time.perf_counter()
        merged = grow(
            large, small, result.T_target_source, self._config, threads=self._threads)
        self._seconds['grow'] += time.perf_counter() - started
        return merged

    def _merge(self, small: int, large: int, merged: Shape) -> int:
        known = self._shapes.object_ids
        ids = [known[k] for k in (large, small) if k in known] or [self._shapes.new_object()]
        hopes = self._chances.hopes(small, large)
        key = self._shapes.insert(merged, min(ids))
        self._chances.inherit(key, small, large)
        self._chances.hope(key, hopes)
        self._forget(small)
        self._forget(large)
        self._watch.learn(self.objects())
        return key

    def _forget(self, key: int) -> None:
        self._shapes.forget(key)
        del self._asked[key]
        self._objected.discard(key)
        self._residuals.pop(key, None)
        self._chances.forget(key)
