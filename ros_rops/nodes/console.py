# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What is said at the terminal (and on /rosout): words on views, and health where it changes."""

from collections.abc import Sequence

from msg_adapters.diagnostics import Health, Level
from rclpy.node import Node
from ros_rops.live.words import StationState

SELDOM_S = 5.0
"""Between two words on frames that gave no view: there may be as many as the sensor sends."""


class Console:
    """
    Log what a user who has no other window needs to know.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        self._logger = node.get_logger()
        self._levels: dict[str, Level] = {}
        self._folder = self._last_error = self._last_save = ''

    def view(self, health: Health) -> None:
        """Say what became of a view."""
        text = f'{health.name}: {health.message}'
        # rclpy wants one severity at each place.
        if health.level is Level.ERROR:
            self._logger.warning(text)
        else:
            self._logger.info(text)

    def frame(self, health: Health) -> None:
        """Say that a frame gave no view, unless it was not selected; not too often."""
        if health.level is not Level.OK:
            self._logger.warning(
                f'{health.name}: {health.message}', throttle_duration_sec=SELDOM_S)

    def station(self, parts: Sequence[Health], state: StationState) -> None:
        """Say what is wrong once, when it is well again, what was saved, that a run began."""
        for part in parts:
            before = self._levels.get(part.name, Level.OK)
            self._levels[part.name] = part.level
            if part.level is not before:
                self._changed(part)
        if self._folder not in ('', state.folder):
            self._logger.info(f'a new run, in {state.folder}')
        self._folder = state.folder
        if state.last_error != self._last_error:
            self._last_error = state.last_error
            if self._last_error:
                self._logger.error(self._last_error)
        if state.last_save != self._last_save:
            self._last_save = state.last_save
            if self._last_save:
                self._logger.info(self._last_save)

    def _changed(self, part: Health) -> None:
        text = f'{part.name}: {part.message}'
        if part.level is Level.OK:
            self._logger.info(text)
        elif part.name != 'registration':  # of which the error itself is said
            self._logger.warning(text)
