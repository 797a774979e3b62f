# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The views of a run, read back from its folder: nothing is registered."""

from collections.abc import Collection
from pathlib import Path

from ros_rops.core.errors import InputError
from ros_rops.core.types import RangeView, Status, Units
from ros_rops.intake.feed import Feed, first_frame
from ros_rops.intake.intake import Intake
from ros_rops.intake.journal import JOURNAL_NAME
from ros_rops.intake.past import Past
from ros_rops.intake.run_file import read_run_file, RunFile, source_of, what_changed
from ros_rops.pipeline.reports import ViewReport
from ros_rops.pipeline.session import Session
from ros_rops.pipeline.units import in_units
from ros_rops.recordings.sources import Recording


def views_of_run(
    folder: Path, names: Collection[str], units: Units, *, threads: int = 0
) -> dict[str, RangeView]:
    """
    Return views of a run from its journal, or else from its inputs.

    Parameters
    ----------
    folder : Path
    names : collection of str
        The views wanted.
    units : {'m', 'mm', 'unknown'}
        Those of the run.
    threads : int
        0 takes all cores; no influence on the result.

    Raises
    ------
    InputError
        If one is in neither, or an input is gone or has changed; the text says which.
    """
    run_file = read_run_file(folder)
    shelf = Shelf(set(names), units)
    path = folder / JOURNAL_NAME
    if run_file.journal and path.is_file():
        for entry in Past(path):
            for view in entry.views:
                shelf.add(view)
    if shelf.missing and run_file.sources:
        _read_inputs(folder, run_file, shelf, threads)
    if shelf.missing:
        where = 'journal.mcap and the inputs lack' if run_file.sources else 'journal.mcap lacks'
        raise InputError(f'{folder}: {where} the view {min(shelf.missing)!r}')
    return shelf.kept


class Shelf(Session):
    """
    Stands where a session would, and registers nothing.

    Parameters
    ----------
    names : set of str
        The views to keep.
    units : {'m', 'mm', 'unknown'}
        To keep them in.
    """

    def __init__(self, names: set[str], units: Units) -> None:
        super().__init__()
        self.missing = set(names)
        self.kept: dict[str, RangeView] = {}
        self._into: Units = units

    def add(self, view: RangeView) -> ViewReport:
        """Keep a view, if it is one of those wanted."""
        if view.name in self.missing:
            self.missing.remove(view.name)
            self.kept[view.name] = in_units(view, self._into)
        return ViewReport(view.name, Status.PENDING, None, '')


def _read_inputs(folder: Path, run_file: RunFile, shelf: Shelf, threads: int) -> None:
    stamps = [*run_file.sources, *((run_file.background,) if run_file.background else ())]
    for stamp in stamps:
        change = what_changed(stamp)
        if change:
            raise InputError(
                f'{stamp.path}: {change} since the run, and {folder} has no whole journal: its '
                f'views cannot be read again')
    background = source_of(run_file.background) if run_file.background else None
    intake = Intake(
        shelf, run_file.config, threads=threads,
        background=first_frame(background, run_file.units)
        if isinstance(background, Recording) else None)
    feed = Feed([source_of(stamp) for stamp in run_file.sources], intake, units=run_file.units)
    for _ in feed.run():
        if not shelf.missing:
            return
