# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The package as users install it, by pip and by colcon. Truth: what the install must hold."""

from collections.abc import Iterator
import importlib.util
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile

from meta.tree import files, ROOT
import pytest
from reference.domains import own_domain

pytestmark = pytest.mark.slow

# What the wheels of ROS export to themselves when Python starts.
INHERITED = ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH', 'PYTHONPATH')
LIMIT_S = 300
# What `ros2 launch`, `ros2 run` and people look for.
SHARED = (
    'bags/demo.mcap', 'config/default.yaml', 'config/fastdds.xml', 'config/turntable.yaml',
    'foxglove/station.json', 'launch/replay.launch.py', 'launch/station.launch.py',
    'rviz/station.rviz')
PROGRAMS = ('registration_node', 'replay_node', 'rops')


@pytest.fixture
def source(tmp_path) -> Path:
    """Return a copy of the source tree: an install writes into the tree that it builds."""
    for path in files():
        target = tmp_path / 'src' / 'ros_rops' / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, target)
    return tmp_path / 'src' / 'ros_rops'


@pytest.fixture(scope='module', autouse=True)
def compiled_once(tmp_path_factory) -> Iterator[None]:
    """Let the copies share what is compiled: the first install compiles all, the others link."""
    script = f'{ROOT / "test" / "reference" / "compile_once.sh"} {tmp_path_factory.mktemp("kept")}'
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('CC', f'{script} {os.environ.get("CC", "gcc")}')
        patch.setenv('CXX', f'{script} {os.environ.get("CXX", "g++")}')
        yield


def _run(words: list[str], folder: Path, **extra: str) -> str:
    environment = {key: value for key, value in os.environ.items() if key not in INHERITED}
    done = subprocess.run(
        words, cwd=folder, env={**environment, **extra}, capture_output=True, text=True,
        check=False, timeout=LIMIT_S)
    assert done.returncode == 0, f'{done.stdout}\n{done.stderr}'
    return done.stdout


def test_wheel_holds_the_kernels_the_types_and_what_ros_looks_for(source, tmp_path):
    pytest.importorskip('wheel', reason='no wheel package here')
    _run(
        [sys.executable, '-m', 'pip', 'wheel', '--quiet', '--no-deps', '--no-build-isolation',
         '--wheel-dir', str(tmp_path), str(source)], tmp_path)
    names = zipfile.ZipFile(next(tmp_path.glob('*.whl'))).namelist()
    for end in ('ros_rops/py.typed', 'ros_rops/cli/main.py', 'msg_adapters/point_cloud2.py',
                'resource_index/packages/ros_rops', 'share/ros_rops/package.xml',
                *(f'share/ros_rops/{path}' for path in SHARED)):
        assert any(name.endswith(end) for name in names), end
    assert any(name.startswith('ros_rops/kernels/_kernels.') and name.endswith('.so')
               for name in names)
    assert not any(name.startswith(('test/', 'reference/')) for name in names)


@pytest.mark.parametrize('options', [[], ['--symlink-install']], ids=['plain', 'symlink'])
def test_colcon_builds_what_ros_runs(source, options):
    colcon = Path(sys.executable).parent / 'colcon'
    if not colcon.exists():
        pytest.skip('no colcon in this environment')
    workspace = source.parent.parent
    prefix = {'AMENT_PREFIX_PATH': sys.prefix, 'CMAKE_PREFIX_PATH': sys.prefix,
              'PATH': f'{colcon.parent}{os.pathsep}{os.environ["PATH"]}'}
    _run([str(colcon), 'build', *options], workspace, **prefix)
    share = workspace / 'install' / 'ros_rops' / 'share'
    assert (share / 'ament_index' / 'resource_index' / 'packages' / 'ros_rops').exists()
    for path in SHARED:
        assert (share / 'ros_rops' / path).is_file(), path
    programs = workspace / 'install' / 'ros_rops' / 'lib' / 'ros_rops'
    assert {path.name for path in programs.iterdir()} == set(PROGRAMS)
    output = _run(
        ['bash', '-c', '. install/local_setup.bash && '
         'python -c "import ros_rops; print(ros_rops.__file__)" && '
         'install/ros_rops/lib/ros_rops/rops doctor'], workspace, **prefix)
    # The one that colcon installed, not the one that the tests run from.
    assert str(workspace) in output.splitlines()[0]
    assert 'the C++ kernels are built' in output
    if importlib.util.find_spec('rclpy') is not None:
        _start_and_end(programs / 'registration_node', workspace, **prefix)
    if not options:
        _test_what_is_installed(colcon, workspace, **prefix)


def _start_and_end(program: Path, workspace: Path, **extra: str) -> None:
    """Start the node as `ros2 run` does, until it has a session, and end it."""
    environment = {key: value for key, value in os.environ.items() if key not in INHERITED}
    process = subprocess.Popen(
        ['bash', '-c', f'. install/local_setup.bash && exec "{program}" --ros-args '
         f'-p output.folder:="{workspace}/runs"'], cwd=workspace, text=True,
        env={**environment, **extra, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
             'ROS_LOG_DIR': str(workspace / 'log'),
             'ROS_DOMAIN_ID': str(own_domain(17))},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    deadline = time.monotonic() + LIMIT_S
    try:
        # Configured, it has the folder of a run.
        while not list((workspace / 'runs').glob('*/journal.mcap')):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=LIMIT_S)
    finally:
        process.kill()
    assert process.returncode == 0 and 'Traceback' not in output, output


def _test_what_is_installed(colcon: Path, workspace: Path, **extra: str) -> None:
    """Run a few of the tests that `colcon test` runs: where they look is what counts."""
    where = workspace / 'src' / 'ros_rops' / 'test' / 'unit' / 'test_se3_of_colcon.py'
    where.write_text(
        'import ros_rops\n\n\ndef test_where_it_is():\n'
        f'    assert ros_rops.__file__.startswith({str(workspace / "install")!r})\n')
    _run([str(colcon), 'test', '--pytest-args', '-k', 'where_it_is or test_paper'], workspace,
         **extra)
    result = _run([str(colcon), 'test-result', '--all'], workspace, **extra)
    assert re.search(r'Summary: [1-9]\d* tests, 0 errors, 0 failures', result), result
