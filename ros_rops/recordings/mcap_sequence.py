# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The records of an MCAP file as they stand in it, to its last whole message.

For files that break off: mcap's own reader gives up the chunk in which they do.
"""

from collections.abc import Iterator
import io
import os
import struct
from typing import Any, IO
import zlib

from ros_rops.recordings.unpacking import LARGEST

MAGIC = b'\x89MCAP0\r\n'
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15
CHUNK_HEAD = struct.Struct('<QQQII')
MESSAGE_HEAD = struct.Struct('<HIQQ')
Found = tuple[Any, Any, int, memoryview]
"""Schema or None, channel, log time, data."""


class TornError(Exception):
    """The bytes end, or make no sense, in the middle of a record."""


class Sequence:
    """
    The messages of a file in the order in which they were written.

    Parameters
    ----------
    stream : binary file
        Can seek.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._schemas: dict[int, Any] = {}
        self._channels: dict[int, Any] = {}

    def messages(self) -> Iterator[Found]:
        """
        Yield the messages.

        Raises
        ------
        TornError
            Where the file breaks off before the end of its data, or is damaged.
        """
        size = os.fstat(self._stream.fileno()).st_size
        self._stream.seek(len(MAGIC))
        while True:
            head = self._stream.read(9)
            if len(head) < 9:
                raise TornError('it ends without its index')
            kind, length = struct.unpack('<BQ', head)
            left = size - self._stream.tell()
            if kind == CHUNK:
                yield from self._chunk(memoryview(self._stream.read(min(length, left))), length)
            elif length > left:
                raise TornError(f'a record of {length} bytes, {left} left')
            elif kind == DATA_END:
                self._stream.seek(-len(MAGIC), os.SEEK_END)
                if self._stream.read() != MAGIC:
                    raise TornError('it ends within its index')
                return
            elif kind in (SCHEMA, CHANNEL, MESSAGE):
                yield from self._record(kind, memoryview(self._stream.read(length)))
            else:
                self._stream.seek(length, os.SEEK_CUR)

    def _chunk(self, content: memoryview, length: int) -> Iterator[Found]:
        whole = len(content) == length
        if len(content) < CHUNK_HEAD.size:
            raise TornError('it ends within a chunk')
        _, _, size, crc, name_length = CHUNK_HEAD.unpack_from(content)
        at = CHUNK_HEAD.size + name_length
        compression = bytes(content[CHUNK_HEAD.size:at]).decode('latin-1')
        records, fault = _unpack(compression, content[at + 8:], size)
        if whole and not fault and crc and zlib.crc32(records) != crc:
            raise TornError('a chunk fails its checksum')
        yield from self._records(memoryview(records))
        if not whole or fault or len(records) != size:
            raise TornError(fault or 'it ends within a chunk')

    def _records(self, content: memoryview) -> Iterator[Found]:
        """Yield the messages of a chunk as far as its records are whole."""
        at = 0
        while at + 9 <= len(content):
            kind, length = struct.unpack_from('<BQ', content, at)
            if at + 9 + length > len(content):
                return
            yield from self._record(kind, content[at + 9:at + 9 + length])
            at += 9 + length

    def _record(self, kind: int, content: memoryview) -> Iterator[Found]:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Channel, Schema

        if kind == MESSAGE:
            if len(content) < MESSAGE_HEAD.size:
                raise TornError('a message of no length')
            number, _, time, _ = MESSAGE_HEAD.unpack_from(content)
            channel = self._channels.get(number)
            if channel is None:
                raise TornError(f'a message of an unknown channel {number}')
            yield (self._schemas.get(channel.schema_id), channel, time,
                   content[MESSAGE_HEAD.size:])
        elif kind in (SCHEMA, CHANNEL):
            known, record = (
                (self._schemas, Schema) if kind == SCHEMA else (self._channels, Channel))
            try:
                one: Any = record.read(ReadDataStream(io.BytesIO(content)))
            except Exception as error:  # mcap raises whatever damaged bytes provoke
                raise TornError(f'{type(error).__name__} {error}'.strip()) from None
            known[one.id] = one


def _unpack(
    compression: str, data: memoryview, size: int
) -> tuple[bytes | memoryview, str]:
    """Return what a chunk holds, as far as it goes, and why no farther."""
    if size > LARGEST:
        return b'', f'a chunk states {size} bytes'
    if not compression:
        return data, ''
    if compression == 'zstd':
        return _unpack_zstd(data, size)
    if compression == 'lz4':
        from lz4.frame import LZ4FrameDecompressor

        try:
            return LZ4FrameDecompressor().decompress(data, max_length=size), ''
        except (RuntimeError, EOFError, ValueError) as error:
            return b'', f'a chunk is damaged ({error})'
    return b'', f'a chunk is compressed by {compression!r}'


def _unpack_zstd(data: memoryview, size: int) -> tuple[bytes, str]:
    import zstandard

    out = io.BytesIO()
    try:
        with zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)) as stream:
            while out.tell() < size and (block := stream.read(min(2**17, size - out.tell()))):
                out.write(block)
    except zstandard.ZstdError as error:
        return out.getvalue(), f'a chunk is damaged ({error})'
    return out.getvalue(), ''
