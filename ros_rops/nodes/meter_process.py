# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A registration node in a process of its own, and what the system says of it (Linux)."""

from collections.abc import Mapping
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

NAMESPACE = '/meter'
PATIENCE_S = 30.0


class NodeProcess:
    """
    Start the registration node; use as a context, which ends it.

    Parameters
    ----------
    folder : path
        Where it writes.
    settings : mapping
        Parameters by name.
    """

    def __init__(self, folder: str, settings: Mapping[str, Any]) -> None:
        given = {'output.folder': folder, **settings}
        words = [sys.executable, '-m', 'ros_rops.nodes.registration_node', '--ros-args',
                 '-r', f'__ns:={NAMESPACE}', '--log-level', 'warn']
        for name, value in given.items():
            words += ['-p', f'{name}:={_text(value)}']
        # The wheels of ROS start Python a second time; a process begun by one must not think that
        # this was done for it.
        environment = {
            key: value for key, value in os.environ.items()
            if key != '_ROS_WHEELS_BOOTSTRAP_COMPLETE'}
        self.started = time.monotonic()
        self._process = subprocess.Popen(words, env=environment, stdout=subprocess.DEVNULL)

    def __enter__(self) -> 'NodeProcess':
        """Begin."""
        return self

    def __exit__(self, *error: object) -> None:
        """End the process as Ctrl-C does, and by force if it does not go."""
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def cpu_s(self) -> float:
        """Return the CPU time spent so far, in seconds."""
        fields = self._read('stat').rpartition(')')[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')

    def rss_mib(self) -> float:
        """Return the memory that the process holds now."""
        return self._status('VmRSS')

    def peak_rss_mib(self) -> float:
        """Return the most memory that it held."""
        return self._status('VmHWM')

    def _status(self, key: str) -> float:
        line = next(line for line in self._read('status').splitlines() if line.startswith(key))
        return int(line.split()[1]) / 1024

    def _read(self, name: str) -> str:
        return Path(f'/proc/{self._process.pid}/{name}').read_text(encoding='ascii')


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
