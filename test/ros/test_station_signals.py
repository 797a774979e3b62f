# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
How the registration node ends.

Truth: exit code 0 and no traceback after SIGINT and SIGTERM, whenever they come; every view that
was accepted stands in a journal without damage.
"""

import signal
import time

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from diagnostic_msgs.msg import DiagnosticStatus  # noqa: E402, I100
from rclpy.qos import QoSProfile  # noqa: E402
from ros.harness import (  # noqa: E402
    demo_clouds, LATCHED, NodeProcess, ros_arguments, station, wait_for)
from ros_rops.intake.past import Past  # noqa: E402
from sensor_msgs.msg import PointCloud2  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

HANDLED = QoSProfile(depth=1000)


def _views(folder) -> int:
    """Return how many views are in the journal, which is whole."""
    [path] = folder.glob('run_*/journal.mcap')
    past = Past(path)
    views = sum(len(entry.views) for entry in past)
    assert (past.torn, past.damage) == (0, ''), path
    return views


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('state', ['unconfigured', 'active'])
def test_one_signal(tmp_path, number, state):
    with station(tmp_path, {'autostart': state == 'active'}, state=state) as (process, _):
        assert process.end(number) == 0


@pytest.mark.parametrize('second', [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_while_a_registration_is_under_way(tmp_path, second):
    with station(tmp_path) as (process, client):
        handled = client.collect(Header, 'handled', HANDLED)
        publisher = client.publisher(PointCloud2, 'views')
        clouds = demo_clouds(6)
        for cloud in clouds:
            publisher.publish(cloud)
        wait_for(lambda: handled, 'the first word')
        # What has its word is in the journal; so is what was looked at and still waits for one.
        words = len(handled)
        process.send(signal.SIGINT)
        began = time.monotonic()
        while process.code is None and time.monotonic() - began < 20.0:
            process.send(second)
            time.sleep(0.02)
        assert process.code == 0
    assert words <= _views(tmp_path) <= len(clouds)


@pytest.mark.alone
def test_the_process_ends_before_ros_launch_loses_patience(tmp_path):
    with station(tmp_path) as (process, client):
        handled = client.collect(Header, 'handled', HANDLED)
        publisher = client.publisher(PointCloud2, 'views')
        for cloud in demo_clouds():
            publisher.publish(cloud)
        wait_for(lambda: handled, 'the first word')
        began = time.monotonic()
        assert process.end() == 0
        assert time.monotonic() - began < 5.0
    assert _views(tmp_path) >= 1


def test_what_was_cut_off_is_there_after_resume(tmp_path):
    with station(tmp_path) as (process, client):
        handled = client.collect(Header, 'handled', HANDLED)
        publisher = client.publisher(PointCloud2, 'views')
        for cloud in demo_clouds(4):
            publisher.publish(cloud)
        wait_for(lambda: len(handled) >= 2, 'two words')
        process.end()
    views = _views(tmp_path)
    with station(tmp_path, {'resume': True}) as (_, client):
        assert client.ask('remove_last_view')[0]
        assert len(list(tmp_path.glob('run_*/journal.mcap'))) == 1
    assert _views(tmp_path) == views


def test_killed_and_resumed(tmp_path):
    """Killed, nothing can be cleaned up: what had its word stands where it stood."""
    with station(tmp_path, expected=(-signal.SIGKILL,)) as (process, client):
        handled = client.collect(Header, 'handled', HANDLED)
        reports = client.collect(DiagnosticStatus, 'view_reports', LATCHED)
        publisher = client.publisher(PointCloud2, 'views')
        for k, cloud in enumerate(demo_clouds(5)):
            publisher.publish(cloud)
            wait_for(lambda k=k: len(handled) > k, 'a word')
        wait_for(lambda: len({report.name for report in reports}) == 5, 'reports')
        stood = {report.name: report.message for report in reports}
        publisher.publish(demo_clouds(6)[5])
        process.end(signal.SIGKILL)
    with station(tmp_path, {'resume': True}) as (_, client):
        resumed = client.collect(DiagnosticStatus, 'view_reports', LATCHED)
        wait_for(lambda: stood.items() <= {
            report.name: report.message for report in resumed}.items() or len(
                {report.name for report in resumed}) == 6, 'the views of before')
        assert stood.keys() <= {report.name for report in resumed}


@pytest.mark.parametrize('delay', [0.2, 0.35, 0.5, 0.7, 0.9, 1.2])
def test_a_signal_while_the_node_starts(tmp_path, delay):
    """At any moment; before our first line Python itself may say that it was interrupted."""
    with NodeProcess(
            'registration_node', ros_arguments({'output.folder': tmp_path})) as process:
        wait_for(lambda: _blocks_signals(process.pid), 'the first line of the node')
        time.sleep(delay)
        assert process.end() == 0


def _blocks_signals(pid: int) -> bool:
    with open(f'/proc/{pid}/status', encoding='ascii') as status:
        blocked = next(int(line.split()[1], 16) for line in status if line.startswith('SigBlk'))
    return bool(blocked >> (signal.SIGINT - 1) & 1)
