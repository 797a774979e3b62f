# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What is said while a run is under way: of each frame, and how things stand."""

from collections import Counter
from collections.abc import Iterator, Mapping
import time
from typing import Any

from ros_rops.cli.progress import Progress
from ros_rops.core.types import Status
from ros_rops.intake.intake import Intake
from ros_rops.intake.reports import FrameReport, Word


class Live:
    """The word on each frame, and the state of the session, on a progress display."""

    def __init__(self, progress: Progress, intake: Intake) -> None:
        self._progress = progress
        self._intake = intake
        self._started = time.perf_counter()
        self._frames = 0
        self._views = ''
        self._warned = False

    def show(self, report: FrameReport) -> None:
        """Count a frame and show its word; say once that the journal broke, if it did."""
        self._frames += 1
        if report.views:
            self._views = self._state()
        self._progress.step(
            word_on(report), status=f'{self._views or "no view yet"}, {self._rate()}',
            minor=report.word is Word.SKIPPED)
        self._warn()

    def close(self) -> None:
        """Say how things stand in the end."""
        self._warn()
        if self._frames:
            frames = f'{self._frames} frame{"" if self._frames == 1 else "s"} read'
            self._progress.say(f'{frames}, {self._views or "no view"}, {self._rate()}')

    def _warn(self) -> None:
        broken = self._intake.journal.broken
        if broken and not self._warned:
            self._warned = True
            self._progress.tell(
                f'warning: the journal broke off: {broken}; the run goes on in memory, and what '
                f'follows is lost if it is killed')

    def _rate(self) -> str:
        seconds = max(time.perf_counter() - self._started, 1e-9)
        return f'{self._frames / seconds:.2g} frames/s'

    def _state(self) -> str:
        session = self._intake.session
        counts = Counter(report.status for report in session.reports)
        words = ', '.join(f'{counts[status]} {status.value}' for status in Status
                          if counts[status])
        views, objects = counts.total(), len(session.objects)
        return (f'{views} view{"" if views == 1 else "s"} ({words}), '
                f'{objects} object{"" if objects == 1 else "s"}')


def word_on(report: FrameReport) -> str:
    """Return a line about a frame: the session's word on its views, or why there is none."""
    if report.word is Word.BAD:
        return f'{report.name}: refused: {report.reason}'
    if not report.reports:
        return f'{report.name}: {report.word.value}: {report.reason}'
    return '; '.join(
        f'{view.name}: {view.status.value}: {view.reason}' if view.object_id is None
        else f'{view.name}: {view.status.value} in object {view.object_id}'
        for view in report.reports)


def frame_lines(counts: Mapping[str, Any]) -> Iterator[str]:
    """Yield how many frames gave no view, by reason; nothing where all did."""
    for word, reasons in counts['reasons'].items():
        for reason, count in reasons.items():
            yield f'{count} of {counts["read"]} frames {word}: {reason}'
