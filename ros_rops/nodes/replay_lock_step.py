# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Play a recording in step with the station: the same result every time."""

import time

from rclpy.node import Node
from ros_rops.core.groups_replay import ReplayConfig
from ros_rops.nodes.replay_outlets import Outlets, Pump
from ros_rops.nodes.replay_voice import NoReplyError, Voice
from ros_rops.recordings.playback import Piece, Playback, Shot, TF_TOPIC
from ros_rops.recordings.view_facts import FACTS_TOPIC
from std_msgs.msg import Header

FACTS_WORD = 'view_facts'
"""Frame of the word by which a station acknowledges facts."""
AHEAD_NS = 1_000_000_000
"""Transforms are sent so long before the frames of their time, which lie between two of them."""
AGAIN_S = 1.0
"""Facts are sent again after that: the first may come before the station's word can be heard."""
GONE_S = 5.0
"""A station that does not listen for so long has gone."""


class LockStep:
    """
    Each frame is sent when the station has had its word on the last.

    Parameters
    ----------
    node : Node
    pump : Pump
    playback : Playback
    outlets : Outlets
    config : ReplayConfig
    voice : Voice
    """

    def __init__(
        self, node: Node, pump: Pump, playback: Playback, outlets: Outlets,
        config: ReplayConfig, voice: Voice,
    ) -> None:
        self._pump, self._playback, self._outlets = pump, playback, outlets
        self._config, self._voice = config, voice
        self._words: list[tuple[int, str]] = []
        self._last: dict[str, bytes] = {}
        self._handled = node.create_subscription(Header, 'handled', self._hear, 100)

    def play(self) -> None:
        """
        Play the recording once.

        Raises
        ------
        NoReplyError
            If the station does not answer in time.
        """
        if not self._pump.until(
                lambda: self._handled.get_publisher_count() > 0, self._config.wait_s):
            raise NoReplyError(
                f'nobody publishes {self._handled.topic_name}, by which a station says that it '
                "has handled a frame; mode 'clock' needs no such word")
        transforms = _Transforms(self._playback, self._outlets)
        for shot in self._playback.shots():
            if shot.frame.fault:
                self._voice.bad(shot.frame)
                continue
            transforms.send_until(shot.frame.log_time_ns + AHEAD_NS)
            self._send(shot)
            self._voice.sent(shot.frame)

    def _send(self, shot: Shot) -> None:
        if shot.facts is not None and self._outlets.heard(FACTS_TOPIC):
            self._send_facts(shot.facts)
        for piece in shot.beside:
            # A CameraInfo that was recorded once is sent once.
            if self._last.get(piece.topic) != piece.data:
                self._last[piece.topic] = piece.data
                self._outlets.send(piece)
        self._outlets.wait_for_arrival(piece.topic for piece in shot.beside)
        self._words.clear()
        self._outlets.send(shot.frame)
        # A station that cannot read the header has no stamp to answer with.
        answers = {(shot.stamp_ns, shot.frame_id), (0, '')}
        self._wait(answers, self._config.reply_timeout_s,
                   f'the frame of {shot.stamp_ns / 1e9:.9f} s')

    def _send_facts(self, facts: Piece) -> None:
        deadline = time.monotonic() + self._config.reply_timeout_s
        self._words.clear()
        while True:
            self._outlets.send(facts)
            if self._pump.until(self._acknowledged, AGAIN_S):
                return
            if time.monotonic() > deadline:
                raise NoReplyError(self._silence('what is known of a frame (view_facts)'))

    def _acknowledged(self) -> bool:
        return any(frame == FACTS_WORD for _, frame in self._words)

    def _wait(self, answers: set[tuple[int, str]], timeout_s: float, what: str) -> None:
        deadline, heard = time.monotonic() + timeout_s, time.monotonic()
        while not self._pump.until(lambda: not answers.isdisjoint(self._words), AGAIN_S):
            now = time.monotonic()
            if self._outlets.frames.get_subscription_count():
                heard = now
            if now > deadline or now - heard > GONE_S:
                raise NoReplyError(self._silence(what))

    def _silence(self, what: str) -> str:
        sent = f'after {self._voice.tally.sent} frames'
        if not self._outlets.frames.get_subscription_count():
            return f'{sent} nobody listens on {self._outlets.frames.topic_name} any more'
        return (f'{sent} the station has no word on {what} within reply_timeout_s = '
                f'{self._config.reply_timeout_s:g} s')

    def _hear(self, word: Header) -> None:
        stamp_ns = word.stamp.sec * 1_000_000_000 + word.stamp.nanosec
        self._words.append((stamp_ns, word.frame_id))


class _Transforms:
    """The moving transforms of a recording, sent ahead of its frames."""

    def __init__(self, playback: Playback, outlets: Outlets) -> None:
        self._outlets = outlets
        self._pieces = (
            playback.moving_transforms() if outlets.has(TF_TOPIC) else iter(()))
        self._next = next(self._pieces, None)

    def send_until(self, time_ns: int) -> None:
        """Send those that were recorded until then."""
        while self._next is not None and self._next.log_time_ns <= time_ns:
            if not self._next.fault:
                self._outlets.send(self._next)
            self._next = next(self._pieces, None)
