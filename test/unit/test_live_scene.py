# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What markers show. Truth: exact places, the points of the views, the words of the reports."""

from types import SimpleNamespace

from msg_adapters import markers
from msg_adapters.markers import Label, Lines
from msg_adapters.rotation import quaternion
import numpy as np
import pytest
from reference.updates import Station
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Status
from ros_rops.live.places import FrameNames, newest_frame, places_in
from ros_rops.live.scene import MOST_WAITING, scene
from scipy.spatial.transform import Rotation


def _marks(station, names=FrameNames()):  # noqa: B008
    update = station.update()
    frame_id = newest_frame(update, names)
    marks = scene(update, places_in(update, names, frame_id), names, frame_id)
    found = {(mark.namespace, mark.number): mark for mark in marks}
    assert len(found) == len(marks), 'two marks are one to RViz'
    return found


@pytest.mark.parametrize('units', ['m', 'mm'])
def test_views_stand_where_their_sensor_stood(units):
    station = Station(units=units)
    for name in 'abc':
        station.see(name, 1)
    marks = _marks(station)
    assert {key[0] for key in marks} == {'views', 'view_labels', 'objects', 'object_labels'}
    for name in 'abc':
        number = station.numbers[name]
        T = station.place(1, 'c') @ station.T_object_view(1, name)
        lines = marks['views', number]
        np.testing.assert_allclose(lines.T, T, atol=1e-12)
        # Axes of one length from the origin, a pyramid that looks along z.
        np.testing.assert_allclose(
            lines.ends[1:6:2] / np.linalg.norm(lines.ends[1]), np.eye(3), atol=1e-12)
        assert (lines.ends[6:, 2] >= 0).all()
        assert marks['view_labels', number].text.startswith(f'view_{number}: placed')
    assert 'newest' in marks['view_labels', 2].text
    np.testing.assert_allclose(marks['objects', 1].T, station.place(1, 'c'), atol=1e-12)
    label, points = marks['object_labels', 1], station.views['c'].points / station.scale
    assert label.text == 'object_1: 3 views'
    # Between the sensor and the object, which was seen last in the newest view.
    assert 0 < label.at[2] < points[:, 2].min()
    np.testing.assert_allclose(label.at[:2], points.mean(axis=0)[:2], atol=1e-9)


@pytest.mark.parametrize('units', ['m', 'mm'])
def test_a_sensor_without_an_origin_stands_before_what_it_saw(units):
    station = Station(kind='orthographic', units=units)
    station.see('a', 1)
    station.see('b', 1)
    lines, points = _marks(station)['views', 1], station.views['b'].points / station.scale
    offset = points.mean(axis=0) - lines.T[:3, 3]
    assert 2 < offset[2] / np.ptp(points[:, 2]) < 5
    np.testing.assert_allclose(offset[:2], 0.0, atol=1e-12)


@pytest.mark.parametrize('units', ['m', 'mm'])
@pytest.mark.parametrize('status', [Status.PENDING, Status.AMBIGUOUS, Status.REFUSED])
def test_views_that_wait_are_boxes_around_their_points(units, status):
    station = Station(units=units)
    station.see('a', 1)
    station.see('b', 1)
    station.see('c', status=status)
    marks = _marks(station, FrameNames('left/'))
    lines, points = marks['waiting', 2], station.views['c'].points / station.scale
    np.testing.assert_allclose(lines.ends.min(axis=0), points.min(axis=0), atol=1e-12)
    np.testing.assert_allclose(lines.ends.max(axis=0), points.max(axis=0), atol=1e-12)
    edges = np.diff(lines.ends.reshape(12, 2, 3), axis=1)
    assert np.count_nonzero(edges) == 12  # each along one axis
    assert marks['waiting_labels', 2].text == f'left/view_2: {status.value}: waits for views'


def test_labels_of_waiting_views_stand_one_below_the_other_and_are_not_endless():
    station = Station()
    for k in range(MOST_WAITING + 5):
        station.see(f'v{k}', T_sensor_object=np.eye(4))
    marks = _marks(station)
    heights = [marks['waiting_labels', k].at[1] for k in range(5, MOST_WAITING + 5)]
    letter = marks['waiting_labels', 5].height
    assert len(marks) == 2 * MOST_WAITING
    assert (np.abs(np.diff(heights)) > letter).all() or (np.diff(sorted(heights)) > letter).all()


def test_another_sensors_views_are_not_shown_here():
    station = Station()
    station.see('a', frame_id='right')
    station.see('b', frame_id='left')
    assert set(_marks(station)) == {('waiting', 1), ('waiting_labels', 1)}


def test_a_view_taken_back_is_shown_no_more():
    station = Station()
    for name in 'abc':
        station.see(name, 1)
    station.take_back('b')
    assert ('views', 1) not in _marks(station) and ('views', 2) in _marks(station)


def _message():
    def marker():
        return SimpleNamespace(
            pose=SimpleNamespace(position=SimpleNamespace(), orientation=SimpleNamespace()),
            scale=SimpleNamespace(), color=SimpleNamespace())
    return SimpleNamespace(), marker


def test_the_whole_scene_takes_the_place_of_the_one_before():
    message, marker = _message()
    lines = Lines('views', 3, np.eye(4), np.eye(3)[[0, 1]], np.ones((2, 3)), 0.01)
    label = Label('labels', 3, np.arange(3.0), 'text', 0.2, (1.0, 0.5, 0.0))
    markers.fill(message, marker, SimpleNamespace, SimpleNamespace, 'head', [lines, label])
    clear, first, second = message.markers
    assert clear.action == 3 and first.action == second.action == 0
    assert (first.type, second.type) == (5, 9)
    assert [vars(point) for point in first.points] == [
        {'x': 1.0, 'y': 0.0, 'z': 0.0}, {'x': 0.0, 'y': 1.0, 'z': 0.0}]
    assert vars(second.pose.position) == {'x': 0.0, 'y': 1.0, 'z': 2.0}
    assert (second.text, second.scale.z, second.color.a) == ('text', 0.2, 1.0)
    assert all(item.header == 'head' for item in message.markers)


@pytest.mark.parametrize(('ends', 'colors'), [
    (np.zeros((3, 3)), np.zeros((3, 3))), (np.zeros((2, 2)), np.zeros((2, 2))),
    (np.zeros((2, 3)), np.zeros((4, 3)))])
def test_lines_without_two_ends_are_a_mistake(ends, colors):
    message, marker = _message()
    with pytest.raises(ShapeError, match='views'):
        markers.fill(
            message, marker, SimpleNamespace, SimpleNamespace, None,
            [Lines('views', 0, np.eye(4), ends, colors, 0.01)])


def test_quaternions_are_those_of_scipy():
    rng = np.random.default_rng(0)
    turns = [*Rotation.random(200, rng=rng), *Rotation.from_rotvec(np.pi * np.eye(3)),
             Rotation.identity(), Rotation.from_rotvec([1e-9, 0, 0])]
    for turn in turns:
        found, expected = np.array(quaternion(turn.as_matrix())), turn.as_quat(canonical=True)
        assert abs(np.linalg.norm(found) - 1) < 1e-15 and found[3] >= 0
        assert min(np.abs(found - expected).max(), np.abs(found + expected).max()) < 1e-14
