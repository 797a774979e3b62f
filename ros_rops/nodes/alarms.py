# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What goes wrong in the station, in the node's log as well: not everybody watches health."""

from typing import Protocol

from ros_rops.live.words import StationState


class Log(Protocol):
    """As of an rclpy logger."""

    def error(self, message: str) -> object:
        """Say an error."""

    def warning(self, message: str) -> object:
        """Say a warning."""


class Alarms:
    """
    Say what went wrong since it was last asked for, each time once.

    Parameters
    ----------
    log : Log
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self._counts = (0, 0, 0)

    def tell(self, state: StationState) -> None:
        """Say what is new; of one station, whose counts only grow."""
        errors, dropped, lost = now = (state.errors, state.dropped, sum(state.lost.values()))
        before, self._counts = self._counts, now
        if errors > before[0]:
            more = errors - before[0] - 1
            self._log.error(f'{state.last_error}{f" (and {more} more)" if more else ""}')
        if dropped > before[1]:
            self._log.warning(f'{dropped - before[1]} frames dropped: the queue was full')
        if lost > before[2]:
            self._log.warning(
                f'{lost - before[2]} messages lost by the middleware before they came here')
