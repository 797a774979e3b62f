# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How the station stands: written by its threads, read by anybody at any time."""

from collections import Counter
import threading
import time

from ros_rops.core.types import Status
from ros_rops.intake.past import Entry
from ros_rops.intake.reports import Word
from ros_rops.live.words import Update


class Board:
    """
    Counts and last words of a live station.

    Attributes
    ----------
    folder : str
        Of the run.
    resuming : bool
        Whether what a journal holds is still being gone through.
    modelling : str
        What is done for the models of a saved run; '' for nothing.
    admitted : int
        Views that were let in, less those that were asked to be taken back.
    """

    def __init__(self) -> None:
        self.folder = ''
        self.resuming = False
        self.admitted = 0
        self.received = 0
        self.errors = 0
        self.last_error = ''
        self.last_save = ''
        self.modelling = ''
        self.latency_s = 0.0
        self.objects = 0
        self.statuses: dict[str, int] = {status.value: 0 for status in Status}
        self._words: Counter[Word] = Counter()
        self._lost: Counter[str] = Counter()
        self._doing = ('', 0.0)
        self._lock = threading.Lock()

    def fail(self, text: str) -> None:
        """Note an error."""
        with self._lock:
            self.errors += 1
            self.last_error = text

    def count(self, word: Word, frames: int = 1) -> None:
        """Count frames by their word."""
        with self._lock:
            self._words[word] += frames

    def lose(self, topic: str, messages: int) -> None:
        """Count messages that never came."""
        with self._lock:
            self._lost[topic] += messages

    def admit(self, views: int) -> None:
        """Count views that were let in, or (negative) are to be taken back."""
        with self._lock:
            self.admitted = max(0, self.admitted + views)

    def recall(self, entry: Entry) -> None:
        """Count what a journal says of frames."""
        for word, reasons in entry.counts.items():
            self.count(word, sum(reasons.values()))
        if entry.report is not None:
            self.count(entry.report.word)

    def do(self, what: str) -> None:
        """Note what the worker does from now on; '' for nothing."""
        self._doing = (what, time.monotonic())

    @property
    def doing(self) -> tuple[str, float]:
        """Return what the worker does, and for how many seconds."""
        what, since = self._doing
        return what, time.monotonic() - since if what else 0.0

    @property
    def words(self) -> dict[str, int]:
        """Return frames by word."""
        with self._lock:
            return {word.value: self._words[word] for word in Word}

    @property
    def lost(self) -> dict[str, int]:
        """Return by topic how many messages never came."""
        with self._lock:
            return dict(self._lost)

    def show(self, update: Update) -> None:
        """Take over what an update says."""
        counts = Counter(report.status for report in update.reports)
        self.statuses = {status.value: counts[status] for status in Status}
        self.objects = len(update.objects)

    def begin(self) -> None:
        """Count from nothing: the frames that follow are of another run."""
        with self._lock:
            self._words.clear()
            self.admitted = 0
