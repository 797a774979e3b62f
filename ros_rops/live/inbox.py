# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Messages and commands that wait to be looked at, in one order; what is too much overflows."""

from collections import deque
from dataclasses import dataclass, replace
from enum import Enum
import threading
import time

from ros_rops.recordings.messages import RawMessage

HEAD = 512
"""Of a message that is not kept, so many bytes: its header is in them."""
MOST_ITEMS = 4096
"""So many things wait at most, those without data included."""
COMPANIONS = 4
"""So many messages that belong to frames wait for each frame that may."""


class Kind(Enum):
    """What waits."""

    FRAME = 'frame'
    COMPANION = 'companion'
    COMMAND = 'command'
    DROPPED = 'dropped'
    FULL = 'full'
    PAUSED = 'paused'


@dataclass(slots=True, eq=False)
class Item:
    """
    Something that waits.

    Parameters
    ----------
    kind : Kind
        FRAME, or COMPANION (belongs to a frame), or COMMAND; of frames that are not kept only the
        head remains: DROPPED (newer ones came), FULL (there was no room), PAUSED.
    number : int
        Counts what arrived.
    at_s : float
        When, by the monotonic clock.
    raw : RawMessage or None
    order : object
        Of a command.
    """

    kind: Kind
    number: int
    at_s: float
    raw: RawMessage | None = None
    order: object = None

    @property
    def size(self) -> int:
        """Bytes of data."""
        return len(self.raw.data) if self.raw else 0


class Inbox:
    """
    A queue of any number of writers and one reader. Writing never waits for the reader.

    Parameters
    ----------
    most_frames : int
    most_bytes : int
        One frame is taken whatever its size.
    refuse : bool
        Where there is no room for a frame, refuse it; otherwise the oldest one is dropped.

    Attributes
    ----------
    overflowed : int
        Frames refused or dropped so far.
    """

    def __init__(self, most_frames: int, most_bytes: int, *, refuse: bool) -> None:
        self.refuse = refuse
        self.overflowed = 0
        self._most_frames, self._most_bytes = most_frames, most_bytes
        self._items: deque[Item] = deque()
        self._frames: deque[Item] = deque()
        self._companions: deque[Item] = deque()
        self._bytes = 0
        self._number = 0
        self._closed = False
        self._ready = threading.Condition(threading.Lock())

    def put_frame(self, raw: RawMessage, *, paused: bool = False) -> None:
        """Add a frame; `paused`: only that it came."""
        with self._ready:
            if paused:
                self._add_head(Kind.PAUSED, raw)
            elif self.refuse and not self._has_room(len(raw.data)):
                self.overflowed += 1
                self._add_head(Kind.FULL, raw)
            else:
                while not self._has_room(len(raw.data)):
                    self.overflowed += 1
                    self._drop()
                self._frames.append(self._add(Kind.FRAME, raw))

    def put_companion(self, raw: RawMessage) -> None:
        """Add a message that belongs to a frame; the oldest of them go where they are too many."""
        with self._ready:
            while self._companions and (
                    len(self._companions) >= COMPANIONS * self._most_frames
                    or self._bytes + len(raw.data) > self._most_bytes):
                self._forget(self._companions.popleft())
            self._companions.append(self._add(Kind.COMPANION, raw))

    def put_command(self, order: object) -> int:
        """Add a command; return its number."""
        with self._ready:
            return self._add(Kind.COMMAND, order=order).number

    def get(self, patience_s: float | None = None) -> Item | None:
        """Return what came first; None when nothing does in that time, or after the end."""
        with self._ready:
            if not self._items and not self._closed:
                self._ready.wait(patience_s)
            if not self._items:
                return None
            item = self._items.popleft()
            for queue in (self._frames, self._companions):
                if queue and queue[0] is item:
                    queue.popleft()
                    self._bytes -= item.size
            return item

    def close(self) -> None:
        """Let the reader not wait any more; what is there can still be read."""
        with self._ready:
            self._closed = True
            self._ready.notify()

    @property
    def closed(self) -> bool:
        """Whether the end was told, and all is read."""
        return self._closed and not self._items

    @property
    def frames(self) -> int:
        """Return how many frames wait."""
        return len(self._frames)

    @property
    def items(self) -> int:
        """Return how many things wait."""
        return len(self._items)

    def _has_room(self, size: int) -> bool:
        return not self._frames or (
            len(self._frames) < self._most_frames and self._bytes + size <= self._most_bytes)

    def _drop(self) -> None:
        """Keep of the oldest frame that it came, unless nobody looks for long."""
        item = self._frames.popleft()
        if len(self._items) >= MOST_ITEMS or item.raw is None:
            self._forget(item)
            return
        self._bytes -= item.size
        item.kind, item.raw = Kind.DROPPED, _head(item.raw)

    def _forget(self, item: Item) -> None:
        self._bytes -= item.size
        self._items.remove(item)

    def _add_head(self, kind: Kind, raw: RawMessage) -> None:
        if len(self._items) < MOST_ITEMS:
            item = self._add(kind)
            item.raw = _head(raw)

    def _add(
        self, kind: Kind, raw: RawMessage | None = None, order: object = None
    ) -> Item:
        self._number += 1
        item = Item(kind, self._number, time.monotonic(), raw, order)
        self._items.append(item)
        self._bytes += item.size
        self._ready.notify()
        return item


def _head(raw: RawMessage) -> RawMessage:
    return replace(raw, data=bytes(raw.data[:HEAD]))
