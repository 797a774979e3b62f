# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The second half of the way: the session places views, and every frame has its word written."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace

from ros_rops.core.errors import RopsError
from ros_rops.core.types import RangeView, Status
from ros_rops.intake.admission import Admitted
from ros_rops.intake.past import Entry
from ros_rops.intake.reports import Counts, FrameReport, Word
from ros_rops.pipeline.reports import ViewReport
from ros_rops.pipeline.session import Session

TAKEN_BACK = 'taken back by ~/remove_last_view'


class Ledger:
    """
    What came in, in order, and the session that it went to.

    Parameters
    ----------
    session : Session
    steady : bool
        A view on which the session fails, for want of
        memory or by a mistake of ours, is refused, and the next one goes on; otherwise the
        failure is raised.

    Attributes
    ----------
    frames : list of FrameReport
    numbers : dict of str to int
        By name, the place of every view in `poses.json`, and of every frame that should have
        given one; it stays when a view is taken back.
    refined : bool
        Whether the session's objects were refined since the last view came.
    more : dict of Word to Counter of str
        Frames of which no report is kept, by reason.
    failures : list of str
        What the session failed on (with `steady`).
    """

    def __init__(self, session: Session, *, steady: bool = False) -> None:
        self.session = session
        self.frames: list[FrameReport] = []
        self.numbers: dict[str, int] = {}
        self.refined = False
        self.failures: list[str] = []
        self.more: dict[Word, Counter[str]] = {
            word: Counter() for word in (Word.SKIPPED, Word.EMPTY, Word.BAD)}
        self._steady = steady
        self._without: dict[str, str] = {}

    def place(self, admitted: Admitted) -> FrameReport:
        """Let the session have the views of a frame, and write the word on it down."""
        report = admitted.report
        if report.word is not Word.SKIPPED:
            self._number(report.views or (report.name,))
        report = replace(report, reports=tuple(self._add(view) for view in admitted.views))
        if report.word in (Word.BAD, Word.EMPTY):
            self._without[report.name] = report.reason
        self.frames.append(report)
        return report

    def count(self, counts: Counts) -> None:
        """Count frames of which no report is kept."""
        for word, reasons in counts.items():
            self.more[word].update(reasons)

    def finish(self) -> str:
        """
        Let the session refine its objects, unless nothing came since it last did.

        Returns
        -------
        str
            Why it failed (with `steady`), '' if it did not.
        """
        try:
            if not self.refined:
                self.session.finish()
        except Exception as error:  # the poses are what they were, or better
            if not self._steady:
                raise
            self.failures.append(f'refining failed: {told(error)}')
            return self.failures[-1]
        self.refined = True
        return ''

    def remove_last(self) -> str:
        """Take the last view back that is there; return its name, '' if there is none."""
        name = next(reversed(tuple(self.session.views)), '')
        if name:
            self.session.remove(name)
            self._without[name] = TAKEN_BACK
            self.refined = False
        return name

    def recall(self, entry: Entry) -> None:
        """Do again what an entry of a journal, of no frame, says was done."""
        self.count(entry.counts)
        if entry.command == 'finish':
            self.finish()
        elif entry.command == 'remove_last_view':
            self.remove_last()

    @property
    def order(self) -> tuple[str, ...]:
        """Names of all views, and of the frames that should have given one, as they came."""
        return tuple(self.numbers)

    @property
    def refusals(self) -> dict[str, str]:
        """Why some of those are no view of the session, by name."""
        return dict(self._without)

    def _number(self, names: Iterable[str]) -> None:
        for name in names:
            self.numbers[name] = len(self.numbers)

    def _add(self, view: RangeView) -> ViewReport:
        self.refined = False
        try:
            return self.session.add(view)
        except Exception as error:  # whatever it is, the views that follow are worth their word
            if not self._steady:
                raise
            reason = f'its registration failed: {told(error)}'
            self.failures.append(f'{view.name}: {reason}')
            if view.name in self.session.views:
                return self.session.give_up(view.name, reason)
            self._without[view.name] = reason
            return ViewReport(view.name, Status.REFUSED, None, reason)


def told(error: BaseException) -> str:
    """Return what an exception says, and its kind where that is no sentence of ours."""
    kind = type(error).__name__
    text = str(error)
    if isinstance(error, RopsError):
        return text
    return f'{text} ({kind})' if text else kind
