# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Runs of `rops` on a small stream, in processes of their own or in this one."""

import json
from pathlib import Path
import signal
import subprocess
import sys
import time

from meta.tree import ROOT
from reference.streams import STILL

BARE = ('--no-picture', '--no-model', '--no-report')
COMMAND = [sys.executable, '-m', 'ros_rops.cli.main']


def words(recording: Path, out: Path, *more: str) -> list[str]:
    """Return the command that replays a recording."""
    return ['replay', str(recording), '--out', str(out), *BARE, *STILL, *more]


def start(*given: str) -> subprocess.Popen:
    """Start a command; Ctrl-C reaches it as from a terminal, whatever the tests run under."""
    return subprocess.Popen(
        [*COMMAND, *given], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))


def wait_for(path: Path, process: subprocess.Popen) -> None:
    """Wait until a file is there, or the process has ended."""
    while not path.exists() and process.poll() is None:
        time.sleep(0.002)


def result(out: Path) -> dict[str, bytes]:
    """Return what must be the same bytes."""
    names = ['poses.json', 'frames.json', *(path.name for path in out.glob('object_*.ply'))]
    return {name: (out / name).read_bytes() for name in sorted(names)}


def unfinish(out: Path, state: str = 'running') -> None:
    """Let a run look as if it had been killed."""
    content = json.loads((out / 'run.json').read_text(encoding='utf-8'))
    (out / 'run.json').write_text(json.dumps({**content, 'state': state}), encoding='utf-8')
