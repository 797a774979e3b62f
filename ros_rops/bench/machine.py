# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Facts of the machine that stand beside every measured time, and the memory of a process."""

import os
from pathlib import Path
import platform
import resource
import subprocess
from typing import Any

import numpy as np
import ros_rops
import scipy


def cpu_model() -> str:
    """Return the processor's name as the system tells it."""
    try:
        lines = Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines()
    except OSError:
        return platform.processor() or 'unknown'
    names = [line.partition(':')[2].strip() for line in lines if line.startswith('model name')]
    return names[0] if names else platform.processor() or 'unknown'


def usable_cores() -> int:
    """Return how many cores this process may use, which a container may limit."""
    if hasattr(os, 'sched_getaffinity'):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def git_commit() -> str | None:
    """Return the commit of the checkout that the package is run from, with '+' if it is dirty."""
    root = Path(ros_rops.__file__).resolve().parents[1]
    if not (root / '.git').exists():
        return None
    try:
        commit = _git(root, 'rev-parse', 'HEAD')
        return commit + ('+' if _git(root, 'status', '--porcelain') else '')
    except (OSError, subprocess.SubprocessError):
        return None


def _git(root: Path, *words: str) -> str:
    done = subprocess.run(
        ['git', '-C', str(root), *words], capture_output=True, text=True, check=True, timeout=20)
    return done.stdout.strip()


def machine_facts() -> dict[str, Any]:
    """Return the `machine` entry of a benchmark's JSON."""
    return {
        'cpu': cpu_model(),
        'cores': usable_cores(),
        'load_1min': round(os.getloadavg()[0], 2),
        'system': f'{platform.system()} {platform.release()} {platform.machine()}',
        'python': platform.python_version(),
        'numpy': np.__version__,
        'scipy': scipy.__version__,
        'ros_rops': ros_rops.__version__,
        'git_commit': git_commit(),
    }


def peak_rss_mib() -> float:
    """
    Return the peak resident memory of this process in MiB.

    From VmHWM where there is one: `getrusage` of a started process also counts the peak of the
    process that started it.
    """
    try:
        status = Path('/proc/self/status').read_text(encoding='utf-8')
        return int(status.partition('VmHWM:')[2].split()[0]) / 1024
    except (OSError, ValueError, IndexError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
