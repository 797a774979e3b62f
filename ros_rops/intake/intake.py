# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The way from frames to the session; a live node, a replay and files all go it."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from ros_rops.core.config import Config
from ros_rops.core.frame import Frame
from ros_rops.core.types import Floats, RangeView
from ros_rops.intake.journal import Journal
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.pipeline.session import Session
from ros_rops.recordings.frames import frame_view
from ros_rops.segmentation.result import Segmentation
from ros_rops.segmentation.segment import segment
from ros_rops.segmentation.selection import Selector

Lookup = Callable[[str, str, int | None], Floats | None]
Watch = Callable[[Segmentation], None]


class Intake:
    """
    Select frames, cut the views out of them, journal these, and let the session place them.

    Every frame gets a word, kept in `frames`. Synchronous and deterministic as the session is.

    Parameters
    ----------
    session : Session
    config : Config
    journal : Journal, optional
        Where views are kept safe before the session works on them; by default nowhere.
    background : Frame, optional
        The station without an object.
    threads : int
        0 takes all cores; no influence on the result.
    watch : callable, optional
        Is shown every frame that was segmented.
    """

    def __init__(
        self, session: Session, config: Config, *, journal: Journal | None = None,
        background: Frame | None = None, threads: int = 0, watch: Watch | None = None,
    ) -> None:
        self.session = session
        self.journal = journal or Journal(None)
        self.frames: list[FrameReport] = []
        self._config = config
        self._background = background
        self._threads = threads
        self._watch = watch
        self._names: set[str] = set()
        self._selectors: dict[str, Selector] = {}
        self._lookup: Lookup | None = None

    def begin(self, lookup: Lookup | None = None) -> None:
        """
        Begin a stream of frames: what was seen in the one before says nothing of this one.

        Parameters
        ----------
        lookup : callable, optional
            Returns T_target_source (4, 4) for (target frame, source frame, time in ns), or None.
        """
        self._selectors = {}
        self._lookup = lookup

    def take(self, frame: Frame) -> FrameReport:
        """
        Take a frame of the stream.

        Parameters
        ----------
        frame : Frame
            One that holds a finished view (`frame.view`) is taken as it stands.

        Returns
        -------
        FrameReport
            Taken, skipped or empty, and why; the session's word on each of its views.
        """
        if frame.view is not None:
            return self.take_view(frame.view, frame.notes)
        frame = replace(frame, name=self._unique(frame.name))
        decision = self._selector(frame.topic).decide(frame)
        if not decision.taken:
            return self._keep(FrameReport(
                frame.name, Word.SKIPPED, decision.reason, numbers=decision.numbers))
        found = segment(
            frame, self._config.segmentation, background=self._background, lookup=self._lookup,
            threads=self._threads)
        views = found.views
        if frame.sensor is None and not found.segmented:
            # Nothing says that it is a raw frame of a camera: the sensor is told from the points.
            sensor = frame_view(frame).view.sensor
            views = tuple(replace(view, sensor=sensor) for view in views)
        if self._watch is not None:
            self._watch(found)
        notes = (*frame.notes, *found.notes)
        if not found.views:
            return self._keep(FrameReport(
                frame.name, Word.EMPTY, found.why_empty, notes=notes, numbers=decision.numbers))
        return self._keep(FrameReport(
            frame.name, Word.TAKEN, decision.reason, tuple(view.name for view in found.views),
            notes, decision.numbers), views)

    def take_view(self, view: RangeView, notes: Sequence[str] = ()) -> FrameReport:
        """Take a view as it stands, as files hold them."""
        view = replace(view, name=self._unique(view.name))
        return self._keep(
            FrameReport(view.name, Word.TAKEN, '', (view.name,), tuple(notes)), (view,))

    def refuse(self, name: str, reason: str) -> FrameReport:
        """Note a frame or file that cannot be read."""
        return self._keep(FrameReport(self._unique(name), Word.BAD, reason))

    def restore(self, report: FrameReport, views: Sequence[RangeView]) -> FrameReport:
        """Take over from a journal what was taken before; nothing is decided anew."""
        self._names.add(report.name)
        return self._register(report, views)

    def passes(self, frame: Frame) -> bool:
        """
        Let a frame pass that has its word already, so that later ones are judged as before.

        Returns
        -------
        bool
            Whether it was selected.
        """
        return frame.view is not None or self._selector(frame.topic).decide(frame).taken

    def finish(self) -> None:
        """Let the session refine its objects; more may be taken afterwards."""
        self.session.finish()

    @property
    def order(self) -> tuple[str, ...]:
        """Names of all views, and of the frames that should have given one, as they came."""
        return tuple(
            name for frame in self.frames if frame.word is not Word.SKIPPED
            for name in frame.views or (frame.name,))

    @property
    def refusals(self) -> dict[str, str]:
        """Why those frames gave none, by name."""
        return {
            frame.name: frame.reason for frame in self.frames
            if frame.word in (Word.BAD, Word.EMPTY)}

    def _keep(self, report: FrameReport, views: Sequence[RangeView] = ()) -> FrameReport:
        """Journal first, so that nothing that the session does can lose a view."""
        self.journal.keep(report, views)
        return self._register(report, views)

    def _register(self, report: FrameReport, views: Sequence[RangeView]) -> FrameReport:
        self._names.update(report.views)
        report = replace(report, reports=tuple(self.session.add(view) for view in views))
        self.frames.append(report)
        return report

    def _selector(self, topic: str) -> Selector:
        # Of two cameras each has its own scene.
        if topic not in self._selectors:
            self._selectors[topic] = Selector(self._config.selection)
        return self._selectors[topic]

    def _unique(self, given: str) -> str:
        """Return a name that is new: two recordings may hold the same topic and time."""
        name, count = given, 1
        while name in self._names:
            count += 1
            name = f'{given}#{count}'
        self._names.add(name)
        return name
