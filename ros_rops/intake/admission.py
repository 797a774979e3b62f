# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The first half of the way: frames are selected, views are cut out of them and journalled."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ros_rops.core.config import Config
from ros_rops.core.frame import Frame
from ros_rops.core.types import RangeView
from ros_rops.intake.journal import Journal
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.intake.sensor_poses import Lookup, with_sensor_poses
from ros_rops.recordings.frames import frame_view
from ros_rops.segmentation.result import Segmentation
from ros_rops.segmentation.segment import segment
from ros_rops.segmentation.selection import Selector

MOST_BLANKS = 1000
"""Of a live sensor, reports on so many frames without a view are kept; the rest is counted."""
Watch = Callable[[Segmentation], None]


@dataclass(frozen=True, slots=True)
class Admitted:
    """
    The word on a frame, and the views that it gave: journalled, and not yet placed.

    Parameters
    ----------
    report : FrameReport
    views : tuple of RangeView
    counted : bool
        The report is not kept: the frame is to be counted.
    """

    report: FrameReport
    views: tuple[RangeView, ...] = ()
    counted: bool = False


class Admission:
    """
    Decide on frames, one after another; what is taken is safe when the word on it is given.

    Knows no session, so that it can work on the next frame while that places the one before.

    Parameters
    ----------
    config : Config
    journal : Journal, optional
        By default views are kept nowhere.
    background : Frame, optional
        The station without an object.
    threads : int
        0 takes all cores; no influence on the result.
    watch : callable, optional
        Is shown every frame that was segmented.
    endless : bool
        The frames are those of a live sensor, which may send them for weeks: of one that is not
        selected nothing is kept, nor of most that give no view.
    """

    def __init__(
        self, config: Config, *, journal: Journal | None = None, background: Frame | None = None,
        threads: int = 0, watch: Watch | None = None, endless: bool = False,
    ) -> None:
        self.journal = journal or Journal(None)
        self._config = config
        self._background = background
        self._threads = threads
        self._watch = watch
        self._endless = endless
        self._names: set[str] = set()
        self._blanks = 0
        self._selectors: dict[str, Selector] = {}
        self._lookup: Lookup | None = None

    def begin(self, lookup: Lookup | None = None) -> None:
        """Begin a stream of frames; `lookup` as for `Intake.begin`."""
        self._selectors = {}
        self._lookup = lookup

    def reconfigure(self, config: Config) -> None:
        """Select and cut the frames that follow by other parameters."""
        if config.selection != self._config.selection:
            self._selectors = {}
        self._config = config

    def admit(self, frame: Frame, *, asked: bool = False) -> Admitted:
        """
        Decide on a frame of the stream.

        Parameters
        ----------
        frame : Frame
            One that holds a finished view (`frame.view`) is taken as it stands.
        asked : bool
            It is taken whatever the selection says.
        """
        if frame.view is not None:
            views, missing = self._posed((frame.view,))
            return self.admit_view(views[0], (*frame.notes, *missing))
        decision = self._selector(frame.topic).decide(frame, asked=asked)
        if not decision.taken and self._endless:
            return Admitted(FrameReport(
                frame.name, Word.SKIPPED, decision.reason, numbers=decision.numbers),
                counted=True)
        frame = replace(frame, name=self._unique(frame.name))
        if not decision.taken:
            return self._keep(FrameReport(
                frame.name, Word.SKIPPED, decision.reason, numbers=decision.numbers))
        found = self._segmented(frame)
        notes = (*frame.notes, *found.notes)
        if not found.views:
            return self._blank(FrameReport(
                frame.name, Word.EMPTY, found.why_empty, notes=notes, numbers=decision.numbers))
        views, missing = self._posed(found.views)
        return self._keep(FrameReport(
            frame.name, Word.TAKEN, decision.reason, tuple(view.name for view in views),
            (*notes, *missing), decision.numbers), views)

    def admit_view(self, view: RangeView, notes: Sequence[str] = ()) -> Admitted:
        """Take a view as it stands, as files hold them."""
        view = replace(view, name=self._unique(view.name))
        return self._keep(
            FrameReport(view.name, Word.TAKEN, '', (view.name,), tuple(notes)), (view,))

    def refuse(self, name: str, reason: str) -> Admitted:
        """Note a frame or file that cannot be read."""
        return self._blank(FrameReport(self._unique(name), Word.BAD, reason))

    def recall(self, report: FrameReport, views: Sequence[RangeView]) -> Admitted:
        """Take over from a journal what was taken before; nothing is decided anew."""
        self._names.update((report.name, *report.views))
        self._blanks += not report.views
        return Admitted(report, tuple(views))

    def passes(self, frame: Frame) -> bool:
        """Let a frame pass that has its word already; return whether it was selected."""
        return frame.view is not None or self._selector(frame.topic).decide(frame).taken

    def _segmented(self, frame: Frame) -> Segmentation:
        found = segment(
            frame, self._config.segmentation, background=self._background, lookup=self._lookup,
            threads=self._threads)
        if frame.sensor is None and not found.segmented:
            # Nothing says that it is a raw frame of a camera: the sensor is told from the points.
            sensor = frame_view(frame).view.sensor
            found = replace(
                found, views=tuple(replace(view, sensor=sensor) for view in found.views))
        if self._watch is not None:
            self._watch(found)
        return found

    def _posed(
        self, views: Sequence[RangeView]
    ) -> tuple[tuple[RangeView, ...], tuple[str, ...]]:
        return with_sensor_poses(views, self._config.prior.fixed_frame, self._lookup)

    def _blank(self, report: FrameReport) -> Admitted:
        """Journal the word on a frame without a view, as long as they are not too many."""
        if self._endless and self._blanks >= MOST_BLANKS:
            self._names.discard(report.name)
            return Admitted(report, counted=True)
        self._blanks += 1
        return self._keep(report)

    def _keep(self, report: FrameReport, views: Sequence[RangeView] = ()) -> Admitted:
        """Journal first, so that nothing that the session does can lose a view."""
        self.journal.keep(report, views)
        self._names.update(report.views)
        return Admitted(report, tuple(views))

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
