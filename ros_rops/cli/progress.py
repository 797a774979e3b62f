# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Progress on standard error: a bar on a terminal, plain lines elsewhere."""

import shutil
import sys
from types import TracebackType

BAR = 24


class Progress:
    """
    Count steps up to `total`; use as a context.

    On a terminal one line is rewritten; elsewhere each step is a line of its own.
    """

    def __init__(self, total: int) -> None:
        self._total = total
        self._done = 0
        self._terminal = sys.stderr.isatty()

    def __enter__(self) -> 'Progress':
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the line of the bar, whatever happened."""
        if self._terminal and self._done:
            print(file=sys.stderr)

    def step(self, text: str, *, status: str = '', minor: bool = False) -> None:
        """
        Count one step.

        Parameters
        ----------
        text : str
            What came of it.
        status : str
            How things stand; shown before it on a terminal.
        minor : bool
            Nothing came of it: shown on a terminal only.
        """
        self._done += 1
        self._total = max(self._total, self._done)
        if self._terminal:
            text = f'{status}; {text}' if status else text
        elif minor:
            return
        self.say(text)

    def say(self, text: str) -> None:
        """Show `text` without counting."""
        self._show(f'{self._done}/{self._total} {text}')

    def tell(self, text: str) -> None:
        """Print `text` as a line that stays."""
        print(f'\r\x1b[2K{text}' if self._terminal else text, file=sys.stderr, flush=True)

    def _show(self, text: str) -> None:
        if not self._terminal:
            print(text, file=sys.stderr, flush=True)
            return
        full = BAR * self._done // max(self._total, 1)
        line = f'[{"#" * full}{"." * (BAR - full)}] {text}'
        width = shutil.get_terminal_size().columns - 1
        # Back to the start of the line, and clear it.
        print(f'\r\x1b[2K{line[:width]}', end='', file=sys.stderr, flush=True)
