# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the node's parameters say of its input, and the headers of raw messages."""

from pathlib import Path
import struct

from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.node_config import NodeConfig
from ros_rops.intake.feed import first_frame
from ros_rops.intake.run_file import Stamp, stamp
from ros_rops.recordings.live_frames import live_plan, LiveFrames
from ros_rops.recordings.messages import RawMessage
from ros_rops.recordings.sources import find_views, Recording

SENSORS = {'orthographic': '+z'}
"""The node's words for a sensor that have another name among those of `read_frames`."""


def frames_of(node: NodeConfig) -> LiveFrames:
    """Return what makes frames of the node's messages."""
    given = node.input
    return LiveFrames(
        live_plan(given.kind, color=given.color), units=given.units,
        sensor=SENSORS.get(given.sensor, given.sensor), rectified=given.lens == 'rectified')


def background_of(node: NodeConfig) -> tuple[Frame | None, Stamp | None]:
    """
    Return the frame that shows the station without an object, and the stamp of its recording.

    Raises
    ------
    InputError
        If there should be one and it cannot be read.
    """
    if not node.input.background:
        return None, None
    path = Path(node.input.background)
    try:
        sources = find_views([path])
        if len(sources) != 1 or not isinstance(sources[0], Recording):
            raise InputError(f'{path}: is not one recording')
        return first_frame(sources[0], node.input.units), stamp(sources[0])
    except InputError as error:
        raise InputError(f'input.background: {error}') from None


def header_of(raw: RawMessage) -> tuple[int, str]:
    """
    Return the time in ns and the frame in the header that a message in CDR begins with.

    Returns
    -------
    int, str
        0 and '' if they cannot be read.
    """
    data = bytes(raw.data[:512])
    try:
        order = '<' if data[1] & 1 else '>'
        seconds, nanoseconds, length = struct.unpack_from(f'{order}iII', data, 4)
        if length > len(data) - 16:
            return 0, ''
        frame = data[16:16 + length].split(b'\0')[0].decode(errors='replace')
    except (struct.error, IndexError):
        return 0, ''
    return seconds * 1_000_000_000 + nanoseconds, frame
