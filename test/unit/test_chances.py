# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Who tries whom again. Truth: the rules of `growth.better` and `growth.larger`, by hand."""

from dataclasses import dataclass

import pytest
from ros_rops.core.config import Config
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
        module, 'plausibility', lambda small, large, config, **_: max(small, large))
    shapes = {0: _Shape(1, 0.0), 1: _Shape(10, 0.2)}
    return shapes, Chances(Config(), 1, {'screen': 0.0})


def _fail(chances, shapes):
    chance, = chances.of([(0, 1)], shapes.__getitem__, 0.1)
    chances.spend(chance)
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
