# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What ~/save writes beside the poses. Truth: `rops model` on the same folder; the clock."""

import time

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100
from ros.harness import demo_clouds, station, wait_for  # noqa: E402
from ros_rops.cli.main import main  # noqa: E402
from sensor_msgs.msg import PointCloud2  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

WANTED = {'output.models': True, 'output.report': True, 'output.picture': False}
FEW = 5


def _models(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()
            if path.name.startswith('object_') or path.name == 'quality.json'}


def test_save_writes_models_and_report_while_the_node_goes_on_or_ends(tmp_path):
    with station(tmp_path, WANTED) as (process, client):
        handled = client.collect(Header, 'handled', 10)
        health = client.collect(DiagnosticArray, '/diagnostics', 10)
        publisher = client.publisher(PointCloud2, 'views')
        for k, cloud in enumerate(demo_clouds(FEW)):
            publisher.publish(cloud)
            wait_for(lambda k=k: len(handled) > k, 'the word on a view')
        assert client.ask('save')[0]
        folder = tmp_path / 'run_0001'
        wait_for((folder / 'poses.json').exists, 'the poses')
        times = []
        while not (folder / 'report.html').exists():
            began = time.monotonic()
            assert client.ask('pause', False)[0]
            times.append(time.monotonic() - began)
            time.sleep(0.02)
            assert sum(times) < 60.0, process.output
        # Nothing waits for the models: the poses were there long before.
        assert len(times) > 3 and sorted(times)[len(times) // 2] < 1.0
        process.says('models and report written in ')

        def told():
            said = {item.key: item.value for message in health for part in message.status
                    for item in part.values}
            return 'models and report written' in said.get('last_save', '')

        wait_for(told, 'the diagnostics')
        assert 'ERROR' not in process.output
        assert main(['model', str(folder), '--out', str(tmp_path / 'again')]) == 0
        found = _models(folder)
        assert {'object_0.ply', 'object_0_surface.ply', 'quality.json'} <= set(found)
        assert found == _models(tmp_path / 'again')
        # Saved again, and ended meanwhile.
        assert client.ask('save')[0]
        wait_for(lambda: not (folder / 'quality.json').exists() and (
            folder / 'poses.json').exists(), 'the poses')
        assert process.end() == 0
    assert 'the models are not made (the station ends)' in process.output
    assert not (folder / '.models').exists() and not (folder / 'report.html').exists()
