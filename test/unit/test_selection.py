# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Selection of frames; truth: synthetic turntables, of which it is known when they stand still."""

from dataclasses import replace

import numpy as np
import pytest
from reference.stations import Ball, Box, Post, shoot
from ros_rops.core.config import SelectionConfig
from ros_rops.core.frame import Frame
from ros_rops.segmentation.selection import Selector

STILL = SelectionConfig(method='still')
STOPS_DEG = (0.0, 25.0, 50.0, 50.0, 75.0)  # at the fourth stop nothing has changed
MOVING, RESTING = 6, 5


def scene(degrees, seed, **more):
    """Return a frame of a turntable; its truth is the angle alone."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))

    def at(x, y):
        return c * x - s * y, s * x + c * y

    bodies = [Post(*at(0.0, 0.05), 0.03, 0.1), Ball((*at(-0.06, -0.03), 0.03), 0.03),
              Post(*at(0.07, -0.05), 0.02, 0.05), Box((-0.02, -0.02, 0), (0.02, 0.02, 0.04))]
    options = {'noise': 0.004, 'step': 0.001, 'flying': 0.5, 'lost': 0.05, **more}
    return shoot(bodies, seed=seed, **options).frame


def stream(**more):
    """Yield (frame, stop): the stop's number while the table rests at it, None in motion."""
    seed = 0
    for number, stop in enumerate(STOPS_DEG):
        before = STOPS_DEG[number - 1] if number else stop - 20
        for angle in np.linspace(before, stop, MOVING + 1)[1:-1] if stop != before else ():
            seed += 1
            yield scene(angle, seed, **more), None
        for _ in range(RESTING):
            seed += 1
            yield scene(stop, seed, **more), number


def unorganized(frame):
    return replace(frame, points=frame.points[np.isfinite(frame.points[..., 2])])


@pytest.mark.parametrize('kind', ['organized', 'unorganized'])
@pytest.mark.parametrize('noise', [0.0, 0.004, 0.008])
def test_each_stop_is_taken_once_and_nothing_in_motion(kind, noise):
    selector, taken = Selector(STILL), []
    for frame, stop in stream(noise=noise, table=0.25 if noise > 0.005 else 9):
        decision = selector.decide(frame if kind == 'organized' else unorganized(frame))
        if decision.taken:
            taken.append(stop)
    assert taken == [0, 1, 2, 4]


def test_slow_motion_is_motion():
    # A third of a degree from frame to frame: neighbours agree, the first and last do not.
    selector = Selector(SelectionConfig(method='still', still_frames=12))
    for k, angle in enumerate(np.arange(0, 12, 0.33)):
        assert not selector.decide(scene(angle, k, noise=0.002)).taken


def test_flickering_holes_are_no_motion():
    selector = Selector(STILL)
    taken = [selector.decide(scene(0, seed, lost=0.2)).taken for seed in range(8)]
    assert taken == [False, False, True, False, False, False, False, False]


def test_removed_object_is_a_new_scene():
    selector, bodies = Selector(STILL), [Post(0, 0.05, 0.03, 0.1), Post(0.1, 0, 0.03, 0.06)]
    taken = [
        selector.decide(shoot(part, noise=0.004, seed=k, table=9).frame).taken
        for k, part in enumerate([bodies] * 4 + [bodies[:1]] * 4)]
    assert taken == [False, False, True, False, False, False, True, False]


def test_rest_must_last():
    selector = Selector(SelectionConfig(method='still', still_s=0.35))
    frame = scene(0, 0)
    taken = [
        selector.decide(replace(frame, stamp_ns=int(k * 1e8))).taken for k in range(7)]
    assert taken == [False] * 4 + [True] + [False] * 2
    backwards = Selector(SelectionConfig(method='still', still_s=0.35))
    assert not any(
        backwards.decide(replace(frame, stamp_ns=int(-k * 1e8))).taken for k in range(7))


def test_every_and_stride():
    frame = scene(0, 0)
    every = Selector(SelectionConfig(method='every'))
    assert [every.decide(frame).taken for _ in range(4)] == [True] * 4
    third = Selector(SelectionConfig(method='stride', stride=3))
    assert [third.decide(frame).taken for _ in range(7)] == [
        True, False, False, True, False, False, True]


def test_empty_frames_are_never_taken():
    selector = Selector(STILL)
    for points in (np.zeros((0, 3)), np.full((4, 5, 3), np.nan), np.zeros((0, 0, 3)),
                   np.full((7, 3), np.inf)):
        for _ in range(4):
            decision = selector.decide(Frame('f', points))
            assert not decision.taken
            assert 'nothing is measured' in decision.reason


@pytest.mark.parametrize('method', ['every', 'stride', 'still', 'request'])
def test_what_is_asked_for_is_taken_and_is_not_new_afterwards(method):
    frames = [scene(0.0, seed) for seed in range(5)]
    selector = Selector(SelectionConfig(method=method, stride=1000, still_s=0.0))
    assert selector.decide(frames[0], asked=True).taken
    later = [selector.decide(frame).taken for frame in frames[1:]]
    assert later == [method == 'every'] * 4
