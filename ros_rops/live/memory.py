# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Memory that was freed, and that the C library keeps for later."""

import ctypes

_LIBRARY = ctypes.CDLL(None)


def give_back() -> None:
    """
    Let the system have the memory that was freed.

    A registration takes and frees much; between the arrays that stay, glibc keeps the rest, which
    adds up to a quarter of what the views themselves take. Where there is no glibc, nothing is
    done.
    """
    trim = getattr(_LIBRARY, 'malloc_trim', None)
    if trim is not None:
        trim(0)
