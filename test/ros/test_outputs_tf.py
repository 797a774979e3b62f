# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The transforms that go out, over the wire. Truth: exact places that views were made with."""

import sys

from msg_adapters import transforms
import numpy as np
import pytest
from reference.updates import Station

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from rclpy.clock import ROSClock  # noqa: E402, I100
from ros.harness import LATCHED, RELIABLE  # noqa: E402
from ros.outputs_beside import last, outputs, two_objects  # noqa: E402
from sensor_msgs.msg import PointCloud2  # noqa: E402
from visualization_msgs.msg import MarkerArray  # noqa: E402


def test_transforms_compose_to_the_poses():
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='no tf2_msgs here')
    station = two_objects(units='mm')
    station.see('w')
    with outputs('left') as given:
        heard = given.client.collect(tf2_msgs.TFMessage, '/tf', RELIABLE)
        given.out.updated(station.update())
        given.out.rebroadcast()
        tf = last(heard, 2)
        latched = last(given.client.collect(tf2_msgs.TFMessage, '/left/transforms', LATCHED))
        now = given.node.get_clock().now().nanoseconds
    objects = {item.child: item for item in transforms.decode(tf)}
    views = {item.child: item for item in transforms.decode(latched)}
    assert set(objects) == {'left/object_1', 'left/object_2'}
    assert set(views) == {f'left/view_{k}' for k in range(5)}
    assert {item.parent for item in objects.values()} == {'camera'}
    for name, object_id in (('a', 1), ('b', 2), ('c', 1), ('d', 2), ('e', 1)):
        item = views[f'left/view_{station.numbers[name]}']
        assert item.parent == f'left/object_{object_id}'
        np.testing.assert_allclose(
            item.T_parent_child, station.T_object_view(object_id, name), atol=1e-12)
        # The newest view of an object is where the sensor is.
        whole = objects[item.parent].T_parent_child @ item.T_parent_child
        np.testing.assert_allclose(
            whole, station.place(object_id, 'ed'[object_id - 1])
            @ station.T_object_view(object_id, name), atol=1e-12)
    assert 0 <= now - objects['left/object_1'].stamp_ns < 60e9
    for item in (*tf.transforms, *latched.transforms):
        q = item.transform.rotation
        assert abs(np.linalg.norm([q.x, q.y, q.z, q.w]) - 1) < 1e-12


def test_stamps_on_tf_grow_and_a_clock_that_stands_still_is_not_repeated():
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='no tf2_msgs here')
    station = two_objects()
    parameters = [rclpy.Parameter('use_sim_time', value=True)]
    with outputs(parameter_overrides=parameters) as given:
        heard = given.client.collect(tf2_msgs.TFMessage, '/tf', RELIABLE)
        given.out.updated(station.update())  # no clock yet
        clock = given.node.get_clock()
        assert isinstance(clock, ROSClock)
        for stamp_ns in (5, 5, 7_000_000_000, 7_000_000_000, 8_000_000_000, 3):
            clock.set_ros_time_override(rclpy.time.Time(
                nanoseconds=stamp_ns, clock_type=clock.clock_type))
            given.out.rebroadcast()
        last(heard, 4)
    stamps = [transforms.decode(message)[0].stamp_ns for message in heard]
    # Back to 3: a recording that is played again.
    assert stamps == [5, 7_000_000_000, 8_000_000_000, 3]


def test_a_frame_that_is_ours_gets_no_second_parent(capfd):
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='no tf2_msgs here')
    station = Station()
    for name, frame_id in (('a', 'camera'), ('b', 'object_1')):
        station.see(name, 1, frame_id=frame_id)
    station.see('c', 2)
    station.see('d', 2)
    with outputs() as given:
        heard = given.client.collect(tf2_msgs.TFMessage, '/tf', RELIABLE)
        given.out.updated(station.update())
        assert [item.child for item in transforms.decode(last(heard))] == ['object_2']
        given.out.updated(station.update())
    assert capfd.readouterr().err.count('choose another publish.frame_prefix') == 1


def test_a_known_sensor_pose_puts_objects_in_the_fixed_frame():
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='no tf2_msgs here')
    station, T = Station(), np.eye(4)
    T[:3, 3] = [1.0, 2.0, 3.0]
    station.see('a', 1, T_fixed_sensor=T)
    station.see('b', 1, T_fixed_sensor=T)
    with outputs(fixed_frame='world') as given:
        heard = given.client.collect(tf2_msgs.TFMessage, '/tf', RELIABLE)
        given.out.updated(station.update())
        (item,) = transforms.decode(last(heard))
        cloud = last(given.client.collect(PointCloud2, 'assembled', LATCHED))
    assert item.parent == cloud.header.frame_id == 'world'
    np.testing.assert_allclose(item.T_parent_child, T @ station.place(1, 'b'), atol=1e-12)


def test_without_tf2_msgs_everything_else_goes_out(monkeypatch, capfd):
    monkeypatch.setitem(sys.modules, 'tf2_msgs.msg', None)
    station = two_objects()
    with outputs() as given:
        given.out.updated(station.update())
        given.out.rebroadcast()
        given.out.updated(station.update())
        assert last(given.client.collect(PointCloud2, 'assembled', LATCHED)).width
        assert last(given.client.collect(MarkerArray, 'markers', LATCHED)).markers
        assert given.client.node.count_publishers('/tf') == 0
    assert capfd.readouterr().err.count('tf2_msgs is not installed') == 1
