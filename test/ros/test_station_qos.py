# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What publishers offer, and what the registration node makes of it.

Truth: the table of compatible QoS policies of ROS 2; a frame that is heard has its word.
"""

import array

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100
from rclpy.qos import QoSProfile  # noqa: E402
from ros.harness import (  # noqa: E402
    BEST_EFFORT, LATCHED, RELIABLE, ROOT, station, wait_for)
from ros_rops.recordings.messages import RawMessage  # noqa: E402
from ros_rops.recordings.storage import open_storage  # noqa: E402
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

HANDLED = QoSProfile(depth=1000)
SMALL = PointCloud2(
    header=Header(frame_id='camera'), height=1, width=2, point_step=12, row_step=24,
    data=array.array('B', bytes(24)), fields=[
        PointField(name=axis, offset=4 * k, datatype=PointField.FLOAT32, count=1)
        for k, axis in enumerate('xyz')])


def _send_until_heard(client, publisher, handled):
    """Publish until a word comes: the node may just be subscribing anew."""
    def heard():
        publisher.publish(SMALL)
        return handled

    wait_for(heard, 'a word')


@pytest.mark.parametrize('offered', [RELIABLE, BEST_EFFORT], ids=['reliable', 'best_effort'])
def test_auto_takes_what_is_offered(tmp_path, offered):
    with station(tmp_path) as (process, client):
        handled = client.collect(Header, 'handled', HANDLED)
        publisher = client.node.create_publisher(PointCloud2, 'views', offered)
        _send_until_heard(client, publisher, handled)
        assert handled[0].frame_id == 'camera'
        assert ('offers best effort only' in process.output) == (offered is BEST_EFFORT)
        if offered is BEST_EFFORT:
            assert 'shared-memory segment' in process.output


def test_auto_still_hears_a_reliable_publisher_beside_one_of_best_effort(tmp_path):
    with station(tmp_path) as (process, client):
        handled = client.collect(Header, 'handled', HANDLED)
        first = client.node.create_publisher(PointCloud2, 'views', BEST_EFFORT)
        process.says('offers best effort only')
        second = client.publisher(PointCloud2, 'views', RELIABLE)
        for publisher in (first, second):
            handled.clear()
            _send_until_heard(client, publisher, handled)


def test_explicit_reliable_says_what_to_change(tmp_path):
    with station(tmp_path, {'input.reliability': 'reliable'}) as (process, client):
        health = client.collect(DiagnosticArray, '/diagnostics')
        client.node.create_publisher(PointCloud2, 'views', BEST_EFFORT)
        text = process.says('is not heard')
        assert 'input.reliability' in text and 'ERROR' in text
        wait_for(lambda: any('input.reliability' in status.message for message in health
                             for status in message.status), 'the fault on /diagnostics')


def test_durability_that_is_not_offered_says_what_to_change(tmp_path):
    with station(tmp_path, {'input.durability': 'transient_local'}) as (process, client):
        client.node.create_publisher(PointCloud2, 'views', RELIABLE)
        assert 'input.durability to volatile' in process.says('is not heard')


def test_transient_local_gets_what_was_sent_before(tmp_path):
    with station(tmp_path, {'input.durability': 'transient_local', 'autostart': False},
                 state='unconfigured') as (_, client):
        publisher = client.node.create_publisher(PointCloud2, 'views', LATCHED)
        publisher.publish(SMALL)
        assert client.change('configure')
        handled = client.collect(Header, 'handled', HANDLED)
        assert client.change('activate')
        wait_for(lambda: handled, 'a word on what was sent before')


def test_depth_images_with_camera_info_remapped(tmp_path):
    """One frame of bags/table.mcap, on topics of the driver's own."""
    names = {'depth/image': '/cam/image', 'depth/camera_info': '/cam/info'}
    with open_storage(ROOT / 'bags' / 'table.mcap') as storage:
        messages = {}
        topics = frozenset({'/camera/depth/image_rect_raw', '/camera/depth/camera_info'})
        for item in storage.messages(topics):
            if isinstance(item, RawMessage):
                messages.setdefault(item.channel.kind, bytes(item.data))
    with station(tmp_path, {'input.kind': 'depth', 'input.color': False},
                 remap=names) as (_, client):
        handled = client.collect(Header, 'handled', HANDLED)
        infos = client.publisher(CameraInfo, '/cam/info')
        images = client.publisher(Image, '/cam/image')
        infos.publish(messages['sensor_msgs/msg/CameraInfo'])
        images.publish(messages['sensor_msgs/msg/Image'])
        wait_for(lambda: handled, 'a word on the image')
        assert client.ask('finish')[0]
