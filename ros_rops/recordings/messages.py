# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What every kind of recording yields: channels, raw messages, and the message that a raw one holds.

Types come from the recording's own definitions; where it has none (older rosbag2), from those
that rosbags carries of ROS 2 Jazzy and ROS 1 Noetic.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Protocol

from ros_rops.core.errors import InputError
from ros_rops.recordings.unpacking import unpack_message

LARGEST_DEFINITION = 2**20
"""Characters; the definitions of all of common_interfaces together have half of that."""


@dataclass(frozen=True, slots=True)
class Channel:
    """
    A topic of a recording.

    Parameters
    ----------
    topic : str
    kind : str
        As ROS 2 spells it, `sensor_msgs/msg/PointCloud2`.
    encoding : str
        Of the messages: 'cdr' or 'ros1'; anything else is not read.
    schema_encoding : str
        Of `definition`: 'ros2msg', 'ros2idl', 'ros1msg', or '' if there is none.
    definition : str
    count : int or None
        Messages on it; None if the recording does not tell.
    """

    topic: str
    kind: str
    encoding: str
    schema_encoding: str = ''
    definition: str = ''
    count: int | None = None


@dataclass(frozen=True, slots=True)
class RawMessage:
    """A message as it stands in the recording; `fault` says why it could not be unpacked."""

    channel: Channel
    log_time_ns: int
    data: bytes | memoryview
    fault: str = ''


def unpacked(raw: RawMessage) -> RawMessage:
    """Return a message that is compressed by zstd as it was before."""
    try:
        return replace(raw, data=unpack_message(raw.data))
    except InputError as error:
        return replace(raw, data=b'', fault=str(error))


@dataclass(frozen=True, slots=True)
class Cut:
    """The place where a recording breaks off, and how it shows."""

    reason: str


class Storage(Protocol):
    """An open recording."""

    def channels(self) -> list[Channel]:
        """Return the channels, in the order of the recording."""

    def messages(self, topics: frozenset[str]) -> Iterator[RawMessage | Cut]:
        """Yield the messages of `topics` in the order of log time; last a `Cut` if it is cut."""


def spelled(name: str) -> str:
    """Return a type's name as ROS 2 spells it."""
    parts = name.split('/')
    return f'{parts[0]}/msg/{parts[1]}' if len(parts) == 2 else name


class Decoder:
    """From raw messages to messages with the attributes of ROS's."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str, str], Callable[[memoryview], Any]] = {}

    def decode(self, raw: RawMessage) -> Any:
        """
        Return the message, its arrays of numbers as views of the raw data.

        Raises
        ------
        InputError
            If it cannot be decoded.
        """
        if raw.fault:
            raise InputError(raw.fault)
        channel = raw.channel
        key = (channel.kind, channel.encoding, channel.definition)
        try:
            if key not in self._made:
                self._made[key] = _decoder(channel)
            return self._made[key](memoryview(raw.data))
        except InputError:
            raise
        except Exception as error:  # code generated from the file's own words raises what it likes
            told = str(error) or type(error).__name__
            raise InputError(f'the message cannot be decoded ({told})') from None


def _decoder(channel: Channel) -> Callable[[memoryview], Any]:
    from rosbags.typesys import get_typestore, Stores

    readable = {('cdr', 'ros2msg'), ('cdr', 'ros2idl'), ('cdr', ''), ('ros1', 'ros1msg')}
    if (channel.encoding, channel.schema_encoding) not in readable:
        raise InputError(f'encoding {channel.encoding!r} with schema {channel.schema_encoding!r} '
                         'is not read')
    if channel.definition:
        store = get_typestore(Stores.EMPTY)
        store.register(_types(channel))
    else:
        jazzy = channel.encoding == 'cdr'
        store = get_typestore(Stores.ROS2_JAZZY if jazzy else Stores.ROS1_NOETIC)
    read = store.deserialize_cdr if channel.encoding == 'cdr' else store.deserialize_ros1
    return lambda data: read(data, channel.kind)


def _types(channel: Channel) -> Any:
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    if len(channel.definition) > LARGEST_DEFINITION:
        raise InputError(f'the definition of {channel.kind} has {len(channel.definition)} '
                         'characters')
    if channel.schema_encoding == 'ros2idl':
        return get_types_from_idl(channel.definition)
    types = get_types_from_msg(channel.definition, channel.kind)
    # A list of messages without a byte would be as long as its first four bytes say.
    if channel.encoding == 'ros1' and not all(fields for _, fields in types.values()):
        raise InputError(f'the definition of {channel.kind} holds a message without fields')
    return types


def header(message: Any) -> tuple[int, str]:
    """
    Return the time in nanoseconds and the frame of a message's header.

    Raises
    ------
    InputError
        If it has none.
    """
    try:
        stamp = message.header.stamp
        time_ns = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
        return time_ns, str(message.header.frame_id)
    except (AttributeError, TypeError, ValueError):
        raise InputError('the message has no header') from None
