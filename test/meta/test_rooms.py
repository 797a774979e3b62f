# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The directions of imports. Truth: the rules of the architecture, written down here."""

from pathlib import Path

from meta.tree import imports, name, python_files, ROOT
import pytest

# Which of our modules each room may import beside its own.
ALLOWED = {
    'core': ('ros_rops.kernels',),
    'kernels': ('ros_rops.core.types', 'ros_rops.core.errors'),
    'recordings': (
        'ros_rops.core.types', 'ros_rops.core.errors', 'ros_rops.core.frame', 'ros_rops.kernels',
        'msg_adapters'),
    'segmentation': ('ros_rops.core', 'ros_rops.kernels'),
    'modelling': ('ros_rops.core', 'ros_rops.kernels'),
    'pipeline': ('ros_rops.core', 'ros_rops.kernels'),
    'intake': (
        'ros_rops.core', 'ros_rops.pipeline', 'ros_rops.recordings', 'ros_rops.segmentation',
        'msg_adapters'),
    'live': (
        'ros_rops.core', 'ros_rops.pipeline', 'ros_rops.recordings', 'ros_rops.segmentation',
        'ros_rops.intake', 'ros_rops.reporting', 'msg_adapters'),
    'reporting': (
        'ros_rops.core', 'ros_rops.pipeline', 'ros_rops.recordings', 'ros_rops.modelling',
        'ros_rops.segmentation'),
    'msg_adapters': ('ros_rops.core.types', 'ros_rops.core.errors'),
}
ROS = ('rclpy', 'sensor_msgs', 'geometry_msgs', 'std_msgs', 'tf2_ros', 'visualization_msgs',
       'diagnostic_msgs', 'launch', 'launch_ros', 'ament_index_python')
FILES_AND_WINDOWS = (
    'pathlib', 'io', 'matplotlib', 'open3d', 'subprocess', 'tempfile', 'time')


def _below(module: str, packages: tuple[str, ...]) -> bool:
    return any(module == package or module.startswith(package + '.') for package in packages)


def _folder(room: str) -> str:
    return room if room == 'msg_adapters' else f'ros_rops/{room}'


def _violations(files: list[Path], forbidden) -> list[str]:
    return [
        f'{name(path)} imports {module}'
        for path in files for module in imports(path) if forbidden(module)]


@pytest.mark.parametrize('room', ALLOWED)
def test_room_imports_only_what_it_may(room):
    own = room if room == 'msg_adapters' else f'ros_rops.{room}'
    allowed = (own, *ALLOWED[room])

    def forbidden(module: str) -> bool:
        return _below(module, ('ros_rops', 'msg_adapters')) and not (
            module == 'ros_rops' or _below(module, allowed))

    assert _violations(python_files(_folder(room)), forbidden) == []


def test_nobody_imports_nodes_cli_or_bench():
    outer = ('nodes', 'cli', 'bench')
    bad = []
    for path in python_files('ros_rops', 'msg_adapters'):
        room = path.relative_to(ROOT / 'ros_rops').parts[0] if 'ros_rops' in path.parts else ''
        # The command is the door to the benches.
        closed = tuple(
            f'ros_rops.{other}' for other in outer
            if other != room and (room, other) != ('cli', 'bench'))
        bad += _violations([path], lambda module, closed=closed: _below(module, closed))
    assert bad == []


def test_only_nodes_import_ros():
    files = [
        path for path in python_files('ros_rops', 'msg_adapters')
        if not name(path).startswith('ros_rops/nodes/')]
    # `rops doctor` looks whether it is there, by name.
    assert _violations(files, lambda module: _below(module, ROS)) == []


def test_core_and_kernels_know_no_file_window_or_clock():
    files = python_files('ros_rops/core', 'ros_rops/kernels')
    assert _violations(files, lambda module: _below(module, FILES_AND_WINDOWS)) == []
