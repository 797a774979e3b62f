# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The thread that owns the session: it places views, and does what was asked, in one order."""

from collections.abc import Callable
from contextlib import suppress
import os
import threading
import time
from typing import Any

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.core.node_config import NodeConfig
from ros_rops.core.types import Units
from ros_rops.intake.admission import Admitted
from ros_rops.intake.ledger import Ledger, told
from ros_rops.intake.reports import count_words, frames_document
from ros_rops.live.board import Board
from ros_rops.live.memory import give_back
from ros_rops.live.modeller import Job, Modeller
from ros_rops.live.run import LiveRun
from ros_rops.live.tasks import Begin, Command, Configure, Count, Place, Recall, Task, Tasks
from ros_rops.live.voice import Voice
from ros_rops.live.words import Update
from ros_rops.pipeline.reports import ViewReport
from ros_rops.pipeline.session import Session
from ros_rops.reporting.models import ModelTask
from ros_rops.reporting.run import Refusal, Run
from ros_rops.reporting.run_folder import write_run


class Worker:
    """
    Does the tasks, one after the other; none of them can end it.

    Parameters
    ----------
    tasks : Tasks
    run : LiveRun
    config, node : Config, NodeConfig
    voice : Voice
    board : Board
    journal_state : callable
        Tells of the journal: 'whole', 'none', or why it broke.
    modeller : Modeller
    """

    def __init__(
        self, tasks: Tasks, run: LiveRun, config: Config, node: NodeConfig, voice: Voice,
        board: Board, journal_state: Callable[[], str], modeller: Modeller,
    ) -> None:
        self._tasks, self._run, self._config, self._node = tasks, run, config, node
        self._voice, self._board, self._journal_state = voice, board, journal_state
        self._modeller = modeller
        self._started = time.perf_counter()
        self._epoch = 0
        self._recalled = 0
        self._last: dict[str, ViewReport] = {}
        self._ledger = self._new_ledger()

    def run(self) -> None:
        """Work until the tasks are stopped."""
        with suppress(OSError, AttributeError):  # a system where it cannot be said of a thread
            # The threads of the kernels have it from this one.
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), self._node.node.nice)
        while (task := self._tasks.get()) is not None:
            try:
                self._do(task)
            except Exception as error:  # a mistake of ours must not end the station
                self._board.fail(f'{self._board.doing[0] or type(task).__name__}: {told(error)}')
            self._board.do('')
            if not isinstance(task, Count):  # these come with the frames of a stream
                give_back()
        self._run.release()

    def _new_ledger(self) -> Ledger:
        units: dict[str, Units] = {'m': 'm', 'mm': 'mm'}
        session = Session(
            self._config, threads=self._node.node.threads,
            units=units.get(self._node.input.units))
        return Ledger(session, steady=True)

    def _do(self, task: Task) -> None:
        if isinstance(task, Place):
            self._place(task)
        elif isinstance(task, Recall):
            self._recall(task)
        elif isinstance(task, Count):
            self._ledger.count(task.counts)
        elif isinstance(task, Command):
            {'finish': self._finish, 'save': self._save,
             'remove_last_view': self._remove}[task.name]()
        elif isinstance(task, Configure):
            self._config = task.config
            self._run.configure(task.config)
        else:
            self._begin(task)

    def _place(self, task: Place) -> None:
        admitted, arrival = task.admitted, task.arrival
        if admitted.views:
            self._board.do(f'registering {admitted.report.name}')
        self._run.saved = False
        # What waits is tried again when a view is placed: nobody has to wait for that.
        session = self._ledger.session
        session.joined = self._tell
        report = self._ledger.place(admitted)
        session.joined = _nothing
        self._tell_failures()
        if not admitted.views:
            return
        self._tell(again=False)
        if arrival is not None:
            self._board.latency_s = time.monotonic() - arrival.at_s
            self._voice.handled(report, arrival)

    def _recall(self, task: Recall) -> None:
        entry = task.entry
        if entry is None:
            self._board.resuming = False
            if task.note:
                self._board.fail(task.note)
            self._tell()
            return
        self._recalled += entry.report is not None
        self._board.do(f'resuming {self._recalled} of {self._recalled + len(self._tasks)}')
        if entry.report is None:
            self._ledger.recall(entry)
        else:
            self._ledger.place(Admitted(entry.report, entry.views))
        self._tell_failures()

    def _finish(self) -> None:
        self._board.do('refining')
        failed = self._ledger.finish()
        self._run.saved = False
        self._tell_failures()
        self._board.last_save = failed or (
            f'refined {_counted(len(self._ledger.session.objects), "object")}')
        self._tell()

    def _remove(self) -> None:
        self._board.do('taking the last view back')
        self._run.saved = False
        name = self._ledger.remove_last()
        if not name:
            self._board.fail('~/remove_last_view: there is no view')
            return
        self._tell()

    def _save(self) -> None:
        folder = self._run.folder
        self._board.do(f'saving to {folder}')
        try:
            # Its files are written anew, and none by two.
            self._modeller.withdraw(folder)
            output = self._node.output
            document = write_run(
                folder, self._result(), picture=output.picture, clouds=not output.models)
        except Exception as error:  # a full disk, or a picture that cannot be drawn
            self._board.last_save = f'not saved: {told(error)}'
            self._board.fail(self._board.last_save)
            return
        self._run.saved = True
        objects = _counted(len(self._ledger.session.objects), 'object')
        views = _counted(len(self._ledger.session.views), 'view')
        self._board.last_save = f'saved {objects} of {views} to {folder}'
        self._make_models(document)

    def _make_models(self, document: dict[str, Any]) -> None:
        """Hand over what was saved: views never change, and the poses are copies."""
        wanted = self._node.output
        if not (wanted.models or wanted.report):
            return
        said = self._board.last_save
        self._board.last_save = f'{said}; the models are made now' if wanted.models else said
        views = self._ledger.session.views
        placed = {view['name']: views[view['name']]
                  for shape in document['objects'] for view in shape['views']}
        self._modeller.put(Job(
            self._run.folder,
            ModelTask(document, placed, self._config, self._node.node.threads),
            wanted.models, wanted.report, self._node.node.nice, self._run.hold_longer(),
            said))

    def _result(self) -> Run:
        ledger = self._ledger
        return Run(
            ledger.session, self._config, ledger.order,
            {name: Refusal(name, reason) for name, reason in ledger.refusals.items()},
            self._facts(), frames_document(ledger.frames, ledger.more))

    def _facts(self) -> dict[str, Any]:
        return {
            'inputs': [], 'frames': count_words(self._ledger.frames, self._ledger.more),
            'journal': self._journal_state(), 'resumed_frames': self._recalled,
            'lost_inputs': {}, 'threads': self._node.node.threads,
            'seconds': time.perf_counter() - self._started, 'errors': self._board.errors,
            'lost_messages': self._board.lost}

    def _begin(self, task: Begin) -> None:
        """End the run; with a result that is not that of all views, it can be resumed."""
        self._board.do('beginning another run')
        with suppress(InputError):  # then it counts as unfinished
            self._run.end()
        self._run.release()
        self._run = task.run
        # A save that was asked for before the reset has just pointed to the run before.
        self._run.point()
        self._epoch += 1
        self._recalled = 0
        self._last = {}
        self._started = time.perf_counter()
        self._ledger = self._new_ledger()
        self._board.folder = str(task.run.folder)
        self._tell()

    def _tell_failures(self) -> None:
        for text in self._ledger.failures:
            self._board.fail(text)
        self._ledger.failures.clear()

    def _tell(self, *, again: bool = True) -> None:
        session = self._ledger.session
        reports = session.reports
        changed = tuple(r for r in reports if not _same(self._last.get(r.name), r))
        if not (changed or again):
            return
        self._last = {report.name: report for report in reports}
        update = Update(
            session.objects, dict(session.views), dict(session.prepared), reports, changed,
            dict(self._ledger.numbers), reports[-1].name if reports else '', session.units,
            session.mesh_resolution, self._ledger.refined, self._epoch)
        self._board.show(update)
        self._voice.updated(update)


def _same(before: ViewReport | None, now: ViewReport) -> bool:
    return before is not None and (
        before.status is now.status and before.object_id == now.object_id)


def _nothing() -> None:
    pass


def _counted(count: int, what: str) -> str:
    return f'{count} {what}{"" if count == 1 else "s"}'
