# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A browser in a process of its own (`browser_process`), as an object."""

from contextlib import suppress
from importlib.util import find_spec
import json
import os
from pathlib import Path
import subprocess
import sys
from typing import Any
import warnings

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


def _skip_without_qt() -> None:
    try:
        found = find_spec('PySide6') and find_spec('PySide6.QtWebEngineCore')
    except ImportError as error:
        pytest.skip(f'PySide6 cannot be imported: {error}')
    if not found:
        pytest.skip('no PySide6-Addons here, whose Chromium opens the report')


class Browser:
    """
    Sends commands, returns answers; skips the test if there is no browser to be had.

    Chromium on a GPU made of software ends in a trap (SIGTRAP) now and then. It is started again,
    once, with a warning, and does again what was done since the last visit.
    """

    def __init__(self, log: Path, program: Path = PROGRAM) -> None:
        _skip_without_qt()
        env = {name: value for name, value in os.environ.items() if name not in NOT_QTS}
        self._env = env | {
            'QT_QPA_PLATFORM': 'offscreen', 'QTWEBENGINE_CHROMIUM_FLAGS': ' '.join(FLAGS)}
        self._log, self._program = log, program
        self._done: list[str] = []
        self.restarts = 0
        if not self._start():
            self.close()
            pytest.skip(f'Chromium does not start here: {self._last_word()}')

    def _start(self) -> bool:
        with self._log.open('a') as stream:
            self._process = subprocess.Popen(
                [sys.executable, str(self._program)], stdin=subprocess.PIPE,
                stdout=subprocess.PIPE, stderr=stream, text=True, env=self._env)
        return self._process.stdout.readline().strip() == '"ready"'

    def _last_word(self) -> str:
        lines = self._log.read_text().strip().splitlines()
        return lines[-1] if lines else 'no word'

    def _answer(self, line: str) -> str:
        """Return the answer to a line; empty if the process is gone."""
        try:
            self._process.stdin.write(line)
            self._process.stdin.flush()
        except BrokenPipeError:
            return ''
        return self._process.stdout.readline()

    def do(self, command: str, **arguments: Any) -> Any:
        """Return the answer to a command of `browser_process.Browser`."""
        line = json.dumps([command, arguments]) + '\n'
        if command == 'visit':
            self._done.clear()
        self._done.append(line)
        return json.loads(self._answer(line) or self._again())

    def _again(self) -> str:
        """Start the browser anew, do everything since the last visit, return the last answer."""
        self.close()
        said = f'Chromium died ({self._process.returncode}): {self._last_word()}'
        assert not self.restarts, f'{said}; it died a second time'
        self.restarts += 1
        warnings.warn(f'{said}; started again', stacklevel=4)
        assert self._start(), f'{said}; it does not start again'
        answer = ''
        for line in self._done:
            answer = self._answer(line)
        assert answer, f'{said}; it died a second time'
        return answer

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
        self.place('#canvas')
        # What was asked for is drawn with the next frame, and shown with the one after it.
        self.js('window.frames_left = 3; const next = () => { if (--window.frames_left > 0)'
                ' requestAnimationFrame(next); }; requestAnimationFrame(next);')
        for _ in range(2000):
            if self.js('return window.frames_left') == 0:
                break
            self.do('wait', ms=15)
        # Read where it is drawn: what Qt shows of it may come later on a busy machine.
        return np.array(self.js(
            'viewer.draw(); const c = document.createElement("canvas");'
            f'[c.width, c.height] = [{columns}, {rows}]; const pen = c.getContext("2d");'
            'pen.imageSmoothingQuality = "high";'
            f'pen.drawImage(viewer.canvas, 0, 0, {columns}, {rows});'
            f'return [...pen.getImageData(0, 0, {columns}, {rows}).data]'
        )).reshape(rows, columns, 4)[..., :3]

    def close(self) -> None:
        """End the process."""
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
