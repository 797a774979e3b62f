# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Files that are there whole or not at all, whenever the process is killed."""

from contextlib import suppress
import os
from pathlib import Path


def replace_file(path: Path, text: str) -> None:
    """
    Write a text file; until it is whole, what was there before stays.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    fresh = path.with_name(path.name + '.new')
    try:
        with fresh.open('w', encoding='utf-8') as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        fresh.replace(path)
    except BaseException:  # Ctrl-C too
        with suppress(OSError):
            fresh.unlink(missing_ok=True)
        raise
