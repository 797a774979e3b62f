# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Messages of a ROS 1 .bag file: by rosbags if it is sound, in sequence if it breaks off.

rosbags refuses a bag without its index, which a recorder writes last. The format (version 2.0) is
a sequence of records: lengths and `name=value` headers, then data. Chunks hold connections and
messages, compressed together.
"""

from collections.abc import Iterator
from contextlib import suppress
import os
from pathlib import Path
import struct
from typing import Any, IO

from ros_rops.core.errors import InputError
from ros_rops.recordings.messages import Channel, Cut, RawMessage, spelled
from ros_rops.recordings.unpacking import unpack_chunk

MAGIC = b'#ROSBAG V2.0\n'
MESSAGE, CHUNK, CONNECTION = 2, 5, 7
Record = tuple[dict[bytes, bytes], memoryview]


class _TornError(Exception):
    """The bytes end, or make no sense, in the middle of a record."""


class Ros1Bag:
    """
    An open .bag file.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If it is no bag of version 2.0.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with path.open('rb') as stream:
            head = stream.read(len(MAGIC))
        if head != MAGIC:
            raise InputError(
                f'{path}: is {"not a ROS 1 bag of version 2.0" if head else "empty"}')
        self._reader = self._indexed()
        self._channels: list[Channel] | None = None

    def close(self) -> None:
        """Close the file."""
        if self._reader is not None:
            self._reader.close()

    def channels(self) -> list[Channel]:
        """Return the channels; a bag without an index is read through for them, once."""
        if self._channels is None:
            if self._reader is not None:
                self._channels = [_of_rosbags(c) for c in self._reader.connections]
            else:
                self._channels = self._counted()
        return self._channels

    def messages(self, topics: frozenset[str]) -> Iterator[RawMessage | Cut]:
        """Yield the messages of `topics` in the order of log time; last a `Cut` if it is cut."""
        if self._reader is None:
            yield from self._in_sequence(topics)
            return
        wanted = [c for c in self._reader.connections if c.topic in topics]
        known = {c.id: _of_rosbags(c) for c in wanted}
        messages = self._reader.messages(wanted) if wanted else iter(())
        while True:
            try:
                connection, time, data = next(messages)
            except StopIteration:
                return
            except Exception as error:  # a damaged chunk fails in its decompressor's own way
                yield Cut(f'{type(error).__name__} {error}'.strip())
                return
            yield RawMessage(known[connection.id], time, data)

    def _indexed(self) -> Any:
        from rosbags.rosbag1 import Reader

        reader = Reader(self._path)
        try:
            reader.open()
        except Exception:  # whatever the bytes at the end provoke, they are no index
            return None
        return reader

    def _counted(self) -> list[Channel]:
        counts: dict[Channel, int] = {}
        for raw in self._in_sequence(None):
            if isinstance(raw, RawMessage):
                counts[raw.channel] = counts.get(raw.channel, 0) + 1
        return [
            Channel(c.topic, c.kind, c.encoding, c.schema_encoding, c.definition, count)
            for c, count in counts.items()]

    def _in_sequence(self, topics: frozenset[str] | None) -> Iterator[RawMessage | Cut]:
        """Yield the messages as they stand in the file; a bag without an index ends in a `Cut`."""
        known: dict[int, Channel] = {}
        indexed = False
        try:
            with self._path.open('rb') as stream:
                size = os.fstat(stream.fileno()).st_size
                stream.seek(len(MAGIC))
                while stream.tell() < size:
                    header, data, lacking = _read(stream, size)
                    if lacking:
                        yield from _before_cut(header, data, known, topics)
                        raise _TornError(f'its last record lacks {lacking} bytes')
                    indexed = indexed or _kind(header) == CONNECTION
                    yield from _taken(header, data, known, topics)
        except _TornError as error:
            yield Cut(str(error))
            return
        if not indexed:
            yield Cut('it ends before its index')


def _before_cut(
    header: dict[bytes, bytes], data: memoryview, known: dict[int, Channel],
    topics: frozenset[str] | None,
) -> Iterator[RawMessage]:
    """Yield the whole messages of a chunk in which the file breaks off."""
    if _kind(header) == CHUNK:
        with suppress(_TornError):
            yield from _taken(header, data, known, topics, whole=False)


def _taken(
    header: dict[bytes, bytes], data: memoryview, known: dict[int, Channel],
    topics: frozenset[str] | None, *, whole: bool = True,
) -> Iterator[RawMessage]:
    """Yield the messages of one record of the file, connections noted in `known`."""
    if _kind(header) == CHUNK:
        try:
            content = unpack_chunk(
                header.get(b'compression', b'').decode('latin-1'), data, _number(header, b'size'),
                whole=whole)
        except InputError as error:
            raise _TornError(str(error)) from None
        yield from _of_chunk(memoryview(content), known, topics)
    elif _kind(header) == CONNECTION:
        _note(header, data, known)


def _of_chunk(
    content: memoryview, known: dict[int, Channel], topics: frozenset[str] | None
) -> Iterator[RawMessage]:
    for header, data in _records(content):
        if _kind(header) == CONNECTION:
            _note(header, data, known)
        elif _kind(header) == MESSAGE:
            channel = known.get(_number(header, b'conn'))
            if channel is not None and (topics is None or channel.topic in topics):
                seconds, nanoseconds = struct.unpack('<II', _field(header, b'time', 8))
                yield RawMessage(channel, seconds * 1_000_000_000 + nanoseconds, data)


def _note(header: dict[bytes, bytes], data: memoryview, known: dict[int, Channel]) -> None:
    about = _fields(data)
    number = _number(header, b'conn')
    kind, text = (about.get(key, b'').decode('utf-8', 'replace')
                  for key in (b'type', b'message_definition'))
    topic = header.get(b'topic', b'').decode('utf-8', 'replace')
    known.setdefault(number, Channel(_normal(topic), spelled(kind), 'ros1', 'ros1msg', text))


def _normal(topic: str) -> str:
    """Return a topic as rosbags spells it: no doubled slash."""
    return '/' * topic.startswith('/') + '/'.join(part for part in topic.split('/') if part)


def _read(stream: IO[bytes], size: int) -> tuple[dict[bytes, bytes], memoryview, int]:
    """Return a record of a file that has `size` bytes, and how many its data lacks."""
    def part() -> tuple[bytes, int]:
        length, = struct.unpack('<I', _exactly(stream.read(4), 4))
        left = size - stream.tell()
        return stream.read(min(length, left)), max(length - left, 0)

    header, lacking = part()
    if lacking:
        raise _TornError(f'its last record lacks {lacking} bytes')
    data, lacking = part()
    return _fields(memoryview(header)), memoryview(data), lacking


def _records(content: memoryview) -> Iterator[Record]:
    at = 0
    while at < len(content):
        header, at = _part(content, at)
        data, at = _part(content, at)
        yield _fields(header), data


def _fields(header: memoryview) -> dict[bytes, bytes]:
    fields = {}
    at = 0
    while at < len(header):
        item, at = _part(header, at)
        name, _, value = bytes(item).partition(b'=')
        fields[name] = value
    return fields


def _part(content: memoryview, at: int) -> tuple[memoryview, int]:
    """Return the run of bytes whose length stands at `at`, and where the next begins."""
    length, = struct.unpack('<I', _exactly(content[at:at + 4], 4))
    end = at + 4 + length
    return _exactly(content[at + 4:end], length), end


def _exactly(data: Any, size: int) -> Any:
    if len(data) != size:
        raise _TornError(f'{len(data)} of {size} bytes')
    return data


def _field(header: dict[bytes, bytes], name: bytes, size: int) -> bytes:
    value: bytes = _exactly(header.get(name, b''), size)
    return value


def _number(header: dict[bytes, bytes], name: bytes) -> int:
    return int.from_bytes(_field(header, name, 4), 'little')


def _kind(header: dict[bytes, bytes]) -> int:
    return _field(header, b'op', 1)[0]


def _of_rosbags(connection: Any) -> Channel:
    return Channel(
        connection.topic, connection.msgtype, 'ros1', 'ros1msg', connection.msgdef.data,
        connection.msgcount)
