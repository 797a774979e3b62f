# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the live station says: answers to services, news of frames and of the session."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from ros_rops.core.types import RangeView, Units
from ros_rops.intake.reports import FrameReport
from ros_rops.pipeline.prepare import PreparedView
from ros_rops.pipeline.reports import ObjectModel, ViewReport


@dataclass(frozen=True, slots=True)
class Answer:
    """A service's answer: whether it does what was asked, and a sentence."""

    success: bool
    message: str


@dataclass(frozen=True, slots=True)
class Update:
    """
    The session's state after it changed; nothing in it changes any more.

    Parameters
    ----------
    objects : tuple of ObjectModel
        Poses in `units`.
    views : mapping of str to RangeView
        All views of the session by name.
    prepared : mapping of str to PreparedView
        Those that could be meshed.
    reports : tuple of ViewReport
        The current word on every view, in order of arrival.
    changed : tuple of ViewReport
        Those whose status or object is another than in the update before.
    numbers : mapping of str to int
        By name, the number that `view_<n>` and the field view_id have: the view's place in
        `poses.json`.
    newest : str
        Name of the view that came last; '' without views.
    units : {'m', 'mm', 'unknown'}
    resolution : float
        Mesh resolution in `units`; 0 without views.
    refined : bool
        Whether all views of each object were refined together since the last view came.
    epoch : int
        Counts the sessions: another after `~/reset`.
    """

    objects: tuple[ObjectModel, ...] = ()
    views: Mapping[str, RangeView] = field(default_factory=dict)
    prepared: Mapping[str, PreparedView] = field(default_factory=dict)
    reports: tuple[ViewReport, ...] = ()
    changed: tuple[ViewReport, ...] = ()
    numbers: Mapping[str, int] = field(default_factory=dict)
    newest: str = ''
    units: Units = 'unknown'
    resolution: float = 0.0
    refined: bool = False
    epoch: int = 0


@dataclass(frozen=True, slots=True)
class Handled:
    """
    A message that has its word.

    Parameters
    ----------
    report : FrameReport or None
        None for a message that is no frame (facts on `view_facts`).
    stamp_ns : int
        The header's; 0 if it could not be read.
    frame_id : str
    waited_s : float
        From arrival to the moment it was looked at.
    took_s : float
        From arrival to the word on it.
    """

    report: FrameReport | None
    stamp_ns: int = 0
    frame_id: str = ''
    waited_s: float = 0.0
    took_s: float = 0.0


@dataclass(frozen=True, slots=True)
class StationState:
    """
    How the station stands, for `/diagnostics`.

    Parameters
    ----------
    doing : str
        What the worker does now: '' (nothing), 'resuming 3 of 20', 'registering NAME',
        'refining', 'saving to FOLDER'.
    doing_s : float
        For so long already.
    paused : bool
    waiting_frames, waiting_views : int
    received, dropped : int
        Frames that arrived, and those that overflowed, in all.
    words : mapping of str to int
        Frames of the run by word: taken, skipped, empty, bad.
    statuses : mapping of str to int
        Views by status: placed, pending, ambiguous, refused.
    objects : int
    latency_s : float
        From arrival to the word, of the last view; 0 without.
    folder : str
        Of the run.
    journal : str
        'whole', 'none', or why it broke.
    last_error : str
    last_save : str
        What the last `~/save` or `~/finish` came to.
    errors : int
        So often something failed that should not; `last_error` is the last of these.
    lost : mapping of str to int
        By topic, the messages that the middleware lost before they came here.
    resuming : bool
        Whether what the run's journal held is still being gone through.
    modelling : str
        What is done now for the models of a run that was saved; '' (nothing).
    """

    doing: str = ''
    doing_s: float = 0.0
    paused: bool = False
    waiting_frames: int = 0
    waiting_views: int = 0
    received: int = 0
    dropped: int = 0
    words: Mapping[str, int] = field(default_factory=dict)
    statuses: Mapping[str, int] = field(default_factory=dict)
    objects: int = 0
    latency_s: float = 0.0
    folder: str = ''
    journal: str = 'none'
    last_error: str = ''
    last_save: str = ''
    errors: int = 0
    lost: Mapping[str, int] = field(default_factory=dict)
    resuming: bool = False
    modelling: str = ''


class Listener(Protocol):
    """Is told what happens, from the station's own threads; must return soon."""

    def handled(self, handled: Handled) -> None:
        """Take the word on a message."""

    def updated(self, update: Update) -> None:
        """Take the session's new state."""
