# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Messages that the middleware drops because the station did not take them in time.

Truth: each message that was sent has its word, or is counted as lost.
"""

import array
import itertools
import signal

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402, I100
from rclpy.qos import QoSProfile, ReliabilityPolicy  # noqa: E402
from ros.harness import station, wait_for  # noqa: E402
from sensor_msgs.msg import PointCloud2, PointField  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

SENT = 100
SMALL = PointCloud2(
    header=Header(frame_id='camera'), height=1, width=2, point_step=12, row_step=24,
    data=array.array('B', bytes(24)), fields=[
        PointField(name=axis, offset=4 * k, datatype=PointField.FLOAT32, count=1)
        for k, axis in enumerate('xyz')])


def _said(health: list, key: str) -> tuple[int, str, bytes]:
    """Return a number of the newest health, and the sentence and level that stand with it."""
    for status in health[-1].status if health else ():
        for item in status.values:
            if item.key == key:
                return int(item.value), status.message, status.level
    return 0, '', b''


def _missing(handled: list) -> int:
    """Return how many numbers are left out between the first and the last that have a word."""
    numbers = [word.stamp.sec for word in handled]
    return 1 + numbers[-1] - numbers[0] - len(numbers) if numbers else 0


@pytest.mark.parametrize('reliability', [
    ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT], ids=['reliable', 'best_effort'])
def test_what_overflows_in_the_middleware_is_counted_and_said(tmp_path, reliability):
    numbers = itertools.count(1)
    parameters = {'input.depth': 1, 'input.most_frames': 1000, 'selection.method': 'request'}
    with station(tmp_path, parameters) as (process, client):
        handled = client.collect(Header, 'handled', QoSProfile(depth=1000))
        health = client.collect(DiagnosticArray, '/diagnostics')
        publisher = client.node.create_publisher(
            PointCloud2, 'views', QoSProfile(depth=1, reliability=reliability))

        def send() -> None:
            SMALL.header.stamp.sec = next(numbers)
            publisher.publish(SMALL)

        wait_for(lambda: send() or handled, 'a word: the node may be subscribing anew')
        process.send(signal.SIGSTOP)
        try:
            for _ in range(SENT):
                send()
        finally:
            process.send(signal.SIGCONT)
        # A gap shows by what comes behind it.
        wait_for(lambda: send() or _missing(handled) > 0, 'lost messages')
        wait_for(lambda: _said(health, 'lost')[0] == _missing(handled), 'all of them counted')
        _, text, level = _said(health, 'lost')
        assert 'lost by the middleware' in text and '/views' in text
        assert level == DiagnosticStatus.WARN
