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
from ros_rops.core.shape_growing import grow, regrow, Shape
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Status, Units
from ros_rops.pipeline.attempt import Attempt, attempt
from ros_rops.pipeline.chances import Chance, Chances, Pair, pair_of
from ros_rops.pipeline.reports import ViewReport
from ros_rops.pipeline.station import StationWatch
from ros_rops.pipeline.words import opposed, outlier, Words

# An object that is so many times as plausible as it must be is tried before views that wait.
LIKELY = 2.0


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
        self._shapes: dict[int, Shape] = {}
        self._surfaces: dict[str, Surface] = {}
        self._outdated: set[int] = set()
        self._parted = False
        self._object_ids: dict[int, int] = {}
        self._asked: set[int] = set()
        self._objected: set[int] = set()
        self._searches: Counter[int] = Counter()
        self._chances = Chances(config, threads, seconds)
        self._watch = watch
        self._joined = joined
        self._words = Words()
        self._residuals: dict[int, list[float]] = {}
        self._next_key = 0
        self._next_object = 0

    def arrive(self, shape: Shape, units: Units) -> None:
        """Take a new view in, in `units`, and let it, and what it changes, find its place."""
        self._surfaces[shape.surface.name] = shape.surface
        self._watch.arrive(shape.surface, units)
        self._grow_from(self._insert(shape), self._config.growth.plausible)

    def settle(self) -> None:
        """Try what has a chance at all, best first, until nothing fits any more."""
        self._searches.clear()
        self._settle()

    def _settle(self) -> None:
        while True:
            pairs = self._likeliest_pairs()
            chance = self._best_of_a_view(pairs, thorough=False)
            if chance:
                self._try(chance)
                continue
            chance = self._best_of_a_view(pairs, thorough=True) or self._best_couple(pairs)
            if chance is None:
                return
            self._try(chance, thorough=True)

    def _best_of_a_view(self, pairs: Collection[Pair], *, thorough: bool) -> Chance | None:
        """Return the most plausible untried pair of a view that has no place yet."""
        objects = self._object_ids.keys()
        chances = self._chances.of(
            [pair for pair in pairs if any(
                key not in objects and self._may_try(key, thorough) for key in pair)],
            self._shape,
            self._config.growth.least, careful=True, again=True, thorough=thorough)
        return chances[0] if chances else None

    def _may_try(self, key: int, thorough: bool) -> bool:
        """Tell whether a view may go on: what fits nothing would try everything thoroughly."""
        return not thorough or self._searches[key] < self._config.growth.partners

    def _best_couple(self, pairs: Collection[Pair]) -> Chance | None:
        """Return two objects that have not had their one try at the end, and prefer each other."""
        chances = self._chances.of(
            pairs, self._shape, self._config.growth.least, careful=True, again=True,
            thorough=True)
        free = self._object_ids.keys() - self._asked
        couple = self._chances.best_couple(
            [c for c in chances if {c.smaller, c.larger} <= free], self._shape,
            self._config.verdict.score_least)
        if couple:
            self._asked.update((couple.smaller, couple.larger))
        return couple

    def reconsider(self) -> bool:
        """Try again what did not fit before poses became better; whether shapes became one."""
        before = len(self._shapes)
        # Better poses may leave nothing to object to.
        self._asked -= self._objected
        self._objected.clear()
        if self._chances.renew(self._outdated) or self._parted:
            self._parted = False
            self._settle()
        return len(self._shapes) < before

    @property
    def placed_share(self) -> float:
        """Share of the views that belong to an object; 1 without views."""
        placed = sum(shape.size for shape in self.objects().values())
        return placed / len(self._surfaces) if self._surfaces else 1.0

    def forget_trials(self) -> None:
        """Let all be tried again."""
        self._asked.clear()
        self._chances.renew(self._shapes)

    def _likeliest_pairs(self) -> list[tuple[int, int]]:
        """For every shape the few others that its quick votes speak for."""
        keys = sorted(self._shapes)
        pairs: set[tuple[int, int]] = set()
        for key in keys:
            others = [pair_of(key, k) for k in keys if k != key]
            chances = self._chances.of(others, self._shape, -1.0, again=True, thorough=True)
            pairs.update(
                pair_of(c.smaller, c.larger) for c in chances[:self._config.growth.partners])
        return sorted(pairs)

    def objects(self) -> dict[int, Shape]:
        """Shapes of two or more views by object id."""
        return {self._object_ids[key]: self._shapes[key] for key in self._object_ids}

    def move(self, object_id: int, poses: Mapping[str, Floats]) -> None:
        """Give the views of an object better poses; its surface follows when it is needed."""
        key = next(k for k, number in self._object_ids.items() if number == object_id)
        self._shapes[key] = Shape(self._shapes[key].surface, dict(poses))
        self._outdated.add(key)
        self._watch.learn(self.objects())

    def holds(self, name: str) -> bool:
        """Whether a view is in one of the shapes."""
        return any(name in shape.members for shape in self._shapes.values())

    def take_back(self, name: str) -> None:
        """Remove a view; what it held together stays together."""
        key = self._key_of(name)
        poses = {k: pose for k, pose in self._shapes[key].members.items() if k != name}
        # Before anything is forgotten: it may fail for want of memory.
        rest = poses and regrow(self._surfaces, poses, self._config, threads=self._threads)
        self._words.forget(name)
        del self._surfaces[name]
        object_id = self._object_ids.get(key)
        self._forget(key)
        if not rest:
            return
        fresh = self._insert(rest)
        if len(poses) > 1 and object_id is not None:
            self._object_ids[fresh] = object_id

    def take_apart(
        self, object_id: int, groups: Sequence[Sequence[str]], reason: str
    ) -> None:
        """
        Make a shape of each group of an object's views; the first keeps the object's id.

        A view left alone waits; `reason` is the word on it until another place is tried.
        """
        key = next(k for k, number in self._object_ids.items() if number == object_id)
        poses = self._shapes[key].members
        past = self._residuals.get(key, [])
        self._forget(key)
        self._parted = True
        for place, names in enumerate(groups):
            fresh = self._insert(regrow(
                self._surfaces, {name: poses[name] for name in names}, self._config,
                threads=self._threads))
            if len(names) == 1:
                self._words.say(names[0], f'object {object_id}', reason)
            elif place == 0:
                self._object_ids[fresh] = object_id
                self._residuals[fresh] = past
            else:
                self._object_ids[fresh] = self._next_object
                self._next_object += 1

    def report(self, name: str) -> ViewReport:
        """Return the current word on a view."""
        key = self._key_of(name)
        return self._words.report(name, self._object_ids.get(key))

    def _grow_from(self, key: int, least: float) -> None:
        """Let one shape, and what becomes of it, try the others: likely objects first."""
        tries = 0
        while tries < self._config.growth.tries:
            chance = self._best_of(key, least)
            if chance is None:
                return
            # Where a view has nothing else to try, all that can be done is done at once.
            merged = self._try(chance, thorough=self._alone(key))
            tries += 1
            if merged is not None:
                key, tries = merged, 0

    def _alone(self, key: int) -> bool:
        """Tell whether a shape is a view that has but one other to try."""
        return len(self._shapes) == 2 and self._shapes[key].size == 1

    def _best_of(self, key: int, least: float) -> Chance | None:
        others = [k for k in sorted(self._shapes) if k != key]
        objects = [pair_of(k, key) for k in others if k in self._object_ids]
        waiting = [pair_of(k, key) for k in others if k not in self._object_ids]
        # What promises less than is plain would be doubted; where a view has but one to try, even
        # that is tried.
        promise = -math.inf if self._alone(key) else plain_score(self._config)
        first = self._chances.best(objects, self._shape, least, promise)
        if first and first.plausibility >= LIKELY * least:
            return first
        found = filter(None, (first, self._chances.best(waiting, self._shape, least, promise)))
        return max(found, key=lambda chance: chance.plausibility, default=None)

    def _shape(self, key: int) -> Shape:
        """Return a shape whose surface is that of its present poses."""
        if key in self._outdated:
            self._shapes[key] = regrow(
                self._surfaces, self._shapes[key].members, self._config, threads=self._threads)
            self._outdated.discard(key)
        return self._shapes[key]

    def _try(self, chance: Chance, *, thorough: bool = False) -> int | None:
        """Register the smaller shape to the larger; return the key of what they became."""
        small, large = self._shape(chance.smaller), self._shape(chance.larger)
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
        objection = self._objection(result, past)
        if objection:
            result = replace(
                result, status=Status.REFUSED, T_target_source=None, reason=objection)
            self._objected |= {chance.smaller, chance.larger}
            record = replace(record, status=result.status, reason=result.reason)
        merged = None
        try:
            merged = self._grown(small, large, result)
        except ViewError as error:
            # Only together do the two extend too far: the pose is of no use then.
            result = replace(
                result, status=Status.REFUSED, T_target_source=None, reason=str(error))
            record = replace(record, status=result.status, reason=result.reason)
        self.trace.append(record)
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

    def _objection(self, result: PairResult, past: Sequence[float]) -> str:
        """Return what the session has against a pose that two shapes alone would bear out."""
        # Two views that nothing is known of are held to what the session's sensors are like.
        usual = past or list(itertools.chain.from_iterable(self._residuals.values()))
        # Of many strangers some fit each other by chance.
        several = len(self._shapes) > 2
        return outlier(result, usual, self._config.verdict.outlier) or (
            opposed(result) if several else '')

    def _grown(self, small: Shape, large: Shape, result: PairResult) -> Shape | None:
        if result.status is not Status.PLACED or result.T_target_source is None:
            return None
        started = time.perf_counter()
        merged = grow(
            large, small, result.T_target_source, self._config, threads=self._threads)
        self._seconds['grow'] += time.perf_counter() - started
        return merged

    def _merge(self, small: int, large: int, merged: Shape) -> int:
        ids = [self._object_ids[k] for k in (large, small) if k in self._object_ids]
        hopes = self._chances.hopes(small, large)
        key = self._insert(merged)
        self._chances.inherit(key, small, large)
        self._chances.hope(key, hopes)
        self._forget(small)
        self._forget(large)
        if not ids:
            ids = [self._next_object]
            self._next_object += 1
        self._object_ids[key] = min(ids)
        self._watch.learn(self.objects())
        return key

    def _insert(self, shape: Shape) -> int:
        key = self._next_key
        self._next_key += 1
        self._shapes[key] = shape
        return key

    def _forget(self, key: int) -> None:
        del self._shapes[key]
        self._outdated.discard(key)
        self._object_ids.pop(key, None)
        self._asked.discard(key)
        self._objected.discard(key)
        self._residuals.pop(key, None)
        self._chances.forget(key)

    def _key_of(self, name: str) -> int:
        return next(key for key, shape in self._shapes.items() if name in shape.members)
