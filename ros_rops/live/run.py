# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The folders of a station's runs: `run_0001`, `run_0002`, ..., and `latest`."""

from collections.abc import Mapping
from contextlib import ExitStack, suppress
from dataclasses import replace
import os
from pathlib import Path
import re
from typing import Any

import ros_rops
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.core.node_config import NodeConfig
from ros_rops.intake.journal import Journal, JOURNAL_NAME
from ros_rops.intake.lock import locked
from ros_rops.intake.past import Past
from ros_rops.intake.run_file import read_run_file, RunFile, Stamp, write_run_file
from ros_rops.reporting.run_folder import point_latest

NAME = re.compile(r'run_(\d{4,})$')


class LiveRun:
    """
    One run of a station in its folder, which is held for this process.

    Parameters
    ----------
    folder : Path
    run_file : RunFile
    past : Path or None
        The journal to go on with.

    Attributes
    ----------
    saved : bool
        Whether the result in the folder is that of all that came.
    """

    def __init__(self, folder: Path, run_file: RunFile, *, resumed: bool = False) -> None:
        self.folder = folder
        self.run_file = run_file
        self.saved = False
        self.past = Past(folder / JOURNAL_NAME) if resumed else None
        self._held = ExitStack()
        self._handle = -1
        self._journal: Journal | None = None

    def hold(self) -> None:
        """
        Keep other processes out.

        Raises
        ------
        InputError
            If another process works on this run.
        """
        self._handle = self._held.enter_context(locked(self.folder))

    def hold_longer(self) -> int:
        """Return a handle that keeps other processes out until it is closed."""
        return os.dup(self._handle)

    def journal(self) -> Journal:
        """Open the journal, behind what it holds already; once the past has been gone through."""
        path = self.folder / JOURNAL_NAME if self.run_file.journal else None
        at, latest = (self.past.at, self.past.latest_ns) if self.past else (0, 0)
        self._journal = Journal(path, at=at, latest_ns=latest)
        return self._journal

    def close_journal(self) -> None:
        """End the journal; nothing can be added any more."""
        journal, self._journal = self._journal, None
        if journal is not None:
            with journal:
                pass

    def configure(self, config: Config) -> None:
        """Note other parameters."""
        self.note(replace(self.run_file, parameters=config.to_flat()))

    def end(self) -> None:
        """Note that nothing more will come."""
        self.note(replace(self.run_file, state='finished' if self.saved else 'partial'))

    def note(self, run_file: RunFile) -> None:
        """
        Write `run.json`.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        self.run_file = run_file
        write_run_file(self.folder, run_file)

    def point(self) -> None:
        """Let `latest` beside the folder point to it."""
        with suppress(OSError):  # a file system without links
            point_latest(self.folder)

    def release(self) -> None:
        """Let other processes have the folder."""
        self._held.close()


def begin_run(
    parent: Path, config: Config, node: NodeConfig, background: Stamp | None
) -> LiveRun:
    """
    Begin a run in a new folder below `parent`.

    Raises
    ------
    InputError
        If it cannot be made or written to.
    """
    folder = _new_folder(parent)
    run = LiveRun(folder, RunFile(
        (), (), node.input.units, node.output.picture, node.output.journal, background,
        config.to_flat(), ros_rops.__version__, station=_plain(node), models=node.output.models,
        report=node.output.report))
    run.hold()
    try:
        run.note(run.run_file)
    except InputError:
        run.release()
        with suppress(OSError):
            folder.rmdir()
        raise
    run.point()
    return run


def resume_run(parent: Path, config: Config, node: NodeConfig) -> LiveRun | None:
    """
    Go on with the last run below `parent`, by the present parameters.

    Returns
    -------
    LiveRun or None
        None if there is none, or the last one is finished.

    Raises
    ------
    InputError
        If another process works on it, or it cannot be read.
    """
    numbers = _numbers(parent)
    if not numbers:
        return None
    folder = parent / _name(max(numbers))
    if not (folder / JOURNAL_NAME).is_file():
        return None
    run_file = read_run_file(folder)
    if run_file.state != 'running' or not run_file.station:
        return None
    run = LiveRun(folder, run_file, resumed=True)
    run.hold()
    try:
        run.note(replace(
            run_file, units=node.input.units, picture=node.output.picture,
            journal=node.output.journal, parameters=config.to_flat(), version=ros_rops.__version__,
            station=_plain(node), models=node.output.models, report=node.output.report))
    except InputError:
        run.release()
        raise
    run.point()
    return run


def _plain(node: NodeConfig) -> Mapping[str, Any]:
    return dict(node.to_flat())


def _new_folder(parent: Path) -> Path:
    try:
        parent.mkdir(parents=True, exist_ok=True)
        number = max(_numbers(parent), default=0)
        while True:
            number += 1
            folder = parent / _name(number)
            try:
                folder.mkdir()
                return folder
            except FileExistsError:  # another station has the same folder
                continue
    except OSError as error:
        raise InputError(
            f'{error.filename or parent}: cannot be made ({error.strerror or error})') from None


def _numbers(parent: Path) -> list[int]:
    try:
        names = [path.name for path in parent.iterdir()]
    except OSError:
        return []
    return [int(found.group(1)) for name in names if (found := NAME.match(name))]


def _name(number: int) -> str:
    return f'run_{number:04d}'
