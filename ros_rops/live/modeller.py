# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Models and reports of saved runs, one after the other, while the station goes on."""

from collections import deque
from dataclasses import dataclass
import json
import os
from pathlib import Path
import pickle
import shutil
import subprocess
import sys
import threading
import time
from typing import Any, cast, IO

import ros_rops
from ros_rops.intake.ledger import told
from ros_rops.live.board import Board
from ros_rops.reporting.models import ModelTask, SCRATCH

MOST_WAITING = 2
"""So many runs may wait for their models: each keeps its views in memory."""
GENTLER = 10
"""By so much more than registration it gives way."""
PROGRAM = 'ros_rops.live.model_process'
REPORT = 'report.html'


@dataclass(frozen=True, slots=True)
class Job:
    """
    A run that was saved.

    Parameters
    ----------
    folder : Path
    task : ModelTask
        As things stood when it was saved.
    models, report : bool
        What to make.
    nice : int
    hold : int
        A handle that keeps other processes out of the folder; closed when all is done.
    said : str
        What was said when it was saved.
    """

    folder: Path
    task: ModelTask
    models: bool
    report: bool
    nice: int
    hold: int
    said: str


class Modeller:
    """
    Makes models in a process of its own, and tells the board.

    Of several saves of one run the last counts: what is made for an earlier one is given up.

    Parameters
    ----------
    board : Board
    """

    def __init__(self, board: Board) -> None:
        self._board = board
        self._waiting: deque[Job] = deque()
        self._current: Job | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._withdrawn = False
        self._closed = False
        self._changed = threading.Condition()

    def put(self, job: Job) -> None:
        """Have the models of a run made; too many that wait are given up, the oldest first."""
        with self._changed:
            self._waiting.append(job)
            left_out = [self._waiting.popleft() for _ in range(len(self._waiting) - MOST_WAITING)]
            self._changed.notify_all()
        for one in left_out:
            self._give_up(one, 'too many runs wait')

    def withdraw(self, folder: Path) -> None:
        """Give up what is made for a run, whose folder is to be written anew."""
        with self._changed:
            mine = [job for job in self._waiting if job.folder == folder]
            self._waiting = deque(job for job in self._waiting if job.folder != folder)
            if self._current is not None and self._current.folder == folder:
                self._stop()
                self._changed.wait_for(
                    lambda: self._current is None or self._current.folder != folder)
        for job in mine:
            os.close(job.hold)

    def close(self) -> None:
        """Give up everything; `run` returns."""
        with self._changed:
            self._closed = True
            self._stop()
            left, self._waiting = tuple(self._waiting), deque()
            self._changed.notify_all()
        for job in left:
            self._give_up(job, 'the station ends')

    def run(self) -> None:
        """Work until closed."""
        while (job := self._next()) is not None:
            try:
                self._do(job)
            except Exception as error:  # a mistake of ours must not end it
                self._board.fail(f'models of {job.folder}: {told(error)}')
            finally:
                shutil.rmtree(job.folder / SCRATCH, ignore_errors=True)
                os.close(job.hold)
                self._board.modelling = ''
                with self._changed:
                    self._current = self._process = None
                    self._changed.notify_all()

    def _next(self) -> Job | None:
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._closed)
            if self._closed:
                return None
            self._current, self._withdrawn = self._waiting.popleft(), False
            return self._current

    def _do(self, job: Job) -> None:
        began = time.monotonic()
        done, last = self._made(job)
        self._board.modelling = ''  # before the outcome is said
        if done is not None:
            if done:
                self._board.fail(f'models of {job.folder}: {"; ".join(done)}')
            seconds = f'{time.monotonic() - began:.1f} s'
            self._board.last_save = f'{job.said}; {_outcome(job, bool(done), seconds)}'
        elif self._closed:
            self._say_given_up(job, 'the station ends')
        elif not self._withdrawn:
            self._board.fail(f'the models of {job.folder} could not be made: {last}')
            self._say_given_up(job, 'see the error')

    def _made(self, job: Job) -> tuple[list[str] | None, str]:
        """Return what could not be made, None if it broke off; and the last words of others."""
        done, last = None, ''
        process = self._start(job)
        if process is None:
            return None, ''
        order = {'folder': job.folder, 'task': job.task, 'models': job.models,
                 'report': job.report}
        try:
            with process:
                # Kept open: by its end the other side knows that this one has gone.
                pickle.dump(order, cast(IO[bytes], process.stdin), protocol=5)
                cast(IO[bytes], process.stdin).flush()
                done, last = self._listen(cast(IO[bytes], process.stdout))
        except BrokenPipeError:  # it ended before it had heard all
            pass
        return done, last or f'the process ended with {process.returncode}'

    def _start(self, job: Job) -> 'subprocess.Popen[bytes] | None':
        root = str(Path(ros_rops.__file__).resolve().parents[1])
        paths = [root, *filter(None, [os.environ.get('PYTHONPATH')])]
        with self._changed:
            if self._withdrawn:
                return None
            # Not from the directory that the node was started in; and Ctrl-C there is the node's.
            self._process = subprocess.Popen(
                [sys.executable, '-P', '-m', PROGRAM, str(job.folder),
                 str(min(19, job.nice + GENTLER))], stdin=subprocess.PIPE,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
                env={**os.environ, 'PYTHONPATH': os.pathsep.join(paths)})
            return self._process

    def _listen(self, stream: IO[bytes]) -> tuple[list[str] | None, str]:
        last = ''
        for line in stream:
            word = _word(line)
            if 'done' in word:
                return list(map(str, word['done'])), ''
            if 'doing' in word:
                self._board.modelling = str(word['doing'])
            else:
                last = line.decode(errors='replace').strip() or last
        return None, last

    def _stop(self) -> None:
        self._withdrawn = True
        if self._process is not None:
            self._process.kill()

    def _give_up(self, job: Job, why: str) -> None:
        os.close(job.hold)
        self._say_given_up(job, why)

    def _say_given_up(self, job: Job, why: str) -> None:
        self._board.last_save = (
            f'{job.said}; the models are not made ({why}): `rops model {job.folder}` makes them')


def _outcome(job: Job, parts_missing: bool, seconds: str) -> str:
    what = ' and '.join(
        name for name, wanted in (('models', job.models), ('report', job.report)) if wanted)
    if parts_missing:
        return f'{what}: not all is as it should be, after {seconds} (see the error)'
    where = f': {job.folder / REPORT}' if job.report else ''
    return f'{what} written in {seconds}{where}'


def _word(line: bytes) -> dict[str, Any]:
    try:
        word = json.loads(line)
    except ValueError:
        return {}
    return word if isinstance(word, dict) else {}
