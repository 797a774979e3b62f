# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Begin a run in a folder, or go on with the one that it holds."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import sys
from typing import Any

from ros_rops import __version__
from ros_rops.cli.frame_records import clear_records
from ros_rops.cli.modelling import catch_up, complete
from ros_rops.cli.running import Running, the_recording
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.intake.journal import JOURNAL_NAME
from ros_rops.intake.lock import locked
from ros_rops.intake.past import Past
from ros_rops.intake.run_file import read_run_file, RUN_NAME, RunFile, stamp, write_run_file
from ros_rops.modelling.libraries import check_libraries
from ros_rops.recordings.sources import Recording, ViewSource
from ros_rops.reporting.run_folder import prepare_folder
from ros_rops.reporting.table import result_table


def begin(
    inputs: Sequence[str | Path], sources: Sequence[ViewSource], out: Path, config: Config, *,
    threads: int = 0, units: str = 'auto', topics: Sequence[str] = (), picture: bool = True,
    journal: bool = True, overwrite: bool = False, background: Path | None = None,
    models: bool = True, report: bool = True,
) -> dict[str, Any]:
    """
    Begin a run in the folder `out`, and return the content of its poses.json.

    Raises
    ------
    ParameterError
        If the surface is to be made by a library that is not installed.
    InputError
        If the background has no frame, the folder cannot be written, another process works on
        it, or it holds an input, or an unfinished run that is not to be overwritten.
    """
    if models:
        check_libraries(config.model)  # before hours of work, not after
    run_file = RunFile(
        tuple(map(str, inputs)), tuple(stamp(_of(source, topics)) for source in sources), units,
        picture, journal, background and stamp(the_recording(background)), config.to_flat(),
        __version__, models=models, report=report)
    running = Running(out, run_file, threads)
    with locked(out, make=True):
        if str((out / JOURNAL_NAME).resolve()) in {item.path for item in run_file.sources}:
            raise InputError(f'{out / JOURNAL_NAME}: is an input; it would be written over')
        if not overwrite:
            _spare_unfinished(out)
        prepare_folder(out)
        # Before the new run.json: it must never stand beside the journal of another run.
        _clear(out)
        write_run_file(out, run_file)
        done = running.finish(None)
        del running  # its memory
        complete(out, run_file, done)
        return dict(done.document)


def go_on(folder: Path, *, threads: int = 0) -> dict[str, Any] | None:
    """
    Go on with the run in `folder`, and return the content of its poses.json; None if all is there.

    Raises
    ------
    InputError
        If it holds no run, another process works on it, or the result cannot be written.
    """
    with locked(folder):
        run_file = read_run_file(folder)
        if run_file.state == 'finished' and (folder / 'poses.json').exists():
            return catch_up(folder, run_file, threads)
        if run_file.version != __version__:
            _warn(f'the run was begun by ros_rops {run_file.version}, this is {__version__}: the '
                  f'result may differ')
        path = folder / JOURNAL_NAME
        there = run_file.journal and path.exists()
        if not there and run_file.station:
            raise InputError(f'{path}: is missing; a run of a node has no other input')
        if not there:
            _warn(f'{path}: is missing; the run begins anew')
        done = Running(folder, run_file, threads, resumed=True).finish(
            Past(path) if there else None)
        complete(folder, run_file, done)
        return dict(done.document)


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
