# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Who tries whom again. Truth: the rules of `growth.better` and `growth.larger`, by hand."""

from dataclasses import dataclass

import numpy as np
import pytest
from ros_rops.core.config import Config, GrowthConfig
from ros_rops.core.shape_growing import Prospect
from ros_rops.pipeline import chances as module
from ros_rops.pipeline.chances import Chances


@dataclass(frozen=True)
class _Shape:
    """A shape as the rules see it: its views, and what others score with it."""

    size: int
    surface: float


@pytest.fixture
def world(monkeypatch):
    """Shapes by key; a pair's plausibility is the larger shape's surface."""
    monkeypatch.setattr(
        module, 'prospect', lambda small, large, config, **_: Prospect(
            max(small, large), np.empty((0, 4, 4))))
    shapes = {0: _Shape(1, 0.0), 1: _Shape(10, 0.2)}
    return shapes, Chances(Config(), 1, {'screen': 0.0})


def _fail(chances, shapes):
    chance, = chances.of([(0, 1)], shapes.__getitem__, 0.1)
    chances.spend(chance, thorough=False)
    chances.fail(chance, 11)


def _grown(chances, shapes, size, score):
    """Let shape 1 and a new view become shape 2."""
    shapes[2] = _Shape(size, score)
    chances.inherit(2, 1)
    chances.forget(1)
    return chances.of([(0, 2)], shapes.__getitem__, 0.1)


@pytest.mark.parametrize(('size', 'score', 'tried'), [
    (11, 0.2, False),    # as plausible as before; 12 views together, of 11 before
    (11, 0.219, False),
    (11, 0.221, True),   # a tenth more plausible
    (12, 0.2, False),    # 13: less than a quarter more
    (13, 0.2, True),     # 14
])
def test_what_failed_tries_again_when_something_changed(world, size, score, tried):
    shapes, chances = world
    _fail(chances, shapes)
    assert bool(_grown(chances, shapes, size, score)) is tried


def test_at_the_end_all_try_again(world):
    shapes, chances = world
    _fail(chances, shapes)
    assert not _grown(chances, shapes, 11, 0.2)
    assert chances.of([(0, 2)], shapes.__getitem__, 0.1, again=True)


def test_who_never_tried_may(world):
    shapes, chances = world
    assert _grown(chances, shapes, 11, 0.2)


def test_better_poses_give_a_new_chance(world):
    shapes, chances = world
    _fail(chances, shapes)
    assert chances.renew([1])
    assert chances.of([(0, 1)], shapes.__getitem__, 0.1)


def test_a_part_that_was_never_tried_changes_nothing_for_the_other(world):
    shapes, chances = world
    _fail(chances, shapes)
    shapes[3] = _Shape(2, 0.5)
    shapes[4] = _Shape(12, 0.5)
    chances.inherit(4, 1, 3)
    chances.forget(1)
    chances.forget(3)
    assert chances.of([(0, 4)], shapes.__getitem__, 0.1)  # 0.5 is more than 0.2 was


def test_what_was_tried_is_not_yet_tried_thoroughly(world):
    shapes, chances = world
    _fail(chances, shapes)
    assert not chances.of([(0, 1)], shapes.__getitem__, 0.1)
    chance, = chances.of([(0, 1)], shapes.__getitem__, 0.1, again=True, thorough=True)
    chances.spend(chance, thorough=True)
    assert not chances.of([(0, 1)], shapes.__getitem__, 0.1, again=True, thorough=True)


@pytest.fixture
def promising(monkeypatch):
    """Four shapes; what two promise each other is written down."""
    promises = {(0, 1): 0.2, (0, 2): 0.3, (1, 2): 0.25, (1, 3): 0.1, (2, 3): 0.02, (0, 3): 0.01}
    monkeypatch.setattr(
        module, 'prospect', lambda *_, **__: Prospect(0.5, np.empty((0, 4, 4))))
    monkeypatch.setattr(
        module, 'promise', lambda a, b, *_, **__: promises[tuple(sorted((a, b)))])
    shapes = {key: _Shape(2, key) for key in range(4)}
    return shapes, Chances(Config(), 1, {'screen': 0.0}), sorted(promises)


def _couple(promising, pairs, least=0.05):
    shapes, chances, _ = promising
    found = chances.best_couple(
        chances.of(pairs, shapes.__getitem__, 0.1), shapes.__getitem__, least)
    return found and tuple(sorted((found.smaller, found.larger)))


def test_a_couple_prefers_each_other(promising):
    assert _couple(promising, promising[2]) == (0, 2)


def test_no_couple_promises_too_little(promising):
    assert _couple(promising, [(0, 3), (2, 3)]) is None


def test_of_the_likely_the_first_that_promises_enough_is_tried(promising):
    shapes, chances, pairs = promising
    best = chances.best(pairs, shapes.__getitem__, 0.1, lambda chance: 0.3)
    assert (best.smaller, best.larger) in ((0, 2), (2, 0))


def test_only_a_few_are_asked_for_their_promise(promising):
    shapes, _, _ = promising
    chances = Chances(Config(growth=GrowthConfig(tries=1)), 1, {'screen': 0.0})
    # (0, 2) promises enough, but (0, 1) goes first and is the only one asked.
    assert chances.best([(0, 1), (0, 2)], shapes.__getitem__, 0.1, lambda chance: 0.3) is None


def test_who_promised_too_little_waits_until_something_changes(promising):
    shapes, chances, _ = promising
    assert chances.best([(0, 1)], shapes.__getitem__, 0.1, lambda chance: 0.3) is None
    assert not chances.of([(0, 1)], shapes.__getitem__, 0.1)
    assert chances.of([(0, 1)], shapes.__getitem__, 0.1, again=True)
