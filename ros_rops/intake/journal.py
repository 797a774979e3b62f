# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
`journal.mcap`: every view as it was accepted, on disk before the session works on it.

An entry is the word on a frame, behind the views that the frame gave. The entry seals them: what
has none behind it was cut off by a crash, and is forgotten. Any tool that reads MCAP reads it.
"""

from collections.abc import Sequence
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any, IO

import ros_rops
from ros_rops.core.errors import InputError
from ros_rops.core.types import RangeView
from ros_rops.intake.reports import Counts, FrameReport
from ros_rops.recordings.mcap_writer import McapStream

JOURNAL_NAME = 'journal.mcap'
VIEW_TOPIC = '/views'
ENTRY_TOPIC = '/intake'
ENTRY_KIND = 'ros_rops/IntakeEntry'


class Journal:
    """
    A journal to write to; use as a context.

    A failure to write (a full disk, for one) raises nothing: it is kept in `broken`, and nothing
    more is written. What was written before stays safe.

    Parameters
    ----------
    path : Path or None
        None for a journal that keeps nothing.
    at : int
        Where to go on, in bytes; what stands behind is cut off. 0 begins anew.
    latest_ns : int
        Log time of the last message before `at`.

    Attributes
    ----------
    broken : str
        Why the journal cannot be written any more; empty while it can.
    """

    def __init__(self, path: Path | None, *, at: int = 0, latest_ns: int = 0) -> None:
        self.broken = ''
        self._name = path.name if path else ''
        self._latest = latest_ns
        self._stream: IO[bytes] | None = None
        self._mcap: McapStream | None = None
        if path is None:
            return
        try:
            self._stream = path.open('r+b' if at else 'wb')
            self._stream.truncate(at)
            self._stream.seek(at)
            self._mcap = McapStream(
                self._stream, name=self._name, keep='flushed', continued=at > 0)
        except (OSError, InputError) as error:
            self._give_up(error)
        # An entry comes first, so that a file gone on with numbers its topics in the same way.
        self._write({'open': ros_rops.__version__}, sync=True)

    def __enter__(self) -> 'Journal':
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the file, unless something broke."""
        if kind is None and self._mcap is not None:
            try:
                self._mcap.finish()
                self._sync()
            except (OSError, InputError) as fault:
                self._give_up(fault)
        self._close()

    def keep(self, report: FrameReport, views: Sequence[RangeView]) -> None:
        """Write the views of a frame and the word on it; on the disk when this returns."""
        self._write({'frame': report.to_json()}, views, sync=bool(views))

    def begin(self, source: int) -> None:
        """Note that the frames that follow are of the input of this number."""
        self._write({'begin': source})

    def end(self, source: int) -> None:
        """Note that the input of this number was read to its end."""
        self._write({'end': source}, sync=True)

    def command(self, name: str) -> None:
        """Note what was asked of the session between the frames before and after."""
        self._write({'command': name}, sync=True)

    def count(self, counts: Counts) -> None:
        """Note how many frames came since the last entry of which no report is kept."""
        self._write({'count': {word.value: dict(why) for word, why in counts.items()}})

    def _write(
        self, entry: dict[str, Any], views: Sequence[RangeView] = (), *, sync: bool = False
    ) -> None:
        if self._mcap is None:
            return
        try:
            for view in views:
                self._mcap.add_view(view, topic=VIEW_TOPIC, log_time_ns=self._time(view))
            data = json.dumps(entry, separators=(',', ':')).encode()
            self._mcap.add(ENTRY_TOPIC, ENTRY_KIND, data, self._latest)
            if sync:
                self._sync()
        except (OSError, InputError) as error:
            self._give_up(error)

    def _time(self, view: RangeView) -> int:
        # Tools sort by log time: it must never go back, or the order of the views were lost.
        self._latest = max(self._latest + 1, view.stamp_ns or 0)
        return self._latest

    def _sync(self) -> None:
        if self._stream is not None:
            self._stream.flush()
            os.fsync(self._stream.fileno())

    def _give_up(self, error: Exception) -> None:
        self.broken = str(error) if isinstance(error, InputError) else (
            f'{self._name}: cannot be written ({_strerror(error)})')
        self._mcap = None
        self._close()

    def _close(self) -> None:
        stream, self._stream = self._stream, None
        try:
            if stream is not None:
                stream.close()
        except OSError:  # what it still held is what could not be written
            pass


def _strerror(error: Exception) -> str:
    return getattr(error, 'strerror', None) or str(error)
