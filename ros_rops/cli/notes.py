# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What was inferred while reading, said once and not once a view."""

from collections.abc import Sequence
from pathlib import PurePosixPath

from ros_rops.intake.reports import without_figures


class Notes:
    """Notes of many views, those that say the same counted together."""

    def __init__(self) -> None:
        self._first: dict[str, tuple[str, str]] = {}
        self._count: dict[str, int] = {}

    def add(self, name: str, notes: Sequence[str]) -> None:
        """Take the notes of one view; a note may begin with the view's name."""
        for note in notes:
            for prefix in (f'{name}: ', f'{PurePosixPath(name).name}: '):
                note = note.removeprefix(prefix)
            # Figures differ from view to view.
            what = without_figures(note)
            self._first.setdefault(what, (name, note))
            self._count[what] = self._count.get(what, 0) + 1

    def lines(self) -> list[str]:
        """Return a line for each thing that was inferred, with the first view as the example."""
        return [
            f'{name}: {note}' if self._count[what] == 1
            else f'{self._count[what]} views: {note} [figures of {name}]' if '#' in what
            else f'{name} and {self._count[what] - 1} more: {note}'
            for what, (name, note) in self._first.items()]
