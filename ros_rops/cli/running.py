# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A run under way: inputs through the intake, and what came of them into the run folder."""

from dataclasses import replace
from pathlib import Path
import sys
import time
from typing import Any

from ros_rops.cli.frame_records import FrameRecords
from ros_rops.cli.interrupt import Interrupt
from ros_rops.cli.live import frame_lines, Live
from ros_rops.cli.notes import Notes
from ros_rops.cli.progress import Progress
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.intake.feed import Feed, first_frame
from ros_rops.intake.intake import Intake
from ros_rops.intake.journal import Journal, JOURNAL_NAME
from ros_rops.intake.past import aside_of, Past, set_aside
from ros_rops.intake.reports import count_words, frames_document
from ros_rops.intake.run_file import RunFile, source_of, Stamp, what_changed, write_run_file
from ros_rops.pipeline.session import Session
from ros_rops.recordings.sources import find_views, Recording, ViewSource
from ros_rops.reporting.models import ModelTask
from ros_rops.reporting.poses import poses_document
from ros_rops.reporting.run import Refusal, Run
from ros_rops.reporting.run_folder import write_run
from ros_rops.reporting.table import result_table


class Running:
    """
    One process's share of a run.

    Parameters
    ----------
    out : Path
    run_file : RunFile
    threads : int
    resumed : bool
        Whether another process began it, so that the inputs may have changed since.

    Raises
    ------
    InputError
        If the background has no frame.
    """

    def __init__(
        self, out: Path, run_file: RunFile, threads: int, *, resumed: bool = False
    ) -> None:
        units = run_file.units
        self._out, self._run_file, self._threads = out, run_file, threads
        self._resumed = resumed
        self._started = time.perf_counter()
        self._session = Session(
            run_file.config, threads=threads, units=None if units == 'auto' else units)
        self._records = FrameRecords(out)
        self._intake = Intake(
            self._session, run_file.config, background=_background(run_file), threads=threads,
            watch=self._records.write, steady=bool(run_file.station))
        self._sources = [source_of(item) for item in run_file.sources]
        self._feed = Feed(self._sources, self._intake, units=units)
        self._recalled = 0

    def finish(self, past: Past | None) -> ModelTask:
        """Do what is left to do, write the run folder; return what models are made of."""
        with Progress(sum(map(self._count, self._sources))) as progress:
            live = Live(progress, self._intake)
            with Interrupt() as interrupt:
                if past is not None:
                    self._recall(past, live, progress, interrupt)
                if self._resumed:
                    self._leave_changed()
                if not interrupt.asked:
                    self._read(past, live, interrupt)
            if interrupt.asked:
                progress.tell('interrupted; finishing with the views so far (again to stop at '
                              'once)')
            live.close()
            progress.say('refining all views of each object together')
            self._intake.finish()
        self._say()
        document = self._write()
        return ModelTask(
            document, dict(self._session.views), self._run_file.config, self._threads)

    def _recall(
        self, past: Past, live: Live, progress: Progress, interrupt: Interrupt
    ) -> None:
        for report in self._feed.recall(past):
            live.show(report)
            self._recalled += 1
            if interrupt.asked:
                return
        if past.torn:
            progress.tell(
                f'{JOURNAL_NAME}: the last {past.torn} bytes are left out: '
                f'{past.damage or "the entry was not finished"}')
        if past.damage:
            self._set_aside()

    def _leave_changed(self) -> None:
        """Give the inputs up that are not what they were: no result could be the same."""
        for number in self._feed.unread:
            change = self._change(self._run_file.sources[number])
            if change:
                self._feed.lost[number] = change

    def _change(self, source: Stamp) -> str:
        """Return why an input cannot be read on as it was begun; empty if it can."""
        background = self._run_file.background
        if background is not None and what_changed(background):
            return f'its background {background.path} {what_changed(background)}'
        return what_changed(source)

    def _set_aside(self) -> None:
        path = self._out / JOURNAL_NAME
        try:
            set_aside(path)
        except OSError as error:
            raise InputError(
                f'{aside_of(path)}: cannot be written ({error.strerror or error})') from None

    def _read(self, past: Past | None, live: Live, interrupt: Interrupt) -> None:
        path = self._out / JOURNAL_NAME if self._run_file.journal else None
        at, latest = (past.at, past.latest_ns) if past else (0, 0)
        with Journal(path, at=at, latest_ns=latest) as self._intake.journal:
            for report in self._feed.run():
                live.show(report)
                if interrupt.asked:
                    return

    def _count(self, source: ViewSource) -> int:
        try:
            return source.count()
        except InputError:
            return 1

    def _say(self) -> None:
        notes = Notes()
        for frame in self._intake.frames:
            notes.add(frame.name, frame.notes)
        for line in notes.lines():
            print(line, file=sys.stderr)
        for line in frame_lines(self._counts()):
            print(line, file=sys.stderr)
        for text in self._intake.ledger.failures:
            _warn(text)
        if self._records.broken:
            _warn(f'{self._records.broken}; `rops explain` cannot tell of the frames that follow')
        for number, why in self._feed.lost.items():
            _warn(f'{self._sources[number].path}: {why}; it is not read any further')

    def _write(self) -> dict[str, Any]:
        intake, complete = self._intake, self._feed.complete
        refusals = {
            name: Refusal(name, reason) for name, reason in intake.refusals.items()}
        result = Run(
            self._session, self._run_file.config, intake.order, refusals, self._facts(),
            frames_document(intake.frames, intake.ledger.more), complete)
        try:
            document = write_run(
                self._out, result, picture=self._run_file.picture,
                clouds=not self._run_file.models)
        except InputError as error:
            # Hours of a machine may be in it: at least it is seen.
            print(result_table(poses_document(result)))
            raise InputError(
                f'{error}; `rops resume {self._out}` writes the result once it can be') from None
        state = 'finished' if complete else 'partial'
        try:
            write_run_file(self._out, replace(self._run_file, state=state))
        except InputError as error:
            _warn(f'{error}; the run counts as unfinished')
        return document

    def _counts(self) -> dict[str, Any]:
        return count_words(self._intake.frames, self._intake.ledger.more)

    def _facts(self) -> dict[str, Any]:
        from ros_rops.bench.machine import machine_facts, peak_rss_mib

        run_file, journal = self._run_file, self._intake.journal
        return {
            'inputs': list(run_file.inputs),
            'frames': self._counts(),
            'journal': journal.broken or ('whole' if run_file.journal else 'none'),
            'resumed_frames': self._recalled,
            'lost_inputs': {self._sources[n].path.name: why for n, why in self._feed.lost.items()},
            'threads': self._threads,
            'seconds': time.perf_counter() - self._started,
            'read_seconds': self._feed.read_seconds,
            'peak_rss_mib': peak_rss_mib(),
            'machine': machine_facts(),
        }


def the_recording(path: Path) -> Recording:
    """
    Return the one recording at a place.

    Raises
    ------
    InputError
        If there is none, or more.
    """
    sources = find_views([path])
    if len(sources) != 1 or not isinstance(sources[0], Recording):
        raise InputError(f'{path}: is not one recording')
    return sources[0]


def _background(run_file: RunFile) -> Frame | None:
    stamped = run_file.background
    if stamped is None or what_changed(stamped):
        return None
    return first_frame(the_recording(Path(stamped.path)), run_file.units)


def _warn(text: str) -> None:
    print(f'warning: {text}', file=sys.stderr)
