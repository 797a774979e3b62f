# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The listener as the station's threads speak to it: what it fails on, they survive."""

import time

from ros_rops.intake.ledger import told
from ros_rops.intake.reports import FrameReport
from ros_rops.live.board import Board
from ros_rops.live.tasks import Arrival
from ros_rops.live.words import Handled, Listener, Update


class Voice:
    """
    Tell a listener, and note on the board what it fails on.

    Parameters
    ----------
    listener : Listener
    board : Board
    """

    def __init__(self, listener: Listener, board: Board) -> None:
        self._listener = listener
        self._board = board

    def handled(self, report: FrameReport | None, arrival: Arrival) -> None:
        """Tell the word on a message."""
        try:
            self._listener.handled(Handled(
                report, arrival.stamp_ns, arrival.frame_id,
                arrival.looked_at_s - arrival.at_s, time.monotonic() - arrival.at_s))
        except Exception as error:  # the listener's, whatever it is
            self._board.fail(f'a word could not be published: {told(error)}')

    def updated(self, update: Update) -> None:
        """Tell the session's new state."""
        try:
            self._listener.updated(update)
        except Exception as error:  # the listener's, whatever it is
            self._board.fail(f'the new state could not be published: {told(error)}')
