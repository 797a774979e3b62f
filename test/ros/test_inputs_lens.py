# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the lens is taken out of depth images. Truth: ROS's custom for their topics' names."""

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros_rops.core.node_config import NodeConfig  # noqa: E402, I100
from ros_rops.nodes.inputs import with_lens  # noqa: E402


@pytest.mark.parametrize(('given', 'topic', 'lens'), [
    ('auto', '/camera/depth/image_rect_raw', 'rectified'),
    ('auto', '/rectified/depth/image_raw', 'raw'),
    ('auto', '', 'raw'),
    ('rectified', '/camera/depth/image_raw', 'rectified'),
    ('raw', '/camera/depth/image_rect', 'raw'),
])
def test_the_lens_is_told_by_the_name_that_the_topic_is_remapped_to(given, topic, lens):
    context = rclpy.Context()
    context.init()
    words = ['--ros-args', '-r', f'depth/image:={topic}'] if topic else []
    node = rclpy.create_node('lens', context=context, cli_args=words)
    try:
        config = with_lens(node, NodeConfig.from_flat({'input.lens': given}))
    finally:
        node.destroy_node()
        context.try_shutdown()
    assert config.input.lens == lens
