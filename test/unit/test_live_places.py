# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Where objects stand. Truth: places that the views were made with."""

import numpy as np
import pytest
from reference.updates import pose, Station
from ros_rops.live.places import FrameNames, last_places, newest_frame, places_in, poses

NAMES = FrameNames('left/', '')


def _close(found, expected):
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize('units', ['m', 'mm'])
def test_each_object_stands_where_it_was_seen_last(units):
    station = Station(units=units)
    for name, object_id in (('a', 1), ('b', 2), ('c', 1), ('d', 2), ('e', 1)):
        station.see(name, object_id)
    station.see('f')  # waits: it moves nothing
    update = station.update()
    assert newest_frame(update, NAMES) == 'camera'
    for found in (places_in(update, NAMES, 'camera'), last_places(update, NAMES)):
        assert [(place.object_id, place.view, place.frame_id) for place in found] == [
            (1, 'e', 'camera'), (2, 'd', 'camera')]
        _close(found[0].T_frame_object, station.place(1, 'e'))
        _close(found[1].T_frame_object, station.place(2, 'd'))


def test_poses_are_in_metres():
    station = Station(units='mm')
    station.see('a', 3)
    station.see('b', 3)
    found = poses(station.update())
    _close(found[3]['b'], station.T_object_view(3, 'b'))
    _close(found[3]['a'], np.eye(4))


def test_another_sensor_tells_nothing_of_this_one():
    station = Station()
    for name, object_id, frame_id in (
            ('a', 1, 'left'), ('b', 1, 'right'), ('c', 2, 'right'), ('d', 2, '/right'),
            ('e', 1, 'left')):
        station.see(name, object_id, frame_id=frame_id)
    update = station.update()
    found = places_in(update, NAMES, newest_frame(update, NAMES))
    assert [(place.object_id, place.view) for place in found] == [(1, 'e')]
    assert [place.frame_id for place in last_places(update, NAMES)] == ['left', 'right']
    (other, second) = places_in(update, NAMES, 'right')
    assert (other.view, second.view) == ('b', 'd')
    _close(other.T_frame_object, station.place(1, 'b'))


def test_a_moving_sensor_with_known_poses_leaves_objects_in_their_places():
    rng, station, names = np.random.default_rng(5), Station(units='mm'), FrameNames('', 'world')
    T_world_object = {1: pose(rng), 2: pose(rng)}
    for name, object_id in (('a', 1), ('b', 2), ('c', 2), ('d', 1)):
        T_world_sensor = pose(rng, 1.0)
        station.see(
            name, object_id, T_fixed_sensor=T_world_sensor,
            T_sensor_object=np.linalg.inv(T_world_sensor) @ T_world_object[object_id])
    update = station.update()
    assert newest_frame(update, names) == 'world'
    # The object's frame is that of its first view: where the sensor was then.
    for found in (places_in(update, names, 'world'), last_places(update, names)):
        for place, first in zip(found, ('a', 'b'), strict=True):
            assert place.frame_id == 'world'
            expected = T_world_object[place.object_id] @ np.linalg.inv(station.places[first])
            _close(place.T_frame_object, expected)


def test_a_view_whose_sensor_pose_is_unknown_is_told_in_the_sensors_frame():
    station, names = Station(), FrameNames('', 'world')
    station.see('a', 1, T_fixed_sensor=pose(station.rng))
    station.see('b', 1)
    update = station.update()
    assert newest_frame(update, names) == 'camera'
    assert [place.frame_id for place in last_places(update, names)] == ['camera']
    _close(last_places(update, names)[0].T_frame_object, station.place(1, 'b'))


def test_names_of_frames():
    station = Station()
    assert (NAMES.of_object(2), NAMES.of_view(7)) == ('left/object_2', 'left/view_7')
    assert NAMES.of_sensor(station.see('a', frame_id='')) == 'left/sensor'
    assert newest_frame(Station().update(), NAMES) == ''
