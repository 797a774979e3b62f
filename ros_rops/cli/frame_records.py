# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What was cut out of each frame, kept in the run folder for `rops explain`."""

from pathlib import Path

from ros_rops.core.errors import InputError
from ros_rops.reporting.frame_text import FRAMES
from ros_rops.reporting.frames import write_frame
from ros_rops.segmentation.result import Label, Segmentation

UNTOUCHED = frozenset({Label.HOLE, Label.KEPT})


class FrameRecords:
    """
    Write a record of each frame that points were dropped from.

    Parameters
    ----------
    run : Path
        The run folder.

    Attributes
    ----------
    broken : str
        Why no more are written; empty while they are. It stops nothing else.
    """

    def __init__(self, run: Path) -> None:
        self.broken = ''
        self._folder = run / FRAMES

    def write(self, found: Segmentation) -> None:
        """Write the record of a frame, unless it became a view as it stands."""
        dropped = any(count for label, count in found.counts.items() if label not in UNTOUCHED)
        if self.broken or not (dropped or not found.views):
            return
        try:
            # Drawing takes longer than all the rest; `rops explain --picture` does it.
            write_frame(self._folder, found, picture=False)
        except InputError as error:
            self.broken = str(error)


def clear_records(run: Path) -> None:
    """
    Take out the records of an earlier run in the same folder.

    Raises
    ------
    OSError
        If they cannot be removed.
    """
    for suffix in ('json', 'npz', 'png'):
        for path in (run / FRAMES).glob(f'*.{suffix}'):
            path.unlink()
