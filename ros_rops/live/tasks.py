# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the sorter hands to the worker, in order."""

from collections import deque
from dataclasses import dataclass
import threading

from ros_rops.core.config import Config
from ros_rops.intake.admission import Admitted
from ros_rops.intake.past import Entry
from ros_rops.intake.reports import Counts
from ros_rops.live.run import LiveRun


@dataclass(frozen=True, slots=True)
class Arrival:
    """
    A message that arrived.

    Parameters
    ----------
    number : int
        Counts what arrived.
    at_s, looked_at_s : float
        When it arrived and when it was looked at, by the monotonic clock.
    stamp_ns : int
    frame_id : str
        The header's.
    """

    number: int
    at_s: float
    looked_at_s: float
    stamp_ns: int
    frame_id: str


@dataclass(frozen=True, slots=True)
class Place:
    """Let the session have the views of a frame."""

    admitted: Admitted
    arrival: Arrival | None = None


@dataclass(frozen=True, slots=True)
class Recall:
    """Do again what a journal says; `entry` None: that was all of it."""

    entry: Entry | None = None
    note: str = ''


@dataclass(frozen=True, slots=True)
class Count:
    """Count frames of which no report is kept."""

    counts: Counts


@dataclass(frozen=True, slots=True)
class Command:
    """Do what was asked: 'finish', 'save' or 'remove_last_view'."""

    name: str


@dataclass(frozen=True, slots=True)
class Configure:
    """Other parameters hold from here on."""

    config: Config


@dataclass(frozen=True, slots=True)
class Begin:
    """End the run, and begin the next one."""

    run: LiveRun


Task = Place | Recall | Count | Command | Configure | Begin


class Tasks:
    """
    A queue of one writer and one reader; writing waits while too many views do.

    Parameters
    ----------
    most_views : int
    """

    def __init__(self, most_views: int) -> None:
        self._most = most_views
        self._tasks: deque[Task] = deque()
        self._views = 0
        self._stopped = False
        self._hurried = False
        self._changed = threading.Condition(threading.Lock())

    def put(self, task: Task) -> None:
        """Add a task; wait while there is no room for its views."""
        views = _views_of(task)
        with self._changed:
            while (views and self._views >= self._most) and not self._hurried:
                self._changed.wait()
            self._tasks.append(task)
            self._views += views
            self._changed.notify_all()

    def get(self) -> Task | None:
        """Return what came first, when there is something; None after `stop`."""
        with self._changed:
            while not self._tasks and not self._stopped:
                self._changed.wait()
            if self._stopped:
                return None
            task = self._tasks.popleft()
            self._views -= _views_of(task)
            self._changed.notify_all()
            return task

    def hurry(self) -> None:
        """Let the writer never wait again."""
        with self._changed:
            self._hurried = True
            self._changed.notify_all()

    def stop(self) -> None:
        """Let the reader have nothing more."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def rest(self) -> tuple[Task, ...]:
        """Return what was not read."""
        with self._changed:
            return tuple(self._tasks)

    def __len__(self) -> int:
        """Return how many wait."""
        return len(self._tasks)

    @property
    def views(self) -> int:
        """Return how many views wait."""
        return self._views


def _views_of(task: Task) -> int:
    if isinstance(task, Place):
        return len(task.admitted.views)
    if isinstance(task, Recall) and task.entry is not None:
        return len(task.entry.views)
    return 0
