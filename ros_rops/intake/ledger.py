# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The second half of the way: the session places views, and every frame has its word written."""

from collections.abc import Iterable
from dataclasses import replace

from ros_rops.core.types import RangeView, Status
from ros_rops.intake.admission import Admitted
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.pipeline.reports import ViewReport
from ros_rops.pipeline.session import Session

COMMANDS = ('finish', 'remove_last_view')
TAKEN_BACK = 'taken back by ~/remove_last_view'


class Ledger:
    """
    What came in, in order, and the session that it went to.

    Parameters
    ----------
    session : Session
    steady : bool
        A view on which the session fails, for want of memory or by a mistake of ours, is refused,
        and the next one goes on; otherwise the failure is raised.

    Attributes
    ----------
    frames : list of FrameReport
    numbers : dict of str to int
        By name, the place of every view in `poses.json`, and of every frame that should have
        given one; it stays when a view is taken back.
    refined : bool
        Whether the session's objects were refined since the last view came.
    failures : list of str
        What the session failed on (with `steady`).
    """

    def __init__(self, session: Session, *, steady: bool = False) -> None:
        self.session = session
        self.frames: list[FrameReport] = []
        self.numbers: dict[str, int] = {}
        self.refined = False
        self.failures: list[str] = []
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

    def finish(self) -> None:
        """Let the session refine its objects; more may be taken afterwards."""
        self.session.finish()
        self.refined = True

    def remove_last(self) -> str:
        """Take the last view back that is there; return its name, '' if there is none."""
        name = next(reversed(self.session.views), '')
        if name:
            self.session.remove(name)
            self._without[name] = TAKEN_BACK
            self.refined = False
        return name

    def carry_out(self, command: str) -> None:
        """Do what a journal says was asked for: one of `COMMANDS`."""
        if command == 'finish':
            self.finish()
        elif command == 'remove_last_view':
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
        if not self._steady:
            return self.session.add(view)
        try:
            return self.session.add(view)
        except Exception as error:  # whatever it is, the views that follow are worth their word
            reason = f'its registration failed: {error or ""} ({type(error).__name__})'
            self.failures.append(f'{view.name}: {reason}')
            if view.name in self.session.views:
                return self.session.give_up(view.name, reason)
            self._without[view.name] = reason
            return ViewReport(view.name, Status.REFUSED, None, reason)
