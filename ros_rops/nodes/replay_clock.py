# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Play a recording by its own clock, which is told on /clock."""

from collections.abc import Iterator
import heapq
import time

from ros_rops.core.groups_replay import ReplayConfig
from ros_rops.nodes.replay_outlets import Outlets, Pump
from ros_rops.nodes.replay_voice import Voice
from ros_rops.recordings.playback import Piece, Playback, TF_TOPIC
from ros_rops.recordings.view_facts import FACTS_TOPIC

LATE_S = 0.02
TICK_S = 0.025


class ByClock:
    """
    Every message is sent at its recorded time, that time shortened or stretched.

    What cannot be sent in time is sent as soon as it can, and counted.

    Parameters
    ----------
    pump : Pump
    playback : Playback
    outlets : Outlets
    config : ReplayConfig
    voice : Voice
    """

    def __init__(
        self, pump: Pump, playback: Playback, outlets: Outlets, config: ReplayConfig,
        voice: Voice,
    ) -> None:
        self._pump, self._playback, self._outlets = pump, playback, outlets
        self._rate, self._voice = config.rate, voice
        self._began = 0.0

    def play(self) -> None:
        """Play the recording once."""
        self._began = time.monotonic()
        self._outlets.tell_time(self._playback.start_ns)
        frames = self._outlets.frames_topic
        for piece in self._merged():
            if piece.fault:
                self._voice.bad(piece)
                continue
            if piece.topic != FACTS_TOPIC:  # those go before, so that they are there in time
                self._wait_until(piece.log_time_ns)
            if piece.topic == frames:
                self._note(piece)
            self._outlets.send(piece)

    def _merged(self) -> Iterator[Piece]:
        if not self._outlets.has(TF_TOPIC):
            return self._playback.pieces()
        # The transforms first where the time is the same.
        return heapq.merge(
            self._playback.moving_transforms(), self._playback.pieces(),
            key=lambda piece: piece.log_time_ns)

    def _due(self, time_ns: int) -> float:
        return self._began + (time_ns - self._playback.start_ns) / 1e9 / self._rate

    def _wait_until(self, time_ns: int) -> None:
        due = self._due(time_ns)
        while (left := due - time.monotonic()) > 0:
            self._pump.sleep(min(left, TICK_S))
            passed_ns = round((time.monotonic() - self._began) * self._rate * 1e9)
            self._outlets.tell_time(min(self._playback.start_ns + passed_ns, time_ns))

    def _note(self, frame: Piece) -> None:
        late = time.monotonic() - self._due(frame.log_time_ns)
        if late > LATE_S:
            self._voice.late(late)
        self._voice.sent(frame)
