# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A run, begun or gone on with: inputs through the intake into the run folder."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import shutil
import sys
import time
from typing import Any

from ros_rops import __version__
from ros_rops.cli.frame_records import clear_records, FrameRecords
from ros_rops.cli.interrupt import Interrupt
from ros_rops.cli.live import frame_lines, Live
from ros_rops.cli.notes import Notes
from ros_rops.cli.progress import Progress
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.intake.feed import Feed
from ros_rops.intake.intake import Intake
from ros_rops.intake.journal import Journal, JOURNAL_NAME
from ros_rops.intake.lock import locked
from ros_rops.intake.past import Past
from ros_rops.intake.reports import count_words, frames_document
from ros_rops.intake.run_file import (
    read_run_file, RUN_NAME, RunFile, source_of, stamp, what_changed, write_run_file)
from ros_rops.pipeline.session import Session
from ros_rops.recordings.sources import Recording, ViewSource
from ros_rops.reporting.poses import poses_document
from ros_rops.reporting.run import Refusal, Run
from ros_rops.reporting.run_folder import prepare_folder, write_run
from ros_rops.reporting.table import result_table


def begin(
    inputs: Sequence[str | Path], sources: Sequence[ViewSource], out: Path, config: Config, *,
    threads: int = 0, units: str = 'auto', topics: Sequence[str] = (), picture: bool = True,
    journal: bool = True, overwrite: bool = False,
) -> dict[str, Any]:
    """
    Begin a run in the folder `out`, and return the content of its poses.json.

    Raises
    ------
    InputError
        If the folder cannot be written, another process works on it, or it holds an unfinished
        run that is not to be overwritten, or an input.
    """
    run_file = RunFile(
        tuple(map(str, inputs)), tuple(stamp(_of(source, topics)) for source in sources), units,
        picture, journal, config.to_flat(), __version__)
    with locked(out, make=True):
        if str((out / JOURNAL_NAME).resolve()) in {item.path for item in run_file.sources}:
            raise InputError(f'{out / JOURNAL_NAME}: is an input; it would be written over')
        if not overwrite:
            _spare_unfinished(out)
        prepare_folder(out)
        # Before the new run.json: it must never stand beside the journal of another run.
        _clear(out)
        write_run_file(out, run_file)
        return _Running(out, run_file, threads).finish(None)


def go_on(folder: Path, *, threads: int = 0) -> dict[str, Any] | None:
    """
    Go on with the run in `folder`, and return the content of its poses.json; None if finished.

    Raises
    ------
    InputError
        If it holds no run, another process works on it, or the result cannot be written.
    """
    with locked(folder):
        run_file = read_run_file(folder)
        if run_file.state == 'finished' and (folder / 'poses.json').exists():
            return None
        if run_file.version != __version__:
            _warn(f'the run was begun by ros_rops {run_file.version}, this is {__version__}: the '
                  f'result may differ')
        path = folder / JOURNAL_NAME
        there = run_file.journal and path.exists()
        if not there:
            _warn(f'{path}: is missing; the run begins anew')
        return _Running(folder, run_file, threads).finish(Past(path) if there else None)


def outcome(document: dict[str, Any], out: Path) -> int:
    """Print the table of a run; return the exit code."""
    print(result_table(document), end='')
    print(f'written to {out}')
    if not document.get('complete', True):
        print(f'a part of the input was not read; `rops resume {out}` goes on')
    return 0 if any(view['status'] == 'placed' for view in document['views']) else 1


def _spare_unfinished(out: Path) -> None:
    path = out / JOURNAL_NAME
    if not path.is_file():
        return
    if not (out / RUN_NAME).is_file():
        raise InputError(f'{path}: is there, and of no run; --overwrite writes over it')
    if read_run_file(out).state != 'finished' and any(entry.views for entry in Past(path)):
        raise InputError(
            f'{out}: holds an unfinished run; `rops resume {out}` goes on with it, --overwrite '
            f'gives it up')


def _clear(out: Path) -> None:
    """Take out what an earlier run kept beside its result; nothing of a folder that is none."""
    if not (out / RUN_NAME).exists():
        return
    try:
        (out / JOURNAL_NAME).unlink(missing_ok=True)
        clear_records(out)
    except OSError as error:
        raise InputError(
            f'{error.filename or out}: cannot be removed ({error.strerror or error})') from None


def _of(source: ViewSource, topics: Sequence[str]) -> ViewSource:
    """Return an input with the topics to read of it, if it is a recording."""
    return replace(source, topics=tuple(topics)) if isinstance(source, Recording) else source


def _warn(text: str) -> None:
    print(f'warning: {text}', file=sys.stderr)


class _Running:
    """One process's share of a run."""

    def __init__(self, out: Path, run_file: RunFile, threads: int) -> None:
        units = run_file.units
        self._out, self._run_file, self._threads = out, run_file, threads
        self._started = time.perf_counter()
        self._session = Session(
            run_file.config, threads=threads, units=None if units == 'auto' else units)
        self._records = FrameRecords(out)
        self._intake = Intake(
            self._session, run_file.config, threads=threads, watch=self._records.write)
        self._sources = [source_of(item) for item in run_file.sources]
        self._feed = Feed(self._sources, self._intake, units=units)
        self._recalled = 0

    def finish(self, past: Past | None) -> dict[str, Any]:
        """Do what is left to do, write the run folder, return the content of poses.json."""
        with Progress(sum(map(self._count, self._sources))) as progress:
            live = Live(progress, self._intake)
            with Interrupt() as interrupt:
                if past is not None:
                    self._recall(past, live, progress, interrupt)
                if not interrupt.asked:
                    self._read(past, live, interrupt)
            if interrupt.asked:
                progress.tell('interrupted; finishing with the views so far (again to stop at '
                              'once)')
            live.close()
            progress.say('refining all views of each object together')
            self._intake.finish()
        self._say()
        return self._write()

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
        for number in self._feed.unread:
            change = what_changed(self._run_file.sources[number])
            if change:
                self._feed.lost[number] = change

    def _set_aside(self) -> None:
        """Keep a damaged journal whole: what follows the damage may be of use to somebody."""
        path = self._out / JOURNAL_NAME
        aside = path.with_suffix('.damaged.mcap')
        try:
            shutil.copyfile(path, aside)
        except OSError as error:
            raise InputError(f'{aside}: cannot be written ({error.strerror or error})') from None

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
        for line in frame_lines(count_words(self._intake.frames)):
            print(line, file=sys.stderr)
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
            frames_document(intake.frames), complete)
        try:
            document = write_run(self._out, result, picture=self._run_file.picture)
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

    def _facts(self) -> dict[str, Any]:
        from ros_rops.bench.machine import machine_facts, peak_rss_mib

        run_file, journal = self._run_file, self._intake.journal
        return {
            'inputs': list(run_file.inputs),
            'frames': count_words(self._intake.frames),
            'journal': journal.broken or ('whole' if run_file.journal else 'none'),
            'resumed_frames': self._recalled,
            'lost_inputs': {self._sources[n].path.name: why for n, why in self._feed.lost.items()},
            'threads': self._threads,
            'seconds': time.perf_counter() - self._started,
            'read_seconds': self._feed.read_seconds,
            'peak_rss_mib': peak_rss_mib(),
            'machine': machine_facts(),
        }
