# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""One process at a time works on a run folder."""

from collections.abc import Iterator
from contextlib import contextmanager
import fcntl
import os
from pathlib import Path

from ros_rops.core.errors import InputError


@contextmanager
def locked(folder: Path, *, make: bool = False) -> Iterator[int]:
    """
    Hold a run folder for this process; the system lets go of it however the process ends.

    Parameters
    ----------
    folder : Path
    make : bool
        Make it where there is none.

    Yields
    ------
    int
        The handle that holds it; a duplicate of this one holds it too, until both are closed.

    Raises
    ------
    InputError
        If another process holds it, or there is no such folder, or it cannot be made.
    """
    try:
        if make:
            folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        what = 'written' if make else 'opened'
        raise InputError(f'{folder}: cannot be {what} ({error.strerror or error})') from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f'{folder}: another process is working on this run') from None
        except OSError:
            pass  # a file system without locks (some network mounts): go on unguarded
        yield handle
    finally:
        os.close(handle)
