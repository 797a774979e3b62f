# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
SIGINT and SIGTERM as something to wait for, instead of something that interrupts.

Both are blocked in every thread and taken by the main one when it asks for them: none breaks an
import or a clean-up, and a second one during the clean-up is only seen where it is looked for.
"""

import os
import signal

ENDING = frozenset({signal.SIGINT, signal.SIGTERM})


def hold_signals() -> None:
    """Block SIGINT and SIGTERM; to be called before any thread is started."""
    signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)


def wait_for_signal() -> None:
    """Return when one of them comes, or when it came already."""
    signal.sigwait(ENDING)


def asked_again() -> bool:
    """Tell whether another one came since."""
    return bool(signal.sigpending() & ENDING)


def ask_to_end() -> None:
    """End the process as SIGTERM does; for threads that cannot go on."""
    os.kill(os.getpid(), signal.SIGTERM)
