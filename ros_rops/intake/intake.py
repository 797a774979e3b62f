# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The whole way from frames to the session, in one thread; a replay and files go it."""

from collections.abc import Sequence

from ros_rops.core.config import Config
from ros_rops.core.frame import Frame
from ros_rops.core.types import RangeView
from ros_rops.intake.admission import Admission, Watch
from ros_rops.intake.journal import Journal
from ros_rops.intake.ledger import Ledger
from ros_rops.intake.reports import FrameReport
from ros_rops.intake.sensor_poses import Lookup
from ros_rops.pipeline.session import Session


class Intake:
    """
    Select frames, cut the views out of them, journal these, and let the session place them.

    Every frame gets a word, kept in `frames`. Synchronous and deterministic as the session is. A
    live station has the two halves, `Admission` and `Ledger`, in threads of their own.

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
    steady : bool
        As for `Ledger`.
    """

    def __init__(
        self, session: Session, config: Config, *, journal: Journal | None = None,
        background: Frame | None = None, threads: int = 0, watch: Watch | None = None,
        steady: bool = False,
    ) -> None:
        self.session = session
        self.admission = Admission(
            config, journal=journal, background=background, threads=threads, watch=watch)
        self.ledger = Ledger(session, steady=steady)

    @property
    def journal(self) -> Journal:
        """Where views are kept safe."""
        return self.admission.journal

    @journal.setter
    def journal(self, journal: Journal) -> None:
        self.admission.journal = journal

    @property
    def frames(self) -> list[FrameReport]:
        """Return the word on every frame."""
        return self.ledger.frames

    def begin(self, lookup: Lookup | None = None) -> None:
        """
        Begin a stream of frames: what was seen in the one before says nothing of this one.

        Parameters
        ----------
        lookup : callable, optional
            Returns T_target_source (4, 4) for (target frame, source frame, time in ns), or None.
        """
        self.admission.begin(lookup)

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
        return self.ledger.place(self.admission.admit(frame))

    def take_view(self, view: RangeView, notes: Sequence[str] = ()) -> FrameReport:
        """Take a view as it stands, as files hold them."""
        return self.ledger.place(self.admission.admit_view(view, notes))

    def refuse(self, name: str, reason: str) -> FrameReport:
        """Note a frame or file that cannot be read."""
        return self.ledger.place(self.admission.refuse(name, reason))

    def restore(self, report: FrameReport, views: Sequence[RangeView]) -> FrameReport:
        """Take over from a journal what was taken before; nothing is decided anew."""
        return self.ledger.place(self.admission.recall(report, views))

    def passes(self, frame: Frame) -> bool:
        """
        Let a frame pass that has its word already, so that later ones are judged as before.

        Returns
        -------
        bool
            Whether it was selected.
        """
        return self.admission.passes(frame)

    def finish(self) -> None:
        """Let the session refine its objects, if anything came since; more may be taken later."""
        self.ledger.finish()

    @property
    def order(self) -> tuple[str, ...]:
        """Names of all views, and of the frames that should have given one, as they came."""
        return self.ledger.order

    @property
    def refusals(self) -> dict[str, str]:
        """Why those frames gave none, by name."""
        return self.ledger.refusals
