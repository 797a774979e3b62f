# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the node logs. Truth: what was done to it, and the names of its run folders."""

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros.harness import demo_clouds, station  # noqa: E402, I100
from sensor_msgs.msg import PointCloud2  # noqa: E402

BROKEN = PointCloud2(width=100, height=1, point_step=12, row_step=1200)


def test_one_line_for_each_thing_a_user_asks_about(tmp_path):
    remap = {'views': '/camera/points'}
    with station(tmp_path, {'selection.method': 'every'}, remap=remap) as (process, client):
        process.says(f'a new run, in {tmp_path / "run_0001"}')
        process.says('active: listening on /camera/points')
        process.says('Nobody publishes /camera/points')
        views = client.publisher(PointCloud2, '/camera/points')
        process.says('Listening, 0 frames so far')
        views.publish(demo_clouds(1)[0])
        process.says('Pending: waits for views that overlap it')
        for _ in range(20):
            views.publish(BROKEN)
        client.ask('save')
        process.says(f'saved 0 objects of 1 view to {tmp_path / "run_0001"}')
        # Frames come as often as the sensor sends them, words on what is wrong with them do not.
        assert 1 <= process.output.count('Bad: ') <= 3, process.output
        client.ask('reset')
        process.says(f'a new run, in {tmp_path / "run_0002"}')
        client.change('deactivate')
        process.says('listening no more')


def test_what_was_saved_just_before_the_end_is_said(tmp_path):
    with station(tmp_path) as (process, client):
        client.ask('save')
        process.end()
        assert f'saved 0 objects of 0 views to {tmp_path / "run_0001"}' in process.output
