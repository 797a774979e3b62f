# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The launch files, by ROS's own launch. Truth: what the arguments say, and `rops replay`.

launch and launch_ros have no wheels: these tests run where ROS is installed, or where the two are
on PYTHONPATH.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from meta.tree import ROOT
import pytest
from reference.runs import BARE

pytest.importorskip('launch_ros.actions', reason='no launch_ros here: it comes with ROS only')
rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from lifecycle_msgs.srv import GetState  # noqa: E402, I100
from rcl_interfaces.srv import GetParameters  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.parameter import parameter_value_to_python  # noqa: E402
from ros_rops.cli.main import main  # noqa: E402

PATIENCE_S = 60.0
# `ros2 launch FILE NAME:=VALUE ...`, which is no wheel either.
LAUNCH = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
file, *given = sys.argv[1:]
service = LaunchService(argv=given)
service.include_launch_description(LaunchDescription([IncludeLaunchDescription(
    PythonLaunchDescriptionSource(file),
    launch_arguments=[tuple(word.split(':=', 1)) for word in given])]))
raise SystemExit(service.run())
"""


@pytest.fixture(scope='module')
def environment(tmp_path_factory) -> dict[str, str]:
    """Return an environment in which ROS finds this package as if colcon had installed it."""
    prefix = tmp_path_factory.mktemp('prefix')
    for node in ('registration_node', 'replay_node'):
        _install(
            prefix, 'ros_rops', node,
            f'exec "{sys.executable}" -m ros_rops.nodes.{node} "$@"')
    # There is no wheel of RViz: what it would be started with is written down.
    _install(prefix, 'rviz2', 'rviz2', f'echo "$@" > "{prefix}/rviz"')
    # The wheels of ROS start Python again and mark that as done, for this process only.
    kept = {
        key: value for key, value in os.environ.items()
        if key not in ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH')}
    own = os.pathsep.join([str(ROOT), *filter(None, [kept.get('PYTHONPATH')])])
    prefixes = [str(prefix), kept.get('AMENT_PREFIX_PATH') or sys.prefix]
    return {**kept, 'AMENT_PREFIX_PATH': os.pathsep.join(prefixes), 'PYTHONPATH': own,
            'ROS_LOG_DIR': str(prefix / 'log')}


def _install(prefix: Path, package: str, program: str, script: str) -> None:
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    folder = prefix / 'lib' / package
    for place in (index, folder):
        place.mkdir(parents=True, exist_ok=True)
    (index / package).touch()
    (folder / program).write_text(f'#!/bin/sh\n{script}\n')
    (folder / program).chmod(0o755)


def _start(environment: dict[str, str], file: str, *given: str) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, '-c', LAUNCH, str(ROOT / 'launch' / file), *given], env=environment,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))


def _kill(process: subprocess.Popen) -> None:
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@contextmanager
def _running(environment: dict[str, str], file: str, *given: str) -> Iterator[subprocess.Popen]:
    """Launch, and end it as Ctrl-C does, which all of a terminal get; it must go cleanly."""
    process = _start(environment, file, *given)
    try:
        yield process
        os.killpg(process.pid, signal.SIGINT)
        output, _ = process.communicate(timeout=PATIENCE_S)
    finally:
        _kill(process)
    assert 'Traceback' not in output and 'ERROR' not in output, output


class Station:
    """Asks a launched node."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self.node = rclpy.create_node('asking', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def close(self) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    def until(self, true) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not true():
            assert time.monotonic() < deadline, 'nothing came'
            self._executor.spin_once(timeout_sec=0.05)

    def ask(self, kind, service: str, request):
        client = self.node.create_client(kind, f'{self._name}/{service}')
        self.until(client.service_is_ready)
        future = client.call_async(request)
        self.until(future.done)
        return future.result()

    def state(self) -> str:
        return self.ask(GetState, 'get_state', GetState.Request()).current_state.label

    def values(self, *names: str) -> list:
        request = GetParameters.Request(names=list(names))
        answer = self.ask(GetParameters, 'get_parameters', request)
        return [parameter_value_to_python(value) for value in answer.values]

    def listens(self, topic: str) -> bool:
        return any(
            info.node_name == self._name.rpartition('/')[2]
            for info in self.node.get_subscriptions_info_by_topic(topic))


@pytest.fixture
def asking():
    """Return a maker of `Station`s, which are closed in the end."""
    made = []

    def make(name: str) -> Station:
        made.append(Station(name))
        return made[-1]

    yield make
    for one in made:
        one.close()


def test_a_station_is_what_its_arguments_say(environment, asking, tmp_path):
    own = tmp_path / 'own.yaml'
    own.write_text('/**:\n  ros__parameters:\n    segmentation:\n      far_m: 0.9\n')
    station = asking('/cell_7/rops_registration')
    with _running(
            environment, 'station.launch.py', 'namespace:=cell_7', 'preset:=turntable, kinect',
            f'params_file:={own}', f'output_folder:={tmp_path}', 'color:=false',
            'depth_image:=/camera/depth/image_rect_raw', 'log_level:=warn'):
        # Of the first preset, of the second, of the own file over it, of an argument over both.
        assert station.values(
            'selection.method', 'segmentation.near_m', 'segmentation.far_m', 'input.color'
        ) == ['still', 0.15, 0.9, False]
        assert station.values('input.kind', 'output.folder', 'use_sim_time') == [
            'depth', str(tmp_path), False]
        station.until(lambda: station.listens('/camera/depth/image_rect_raw'))
        assert station.listens('/camera/depth/camera_info')  # beside the image
        assert not station.listens('/cell_7/depth/image')
        station.until(lambda: station.state() == 'active')


def test_without_autostart_it_waits_for_a_manager(environment, asking, tmp_path):
    station = asking('/rops_registration')
    with _running(
            environment, 'station.launch.py', 'autostart:=false', 'views:=/scanner/points',
            f'output_folder:={tmp_path}', 'resume:=true', 'use_sim_time:=true'):
        assert station.state() == 'unconfigured'
        assert station.values('autostart', 'resume', 'use_sim_time', 'input.kind') == [
            False, True, True, 'cloud']


def test_rviz_shows_the_station_of_the_namespace(environment, asking, tmp_path):
    station = asking('/cell_9/rops_registration')
    written = Path(environment['ROS_LOG_DIR']).parent / 'rviz'
    with _running(
            environment, 'station.launch.py', 'namespace:=cell_9', 'rviz:=true',
            f'output_folder:={tmp_path}'):
        station.until(lambda: station.state() == 'active' and written.exists())
    words = written.read_text()
    assert f'--display-config {ROOT}/rviz/station.rviz --fixed-frame cell_9/object_0' in words
    assert '/assembled:=/cell_9/assembled' in words and '/markers:=/cell_9/markers' in words


@pytest.mark.parametrize(('file', 'given', 'said'), [
    ('station.launch.py', ['preset:=merry_go_round'], 'no such parameter file'),
    ('station.launch.py', ['params_file:=missing.yaml'], 'no such parameter file'),
    ('station.launch.py', ['views:=/a', 'depth_image:=/b/c'], 'one of the two'),
    ('station.launch.py', ['autostart:=perhaps'], 'autostart'),
    ('replay.launch.py', ['recording:=missing.mcap'], 'missing.mcap'),
    ('replay.launch.py', [f'recording:={ROOT}/bags/demo.mcap', 'rate:=fast'], 'rate'),
])
def test_a_mistake_is_said_and_nothing_runs(environment, file, given, said):
    process = _start(environment, file, *given)
    output, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode != 0 and said in output, output
    assert 'process started' not in output


def test_a_replay_ends_with_the_poses_of_rops_replay(environment, tmp_path):
    recording, preset = ROOT / 'bags' / 'turning.mcap', ROOT / 'config' / 'turntable.yaml'
    process = _start(
        environment, 'replay.launch.py', f'recording:={recording}', 'preset:=turntable',
        f'output_folder:={tmp_path}/runs', 'namespace:=cell_8', 'shutdown:=true')
    try:
        output, _ = process.communicate(timeout=2 * PATIENCE_S)
    finally:
        _kill(process)
    assert process.returncode == 0 and 'Traceback' not in output, output
    assert main(['replay', str(recording), '--out', str(tmp_path / 'run'), *BARE,
                 '--config', str(preset)]) == 0
    found = _poses(tmp_path / 'runs' / 'latest' / 'poses.json')
    assert len(found[0]) == 6 and found == _poses(tmp_path / 'run' / 'poses.json')


def _poses(path: Path) -> list:
    content = json.loads(path.read_text(encoding='utf-8'))
    return [[view['T_object_view'] for view in item['views']] for item in content['objects']]
