# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The package as users install it, by pip and by colcon. Truth: what the install must hold."""

import os
from pathlib import Path
import shutil
import subprocess
import sys
import zipfile

from meta.tree import files, ROOT
import pytest

pytestmark = pytest.mark.slow

# What the wheels of ROS export to themselves when Python starts.
INHERITED = ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH', 'PYTHONPATH')
LIMIT_S = 600


@pytest.fixture
def source(tmp_path) -> Path:
    """Return a copy of the source tree: an install writes into the tree that it builds."""
    for path in files():
        target = tmp_path / 'src' / 'ros_rops' / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, target)
    return tmp_path / 'src' / 'ros_rops'


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
                'share/ros_rops/config/default.yaml', 'share/ros_rops/bags/demo.mcap'):
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
    assert (share / 'ros_rops' / 'config' / 'default.yaml').exists()
    output = _run(
        ['bash', '-c', '. install/local_setup.bash && '
         'python -c "import ros_rops; print(ros_rops.__file__)" && '
         'install/ros_rops/lib/ros_rops/rops doctor'], workspace, **prefix)
    # The one that colcon installed, not the one that the tests run from.
    assert str(workspace) in output.splitlines()[0]
    assert 'the C++ kernels are built' in output
