# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Check this machine and installation.

A line a check: OK, WARN (something is lacking that you may not need) or FAIL (rops will not
work), and what to do. Exit code 1 if anything failed.
"""

import argparse
from collections.abc import Callable
from importlib import metadata
import importlib.util
import os
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile
from typing import NamedTuple

from ros_rops.core.errors import KernelMissingError

NEEDED = ('numpy', 'scipy', 'pyyaml', 'matplotlib', 'scikit-image', 'mcap', 'mcap-ros2-support')


class Finding(NamedTuple):
    """What a check found: OK, WARN or FAIL, and a sentence."""

    level: str
    text: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare no option."""


def run(args: argparse.Namespace) -> int:
    """Print every check."""
    findings = [check() for check in CHECKS]
    for finding in findings:
        print(f'{finding.level:4s}  {finding.text}')
    return 1 if any(finding.level == 'FAIL' for finding in findings) else 0


def python() -> Finding:
    """Say which interpreter runs (an older one than 3.11 cannot install the package)."""
    version = '.'.join(map(str, sys.version_info[:3]))
    return Finding('OK', f'Python {version} ({sys.executable})')


def packages() -> Finding:
    """Check what rops needs to run."""
    found, missing = [], []
    for name in NEEDED:
        try:
            found.append(f'{name} {metadata.version(name)}')
        except metadata.PackageNotFoundError:
            missing.append(name)
    if missing:
        return Finding('FAIL', f'missing packages: pip install {" ".join(missing)}')
    return Finding('OK', ', '.join(found))


def kernels() -> Finding:
    """Check the built module."""
    try:
        importlib.import_module('ros_rops.kernels')
    except KernelMissingError as error:
        return Finding('FAIL', str(error))
    return Finding('OK', 'the C++ kernels are built')


def threads() -> Finding:
    """Check the cores that this process may use."""
    cores = len(os.sched_getaffinity(0))
    if cores < 2:
        return Finding('WARN', '1 core: everything works, slowly')
    return Finding('OK', f'{cores} cores')


def disk() -> Finding:
    """Check that a run folder can be written here."""
    try:
        with tempfile.TemporaryFile(dir='.'):
            pass
    except OSError as error:
        return Finding('FAIL', f'{Path.cwd()}: cannot be written ({error.strerror}); use another '
                       'folder for --out')
    free = shutil.disk_usage('.').free / 1e9
    if free < 1.0:
        return Finding('WARN', f'{Path.cwd()}: {free:.1f} GB free; a run takes up to 0.5 GB')
    return Finding('OK', f'{Path.cwd()}: writable, {free:.0f} GB free')


def open3d() -> Finding:
    """Check what Poisson surfaces need, in a process of its own: a broken one may abort."""
    if importlib.util.find_spec('open3d') is None:
        return Finding('WARN', 'Open3D: not installed; model.surface=poisson needs it, and '
                       '`rops bench` compares with it (pip install ros_rops[poisson])')
    done = subprocess.run(
        [sys.executable, '-c', 'import open3d'], capture_output=True, text=True, check=False)
    if done.returncode:
        words = done.stderr.strip().splitlines() or [f'exit code {done.returncode}']
        return Finding('WARN', f'Open3D: cannot be imported ({words[-1]}); 0.20 needs the system '
                       'package libusb-1.0-0, 0.19 does not')
    return Finding('OK', f'Open3D {metadata.version("open3d")}')


def ros() -> Finding:
    """Check whether ROS is there."""
    if importlib.util.find_spec('rclpy') is None:
        return Finding('WARN', 'rclpy: not found; only the ROS nodes need it (source '
                       '/opt/ros/jazzy/setup.bash)')
    return Finding('OK', f'rclpy found, ROS_DISTRO={os.environ.get("ROS_DISTRO", "not set")}')


def data() -> Finding:
    """Check the folder of real scans that tests and benchmarks use."""
    folder = Path(os.environ.get('ROPS_DATA', '../shared/data'))
    sets = sorted(path.parent.name for path in folder.glob('*/reference_poses.json'))
    if not sets:
        return Finding('WARN', f'{folder}: no data sets (set ROPS_DATA); only benchmarks and the '
                       'tests on real scans need them')
    return Finding('OK', f'{folder}: {", ".join(sets)}')


CHECKS: tuple[Callable[[], Finding], ...] = (
    python, packages, kernels, threads, disk, open3d, ros, data)
