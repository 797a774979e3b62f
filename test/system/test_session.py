# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Sessions over small synthetic views. Truth: the exact poses, and what input deserves."""

from dataclasses import replace

import numpy as np
import pytest
from reference.captures import arc, error, of_field
from ros_rops.core.config import Config
from ros_rops.core.errors import ParameterError
from ros_rops.core.types import RangeView, SensorModel, Status
from ros_rops.pipeline.session import Session

NAMES = ('blob', 'bracket')
MIXED = [capture for both in zip(*(arc(name) for name in NAMES), strict=True) for capture in both]


def session(captures, **options):
    made = Session(**options)
    for capture in captures:
        made.add(capture.view)
    made.finish()
    return made


def poses(made):
    return {
        view.name: view.T_object_view for shape in made.objects for view in shape.views}


def check(made, captures, most_mr=0.3):
    """Check that each object is whole and alone, and every pose right."""
    by_name = {capture.view.name: capture for capture in captures}
    found = [{view.name for view in shape.views} for shape in made.objects]
    wanted = [
        {name for name in by_name if name.startswith(thing)} for thing in NAMES]
    assert sorted(map(sorted, found)) == sorted(map(sorted, filter(None, wanted))), [
        (report.name, report.reason) for report in made.reports]
    for shape in made.objects:
        first, *others = shape.views
        for view in others:
            pose = np.linalg.inv(first.T_object_view) @ view.T_object_view
            degrees, shift = error(pose, by_name[first.name], by_name[view.name])
            assert degrees < 0.6
            assert shift < most_mr * made.mesh_resolution


@pytest.fixture(scope='module')
def mixed():
    return session(MIXED, threads=2)


def test_two_mixed_objects_are_told_apart(mixed):
    check(mixed, MIXED)
    assert {report.status for report in mixed.reports} == {Status.PLACED}
    assert {report.object_id for report in mixed.reports} == {0, 1}


def test_every_attempt_is_recorded(mixed):
    assert mixed.attempts == len(mixed.trace) <= 4 * len(MIXED)
    for attempt in mixed.trace:
        assert attempt.status in (Status.PLACED, Status.AMBIGUOUS, Status.REFUSED)
        assert attempt.reason
        assert set(attempt.seconds) <= {'match', 'glance', 'quick', 'thorough', 'settle'}
        assert all(value >= 0 for value in attempt.seconds.values())


@pytest.mark.parametrize('seed', [1, 2])
def test_any_order_places_all(seed):
    order = np.random.default_rng(seed).permutation(len(MIXED))
    captures = [MIXED[k] for k in order]
    check(session(captures), captures)


def test_threads_and_repetition_change_no_byte(mixed):
    again = session(MIXED, threads=1)
    for name, pose in poses(mixed).items():
        assert poses(again)[name].tobytes() == pose.tobytes()
    assert [r.numbers for r in again.reports] == [r.numbers for r in mixed.reports]


def test_a_removed_view_takes_nothing_with_it():
    captures = arc('bracket')
    made = session(captures)
    middle = captures[1].view.name
    made.remove(middle)
    rest = [capture for capture in captures if capture.view.name != middle]
    check(made, rest)
    made.add(captures[1].view)
    made.finish()
    check(made, captures)
    with pytest.raises(ParameterError, match='nobody'):
        made.remove('nobody')


def test_views_may_come_after_finish():
    captures = arc('bracket')
    made = session(captures[:3])
    made.add(captures[3].view)
    made.finish()
    check(made, captures)


def test_a_name_is_taken_once(mixed):
    with pytest.raises(ParameterError, match=r"'blob_0' was added before"):
        mixed.add(MIXED[0].view)


def _slab(points):
    return np.maximum(np.abs(points[..., 2]) - 0.01, np.abs(points[..., :2]).max(axis=-1) - 0.3)


def _ball(points):
    return np.linalg.norm(points, axis=-1) - 0.05


def _with(points, name, **changes):
    return RangeView(name, np.asarray(points, float).reshape(-1, 3), sensor=SensorModel(
        'pinhole'), **changes)


def _strayed():
    """One pixel a billion metres away, still in the grid."""
    view = arc('bracket')[1].view
    points = view.points.copy()
    points[len(points) // 2] *= 1e9 / np.linalg.norm(points[len(points) // 2])
    return replace(view, name='strayed', points=points)


BAD = [
    (lambda: _with([], 'empty'), Status.REFUSED, 'points'),
    (lambda: _with([[0, 0, 1], [0.1, 0, 1]], 'two'), Status.REFUSED, 'points'),
    (lambda: _with(np.tile([0.1, 0.2, 1.0], (500, 1)), 'same'), Status.REFUSED, 'points'),
    (lambda: replace(of_field(_slab)[0].view, name='plane'), Status.AMBIGUOUS, 'slides'),
    (lambda: replace(of_field(_ball)[0].view, name='sphere'), Status.AMBIGUOUS, 'slides'),
    (lambda: replace(
        arc('bracket')[1].view, name='thousandfold', units='unknown',
        points=arc('bracket')[1].view.points * 1000), Status.REFUSED, 'units'),
]


@pytest.mark.parametrize(('make', 'status', 'word'), BAD, ids=[
    'empty', 'two', 'same', 'plane', 'sphere', 'thousandfold'])
def test_bad_views_get_a_word_and_the_session_goes_on(make, status, word):
    captures = arc('bracket', 3)
    made = Session()
    made.add(captures[0].view)
    report = made.add(make())
    assert (report.status, report.object_id) == (status, None)
    assert word in report.reason
    for capture in captures[1:]:
        made.add(capture.view)
    made.finish()
    check(made, captures)


def test_a_bad_view_may_come_first():
    captures = arc('bracket', 3)
    made = Session()
    for make, status, _ in BAD[:5]:
        assert made.add(make()).status is status
    for capture in captures:
        made.add(capture.view)
    made.finish()
    check(made, captures)


def test_a_stray_point_does_not_harm():
    captures = arc('bracket', 4)
    made = Session()
    for capture in (captures[0], captures[2], captures[3]):
        made.add(capture.view)
    report = made.add(_strayed())
    made.finish()
    report = next(r for r in made.reports if r.name == report.name)
    # Either the point has no face and counts for nothing, or the view is refused for it.
    assert report.status is Status.PLACED or 'stray' in report.reason


def test_points_seen_twice_count_once():
    captures = arc('bracket', 3)
    doubled = []
    for capture in captures:
        view = capture.view
        doubled.append(replace(capture, view=RangeView(
            view.name, np.concatenate([view.points, view.points[::2]]), sensor=view.sensor,
            units=view.units)))
    check(session(doubled), doubled)


def test_far_from_the_origin():
    captures = arc('bracket', 3)
    away = np.array([1.0e6, -1.0e6, 2.0e6]) * 0.5
    shift = np.eye(4)
    shift[:3, 3] = -away
    far = [replace(
        capture, T_world_view=capture.T_world_view @ shift,
        view=replace(capture.view, points=capture.view.points + away, sensor=SensorModel(
            'pinhole', origin=tuple(away)))) for capture in captures]
    check(session(far), far)


def test_stated_units_may_be_mixed():
    captures = arc('bracket')
    mixed_units = [
        replace(capture, view=replace(
            capture.view, points=capture.view.points * 1000, units='mm'))
        if k % 2 else capture for k, capture in enumerate(captures)]
    made = session(mixed_units)
    assert made.units == 'm'
    check(made, captures)
    in_mm = session(mixed_units, units='mm')
    assert in_mm.units == 'mm'
    assert in_mm.mesh_resolution == pytest.approx(1000 * made.mesh_resolution, rel=1e-9)


@pytest.mark.parametrize(('name', 'value'), [
    ('growth.tries', 0), ('verdict.rival', 'high'), ('fine.radius_mr', float('nan')),
    ('no.such', 1)])
def test_wrong_parameters_are_named(name, value):
    with pytest.raises(ParameterError, match=name.replace('.', r'\.')):
        Config.from_flat({name: value})


def test_who_waits_for_a_view_is_told_before_others_are_tried():
    """Truth: the state when told is that of a join, and being told changes nothing."""
    captures = arc('blob', 4)
    session, silent = Session(threads=2), Session(threads=2)
    heard = []
    session.joined = lambda: heard.append((
        session.attempts, [report.status for report in session.reports],
        sum(len(shape.views) for shape in session.objects)))
    for capture in captures:
        before = len(heard)
        report = session.add(capture.view)
        assert report == silent.add(capture.view)
        if report.status is Status.PLACED:
            attempts, statuses, placed = heard[before]
            assert attempts <= session.attempts
            assert statuses[-1] is Status.PLACED and statuses.count(Status.PLACED) == placed
        else:
            assert len(heard) == before
    assert len(heard) == 3
    session.finish()
    silent.finish()
    for one, other in zip(session.objects, silent.objects, strict=True):
        assert [view.T_object_view.tobytes() for view in one.views] == [
            view.T_object_view.tobytes() for view in other.views]
