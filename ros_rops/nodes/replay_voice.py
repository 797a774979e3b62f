# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the replay says: how far it is, and what went wrong."""

from dataclasses import dataclass
import time

from rclpy.node import Node
from ros_rops.core.errors import RopsError
from ros_rops.recordings.playback import Piece, Playback

SAY_S = 5.0


class NoReplyError(RopsError):
    """The station does not listen, or does not answer."""


@dataclass(slots=True)
class Tally:
    """What was sent: frames, those that could not be, those that came late and by how much."""

    sent: int = 0
    bad: int = 0
    late: int = 0
    worst_s: float = 0.0


class Voice:
    """
    Says how far it is, not too often.

    Parameters
    ----------
    node : Node
    playback : Playback
    count : int or None
        Frames that will be sent, as far as that is known.
    """

    def __init__(self, node: Node, playback: Playback, count: int | None) -> None:
        self.tally = Tally()
        self._logger = node.get_logger()
        self._count, self._start_ns = count, playback.start_ns
        self._said = time.monotonic()

    def sent(self, frame: Piece) -> None:
        """Count a frame."""
        self.tally.sent += 1
        if time.monotonic() - self._said > SAY_S:
            self._said = time.monotonic()
            of = f' of {self._count}' if self._count else ''
            seconds = (frame.log_time_ns - self._start_ns) / 1e9
            self._logger.info(f'{self.tally.sent}{of} frames sent, {seconds:.1f} s recorded')

    def bad(self, piece: Piece) -> None:
        """Say what cannot be sent."""
        self.tally.bad += 1
        self._logger.warning(
            f'{piece.topic}@{piece.log_time_ns}: not sent: {piece.fault}' if piece.topic
            else piece.fault)

    def late(self, seconds: float) -> None:
        """Note a frame that is sent behind its time."""
        self.tally.late += 1
        self.tally.worst_s = max(self.tally.worst_s, seconds)
