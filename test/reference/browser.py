# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A browser in a process of its own (`browser_process`), as an object."""

from importlib.util import find_spec
import json
import os
from pathlib import Path
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

PROGRAM = Path(__file__).with_name('browser_process.py')
# ROS's wheels start Python anew with libraries of their own, which are not Qt's.
FLAGS = (
    '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--ignore-gpu-blocklist',
    # Compositing on a GPU that is none ends in a trap, now and then.
    '--disable-gpu-compositing')
NOT_QTS = ('LD_LIBRARY_PATH', '_ROS_WHEELS_BOOTSTRAP_COMPLETE')


class Browser:
    """Sends commands, returns answers; skips the test if there is no browser to be had."""

    def __init__(self, log: Path) -> None:
        if find_spec('PySide6') is None or find_spec('PySide6.QtWebEngineCore') is None:
            pytest.skip('no PySide6-Addons here, whose Chromium opens the report')
        env = {name: value for name, value in os.environ.items() if name not in NOT_QTS}
        env |= {'QT_QPA_PLATFORM': 'offscreen', 'QTWEBENGINE_CHROMIUM_FLAGS': ' '.join(FLAGS)}
        self._log = log
        with log.open('w') as stream:
            self._process = subprocess.Popen(
                [sys.executable, str(PROGRAM)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=stream, text=True, env=env)
        if self._read() != 'ready':
            self.close()
            lines = log.read_text().strip().splitlines()
            pytest.skip(f'Chromium does not start here: {lines[-1] if lines else "no word"}')

    def _read(self) -> Any:
        line = self._process.stdout.readline()
        return json.loads(line) if line else None

    def do(self, command: str, **arguments: Any) -> Any:
        """Return the answer to a command of `browser_process.Browser`."""
        self._process.stdin.write(json.dumps([command, arguments]) + '\n')
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        assert line, f'the browser died: {self._log.read_text()[-2000:]}'
        return json.loads(line)

    def visit(
        self, path: Path, width: int = 1280, height: int = 900, before: str = ''
    ) -> None:
        """Open a report and see it come."""
        assert self.do('visit', path=str(path), width=width, height=height, before=before)
        assert self.js('return document.documentElement.dataset.ready') == 'yes'
        self.js('document.documentElement.style.scrollBehavior = "auto"')

    def js(self, code: str) -> Any:
        """Return what a script returns."""
        return self.do('js', code=code)

    def place(self, selector: str) -> tuple[int, int, int, int]:
        """Bring an element into sight; return its x, y, width and height."""
        box = self.js(
            f'const e = document.querySelector({json.dumps(selector)});'
            'e.scrollIntoView({block: "nearest"}); const r = e.getBoundingClientRect();'
            'return [r.x, r.y, r.width, r.height]')
        return tuple(round(value) for value in box)

    def click(self, selector: str) -> None:
        """Press and release the mouse on an element."""
        x, y, width, height = self.place(selector)
        self.do('drag', x=x + width / 2, y=y + height / 2, dx=0, dy=0, steps=1)

    def canvas(self, columns: int = 24, rows: int = 16) -> np.ndarray:
        """Return what the 3D view shows, (rows, columns, 3)."""
        x, y, width, height = self.place('#canvas')
        # What was asked for is drawn with the next frame, and shown with the one after it.
        self.js('window.frames_left = 3; const next = () => { if (--window.frames_left > 0)'
                ' requestAnimationFrame(next); }; requestAnimationFrame(next);')
        for _ in range(200):
            if self.js('return window.frames_left') == 0:
                break
            self.do('wait', ms=15)
        return np.array(self.do(
            'pixels', x=x, y=y, width=width, height=height, columns=columns, rows=rows))

    def close(self) -> None:
        """End the process."""
        self._process.stdin.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
