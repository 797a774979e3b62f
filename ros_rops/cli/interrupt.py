# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C during a run: the first asks, the second stops."""

import signal
import threading
from types import FrameType, TracebackType
from typing import Any


class Interrupt:
    """
    Hold the first Ctrl-C back, so that it breaks no view's registration in the middle.

    Within the context the first sets `asked`; a second raises KeyboardInterrupt. Outside the main
    thread, where Python gives no signals, nothing changes.
    """

    def __init__(self) -> None:
        self.asked = False
        self._before: Any = None

    def __enter__(self) -> 'Interrupt':
        """Take the signal over."""
        if threading.current_thread() is threading.main_thread():
            self._before = signal.signal(signal.SIGINT, self._ask)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give the signal back."""
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True
