# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Messages that the middleware lost before anybody here saw them."""

from collections.abc import Callable


class Losses:
    """
    Count what one subscription did not get, each message once.

    A publisher numbers its messages; a number that is left out is a message that was lost, on the
    way or because the queue of the subscription was full (of which DDS says nothing). Messages do
    not tell whose they are, so that gaps count while there is one publisher only; beside several,
    and behind the last message, there is the middleware's own count.

    Parameters
    ----------
    publisher : callable
        Returns what tells the topic's only publisher from others; None if there are several or
        none.
    """

    def __init__(self, publisher: Callable[[], bytes | None]) -> None:
        self._publisher = publisher
        self._last: int | None = None
        self._whose: bytes | None = None
        self._gaps = 0
        self._events = 0
        self._unseen = 0
        self._told = 0

    def take(self, number: int | None) -> int:
        """Note a message by its publisher's number; return how many more were lost."""
        expected = None if self._last is None else self._last + 1
        if number is None or number != expected:
            # Only now, since it takes time: what follows on is from the same one.
            whose = None if number is None else self._publisher()
            if number is not None and expected is not None and (
                    whose is not None and whose == self._whose):
                self._gaps += max(0, number - expected)
            self._whose = whose
        self._last = number
        return self._more()

    def note(self, total: int) -> int:
        """Note the middleware's count of lost messages; return how many more that makes."""
        if self._whose is None:  # no gap will tell of them
            self._unseen += max(0, total - self._events)
        self._events = total
        return self._more()

    def _more(self) -> int:
        """Return what was not told yet: the middleware's count has some of the gaps in it."""
        lost = max(self._gaps + self._unseen, self._events)
        more, self._told = lost - self._told, lost
        return more
