# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which of several messages that wait is taken first. Truth: a frame needs what belongs to it.

Publishers in the node's own process hand on what they are given before they return.
"""

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from rclpy.executors import SingleThreadedExecutor  # noqa: E402, I100
from ros.harness import RELIABLE, wait_for  # noqa: E402
from ros_rops.core.groups_node import InputConfig  # noqa: E402
from ros_rops.nodes.inputs import Inputs  # noqa: E402
from sensor_msgs.msg import CameraInfo, Image, PointCloud2  # noqa: E402
from std_msgs.msg import String  # noqa: E402


@pytest.mark.parametrize(('kind', 'sent'), [
    ('depth', {'depth/image': Image, 'color/image': Image, 'depth/camera_info': CameraInfo}),
    ('cloud', {'views': PointCloud2, 'view_facts': String})])
def test_what_belongs_to_a_frame_is_taken_before_it(kind, sent):
    taken = []
    context = rclpy.Context()
    context.init()
    node = rclpy.create_node('order', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        Inputs(
            node, InputConfig(kind=kind), lambda raw: taken.append(raw.channel.topic.lstrip('/')),
            lambda topic, count: None)
        publishers = [
            (node.create_publisher(message, topic, RELIABLE), message)
            for topic, message in sent.items()]
        wait_for(lambda: all(p.get_subscription_count() for p, _ in publishers), 'the inputs')
        for publisher, message in publishers:
            publisher.publish(message())

        def taken_all():
            executor.spin_once(timeout_sec=0.1)
            return len(taken) == len(sent)

        wait_for(taken_all, 'all messages')
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()
    assert set(taken) == set(sent)
    assert taken[-1] == next(iter(sent))
