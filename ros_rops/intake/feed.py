# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Recorded inputs through the intake, one frame after the other; also where a run broke off."""

from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
import time

from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.types import Floats
from ros_rops.intake.intake import Intake
from ros_rops.intake.past import Past
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.intake.sensor_poses import Lookup
from ros_rops.recordings.reader import BadView, NotedView
from ros_rops.recordings.sources import Recording, ViewSource
from ros_rops.recordings.transforms import read_transforms, TransformTree

Outcome = Frame | NotedView | BadView


class Feed:
    """
    Inputs on their way through an intake.

    Parameters
    ----------
    sources : sequence of ViewSource
        Numbered as they stand.
    intake : Intake
    units : {'auto', 'm', 'mm'}

    Attributes
    ----------
    lost : dict of int to str
        Inputs that were not read to their end, and why.
    read_seconds : float
        Spent on reading and decoding.
    """

    def __init__(
        self, sources: Sequence[ViewSource], intake: Intake, *, units: str = 'auto'
    ) -> None:
        self.lost: dict[int, str] = {}
        self.read_seconds = 0.0
        self._sources = sources
        self._intake = intake
        self._units = units
        self._frames: dict[int, list[FrameReport]] = {}
        self._ended: set[int] = set()

    def recall(self, past: Past) -> Iterator[FrameReport]:
        """Let the intake have what a journal holds, and yield the word on each frame."""
        source = -1
        for entry in past:
            if entry.kind == 'begin':
                source = entry.source
            elif entry.kind == 'end':
                self._ended.add(entry.source)
            elif entry.report is not None:
                report = self._intake.restore(entry.report, entry.views)
                if source >= 0:
                    self._frames.setdefault(source, []).append(report)
                    if not isinstance(self._sources[source], Recording):
                        self._ended.add(source)
                yield report
            else:
                self._intake.ledger.recall(entry)

    def run(self) -> Iterator[FrameReport]:
        """Take what has no word yet, and yield the word on each frame."""
        for number, source in enumerate(self._sources):
            if number in self._ended or number in self.lost:
                continue
            self._intake.journal.begin(number)
            yield from self._read(number, source)
            if number not in self.lost:
                self._ended.add(number)
                self._intake.journal.end(number)

    @property
    def complete(self) -> bool:
        """Whether all inputs were read to their ends."""
        return not self.unread

    @property
    def unread(self) -> tuple[int, ...]:
        """Numbers of the inputs that were not read to their ends."""
        return tuple(n for n in range(len(self._sources)) if n not in self._ended)

    def _read(self, number: int, source: ViewSource) -> Iterator[FrameReport]:
        known = self._frames.get(number, [])
        self._intake.begin(_lookup(source.path))
        for index, outcome in enumerate(self._outcomes(source)):
            if index >= len(known):
                yield self._take(outcome, source.path)
            elif not self._agrees(outcome, known[index]):
                self.lost[number] = f'differs from the journal at {known[index].name}'
                return

    def _take(self, outcome: Outcome, path: Path) -> FrameReport:
        if isinstance(outcome, BadView):
            # Where the file lies is no part of the result.
            return self._intake.refuse(outcome.name, outcome.reason.removeprefix(f'{path}: '))
        if isinstance(outcome, NotedView):
            return self._intake.take_view(outcome.view, outcome.notes)
        return self._intake.take(outcome)

    def _agrees(self, outcome: Outcome, known: FrameReport) -> bool:
        """Let a frame pass that has its word already; tell whether it is that frame."""
        if isinstance(outcome, NotedView):
            return False  # a file of one view: it is not read again
        return _same(known.name, outcome.name) and (
            known.word is Word.BAD if isinstance(outcome, BadView)
            else self._intake.passes(outcome) == (known.word is not Word.SKIPPED))

    def _outcomes(self, source: ViewSource) -> Iterator[Outcome]:
        outcomes: Iterator[Outcome] = iter(
            source.frames(units=self._units) if isinstance(source, Recording)
            else source.views(units=self._units))
        while True:
            started = time.perf_counter()
            outcome = next(outcomes, None)
            self.read_seconds += time.perf_counter() - started
            if outcome is None:
                return
            yield outcome


def _same(known: str, given: str) -> bool:
    """Tell whether a name is the one given, or that with a number because it was taken."""
    return known == given or known.startswith(f'{given}#')


def _lookup(path: Path) -> Lookup:
    """Return where transforms are looked up; the recording is searched for them when asked."""
    @cache
    def tree() -> TransformTree | None:
        try:
            return read_transforms(path)
        except InputError:
            return None  # reading its frames has said why

    def lookup(target: str, source: str, stamp_ns: int | None) -> Floats | None:
        known = tree()
        return None if known is None else known.lookup(target, source, stamp_ns)

    return lookup


def first_frame(recording: Recording, units: str = 'auto') -> Frame:
    """
    Return the first frame of a recording that can be read, for example of the empty station.

    Raises
    ------
    InputError
        If there is none.
    """
    reason = 'it is empty'
    for outcome in recording.frames(units=units):
        if isinstance(outcome, Frame):
            return outcome
        reason = outcome.reason.removeprefix(f'{recording.path}: ')
    raise InputError(f'{recording.path}: holds no frame ({reason})')
