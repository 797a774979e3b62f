# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The clouds that go out, over the wire. Truth: exact places, and the points handed in."""

from msg_adapters import point_cloud2
import numpy as np
import pytest
from reference.updates import Station

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros.harness import LATCHED, wait_for  # noqa: E402, I100
from ros.outputs_beside import last, outputs, two_objects  # noqa: E402
from ros_rops.core.groups_node import PublishConfig  # noqa: E402
from ros_rops.live.words import Update  # noqa: E402
from sensor_msgs.msg import PointCloud2, PointField  # noqa: E402
from visualization_msgs.msg import MarkerArray  # noqa: E402


def field(cloud, name):
    offset = {item.name: item.offset for item in cloud.fields}[name]
    return np.ndarray(cloud.width, '<i4', bytes(cloud.data), offset, (cloud.point_step,))


def same_points(found, expected):
    expected = expected.astype(np.float32)
    assert found.shape == expected.shape
    np.testing.assert_allclose(
        found[np.lexsort(found.T)], expected[np.lexsort(expected.T)], atol=3e-7)


def test_who_comes_late_gets_the_whole_model():
    station = two_objects(units='mm')
    with outputs('left') as given:
        given.out.updated(station.update())
        cloud = last(given.client.collect(PointCloud2, '/left/assembled', LATCHED))
    assert cloud.header.frame_id == 'camera'
    kinds = {item.name: item.datatype for item in cloud.fields}
    floats = ('x', 'y', 'z', 'normal_x', 'normal_y', 'normal_z', 'rgb')
    assert kinds == {
        **dict.fromkeys(floats, PointField.FLOAT32), 'object_id': PointField.INT32,
        'view_id': PointField.INT32}
    xyz, rgb = point_cloud2.decode(cloud)
    for name, object_id in (('a', 1), ('b', 2), ('c', 1), ('d', 2), ('e', 1)):
        rows = field(cloud, 'view_id') == station.numbers[name]
        assert (field(cloud, 'object_id')[rows] == object_id).all()
        # Where the object was seen last, the view as it was measured.
        newest = {1: 'e', 2: 'd'}[object_id]
        T = station.place(object_id, newest) @ station.T_object_view(object_id, name)
        view = station.views[name]
        same_points(xyz[rows], view.points / 1000.0 @ T[:3, :3].T + T[:3, 3])
        assert sorted(map(tuple, rgb[rows])) == sorted(map(tuple, view.colors))


def test_each_object_has_a_cloud_in_its_own_frame():
    station = two_objects(colored=False)
    with outputs('left') as given:
        given.out.updated(station.update())
        cloud = last(given.client.collect(
            PointCloud2, '/left/objects/object_2/assembled', LATCHED))
    assert cloud.header.frame_id == 'left/object_2'
    assert 'rgb' not in {item.name for item in cloud.fields}
    T = station.T_object_view(2, 'd')
    rows = field(cloud, 'view_id') == station.numbers['d']
    same_points(
        point_cloud2.decode(cloud)[0][rows], station.views['d'].points @ T[:3, :3].T + T[:3, 3])


def test_an_objects_cloud_is_sent_again_only_if_it_changed():
    station = two_objects()
    with outputs() as given:
        given.out.updated(station.update())
        first = given.client.collect(PointCloud2, 'objects/object_1/assembled', LATCHED)
        second = given.client.collect(PointCloud2, 'objects/object_2/assembled', LATCHED)
        every = given.client.collect(PointCloud2, 'assembled', LATCHED)
        for found in (first, second, every):
            last(found)
        for name in 'fgh':
            station.see(name, 2)
            given.out.updated(station.update())
        last(second, 2)
        wait_for(lambda: every[-1].width == 8 * station.count, 'all views')
        wait_for(lambda: second[-1].width == 5 * station.count, 'all views of object 2')
    assert len(first) == 1 and first[0].width == 3 * station.count


def test_after_a_reset_nothing_is_left():
    station = two_objects()
    with outputs() as given:
        client, names = given.client, [f'objects/object_{k}/assembled' for k in (1, 2)]
        given.out.updated(station.update(*'abcde'))
        clouds = [client.collect(PointCloud2, name, LATCHED) for name in (*names, 'assembled')]
        scenes = client.collect(MarkerArray, 'markers', LATCHED)
        for found in (*clouds, scenes):
            last(found)
        given.out.updated(Update(epoch=1))
        for found in clouds:
            wait_for(lambda found=found: found[-1].width == 0, 'an empty cloud')
        last(scenes, 2)
        for name in names:
            wait_for(lambda name=name: client.node.count_publishers(name) == 0, 'no publisher')
        assert [marker.action for marker in scenes[-1].markers] == [3]
        assert last(client.collect(PointCloud2, 'assembled', LATCHED)).width == 0
        # And a new session begins with the same numbers.
        fresh = two_objects(seed=1, epoch=1)
        given.out.updated(fresh.update())
        again = last(client.collect(PointCloud2, names[0], LATCHED))
        assert again.width == 3 * fresh.count


def test_an_object_that_another_sensor_saw_is_left_out_and_that_is_said(capfd):
    station = Station()
    for name, object_id, frame_id in (
            ('a', 1, 'left'), ('b', 1, 'left'), ('c', 2, 'right'), ('d', 2, 'right')):
        station.see(name, object_id, frame_id=frame_id)
    with outputs() as given:
        given.out.updated(station.update())
        cloud = last(given.client.collect(PointCloud2, 'assembled', LATCHED))
        given.out.updated(station.update())
    assert cloud.header.frame_id == 'right'
    assert set(field(cloud, 'object_id')) == {2}
    assert capfd.readouterr().err.count('object 1 is left out') == 1


def test_switched_off_is_not_there():
    publish = PublishConfig(objects=False, markers=False, tf=False, frame_prefix='x_')
    station = two_objects()
    with outputs('left', publish) as given:
        given.out.updated(station.update())
        last(given.client.collect(PointCloud2, 'assembled', LATCHED))
        topics = {name for name, _ in given.client.node.get_topic_names_and_types()}
        assert not topics & {
            '/left/markers', '/tf', '/left/objects/object_1/assembled'}, topics
