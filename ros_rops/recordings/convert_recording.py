# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Copy a recording of any kind to MCAP, message by message, nothing decoded but ROS 1."""

from collections.abc import Sequence
import os
from pathlib import Path
from typing import Any

from ros_rops.core.errors import InputError
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.messages import Channel, Cut
from ros_rops.recordings.storage import open_storage

HEADER = 'std_msgs/msg/Header'


def to_mcap(
    path: str | os.PathLike[str], out: str | os.PathLike[str], *, topics: Sequence[str] = ()
) -> int:
    """
    Copy messages to an MCAP file in the order of log time; return their number.

    CDR and JSON stay as they are, byte by byte; messages of ROS 1 become those of ROS 2.

    Parameters
    ----------
    path : path
        A recording of any kind that `read_frames` takes.
    out : path
    topics : sequence of str
        None: all.

    Raises
    ------
    InputError
        If the recording cannot be read to its end, lacks a topic or holds an unknown encoding,
        or the file cannot be written.
    """
    with open_storage(Path(path)) as storage, create_mcap(out) as mcap:
        channels = storage.channels()
        known = frozenset(channel.topic for channel in channels)
        missing = [topic for topic in topics if topic not in known]
        if missing:
            raise InputError(f'{path}: there is no topic {missing[0]!r} in the recording')
        coders: dict[Channel, Coder] = {}
        count = 0
        for raw in storage.messages(frozenset(topics) or known):
            if isinstance(raw, Cut):
                raise InputError(f'{path}: truncated or damaged after {count} messages '
                                 f'({raw.reason})')
            if raw.fault:
                raise InputError(f'{path}: {raw.fault}')
            coder = coders.get(raw.channel)
            if coder is None:
                coder = coders[raw.channel] = Coder(raw.channel)
            mcap.add(
                raw.channel.topic, coder.kind, coder.encode(raw.data), raw.log_time_ns,
                latched=raw.channel.topic == '/tf_static', schema=coder.schema)
            count += 1
    return count


class Coder:
    """
    How the messages of a channel are written in ROS 2, and their definition.

    Parameters
    ----------
    channel : Channel

    Raises
    ------
    InputError
        If its encoding is not known.
    """

    def __init__(self, channel: Channel) -> None:
        self.kind = channel.kind
        self._store: Any = None
        schemas = {('cdr', 'ros2msg'), ('cdr', 'ros2idl'), ('json', 'jsonschema')}
        if (channel.encoding, channel.schema_encoding) in schemas:
            self.schema = channel.schema_encoding, channel.definition
            return
        if (channel.encoding, channel.schema_encoding) not in {
                ('cdr', ''), ('ros1', 'ros1msg'), ('ros1', '')}:
            raise InputError(f'{channel.topic}: encoding {channel.encoding!r} with schema '
                             f'{channel.schema_encoding!r} cannot be converted')
        from rosbags.typesys import get_types_from_msg, get_typestore, Stores

        if channel.encoding == 'cdr':
            store = get_typestore(Stores.ROS2_JAZZY)
        elif channel.definition:
            store = self._store = get_typestore(Stores.EMPTY)
            types = get_types_from_msg(channel.definition, channel.kind)
            if HEADER in types:  # ROS 2's has no such number, and rosbags knows to skip it
                constants, fields = types[HEADER]
                types[HEADER] = (constants, [one for one in fields if one[0] != 'seq'])
            store.register(types)
        else:
            store = self._store = get_typestore(Stores.ROS1_NOETIC)
        try:
            text, _ = store.generate_msgdef(channel.kind, ros_version=2)
        except Exception as error:  # rosbags raises what it likes over odd definitions
            raise InputError(f'{channel.topic}: no definition of {channel.kind} ({error})'
                             ) from None
        self.schema = 'ros2msg', text

    def encode(self, data: bytes | memoryview) -> bytes:
        """
        Return the message as it is written.

        Raises
        ------
        InputError
            If a message of ROS 1 contradicts its definition.
        """
        if self._store is None:
            return bytes(data)
        try:
            return bytes(self._store.ros1_to_cdr(bytes(data), self.kind))
        except Exception as error:  # code generated from the file's own words
            raise InputError(f'{self.kind}: a message cannot be converted ({error})') from None
