# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Read a journal back, up to where it broke off."""

from collections.abc import Iterator
from dataclasses import dataclass, field
import io
import json
from pathlib import Path
import shutil
import struct
from typing import Any, IO

from msg_adapters import point_cloud2

from ros_rops.core.errors import InputError, RopsError
from ros_rops.core.frame import Frame
from ros_rops.core.types import RangeView
from ros_rops.intake.journal import ENTRY_TOPIC, VIEW_TOPIC
from ros_rops.intake.reports import Counts, FrameReport, Word
from ros_rops.recordings.messages import Channel, Decoder, RawMessage
from ros_rops.recordings.view_facts import decode_facts, FACTS_TOPIC, ViewFacts, with_facts

MAGIC = b'\x89MCAP0\r\n'
CHUNK, MESSAGE_INDEX, DATA_END = 6, 7, 15
OPCODES = frozenset(range(1, 16))


@dataclass(frozen=True, slots=True)
class Entry:
    """
    One entry of a journal.

    Parameters
    ----------
    kind : {'open', 'begin', 'frame', 'end', 'command', 'count'}
    source : int
        Number of the input ('begin', 'end').
    report : FrameReport or None
        The word on a frame ('frame').
    views : tuple of RangeView
        What the frame gave.
    command : str
        What was asked of the session ('command').
    counts : mapping of Word to mapping of str to int
        Frames of which no report is kept, by reason ('count').
    """

    kind: str
    source: int = -1
    report: FrameReport | None = None
    views: tuple[RangeView, ...] = ()
    command: str = ''
    counts: Counts = field(default_factory=dict)


class Past:
    """
    What a journal holds; iterate over it once to get its entries, one in memory at a time.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    at : int
        Behind the last whole entry yielded, in bytes.
    latest_ns : int
        Log time of the last message before that.
    torn : int
        Bytes behind the last whole entry, which a crash cut off; known at the end.
    damage : str
        What is wrong with these, if they were not just cut off; empty otherwise.
    """

    def __init__(self, path: Path) -> None:
        self.at = 0
        self.latest_ns = 0
        self.torn = 0
        self.damage = ''
        self._path = path
        self._ended = False
        self._channels: dict[int, Channel] = {}
        self._schemas: dict[int, Any] = {}
        self._decoder = Decoder()
        self._facts: ViewFacts | None = None
        self._views: list[RangeView] = []

    def __iter__(self) -> Iterator[Entry]:
        """
        Yield the entries in order.

        Raises
        ------
        InputError
            If the file cannot be opened. Damage raises nothing: it ends the entries.
        """
        try:
            stream = self._path.open('rb')
        except OSError as error:
            raise InputError(
                f'{self._path}: cannot be read ({error.strerror or error})') from None
        with stream:
            size = self._path.stat().st_size
            try:
                yield from self._entries(stream, size)
            except GeneratorExit:
                raise
            except (RopsError, OSError, ValueError, KeyError, TypeError) as error:
                self.damage = str(error)
            self.torn = 0 if self._ended else size - self.at

    def _entries(self, stream: IO[bytes], size: int) -> Iterator[Entry]:
        if stream.read(len(MAGIC)) != MAGIC:
            if size > len(MAGIC):
                raise InputError('it is no MCAP file')
            return
        sealed = False
        for opcode, end, content in _records(stream, size):
            if opcode == DATA_END:
                if sealed:
                    self.at = end - len(content) - 9
                self._ended = sealed
                return
            if opcode == MESSAGE_INDEX and sealed:
                self.at = end
            if opcode != CHUNK:
                continue
            sealed = False
            for entry in self._chunk(content):
                self.at, sealed = end, True
                yield entry

    def _chunk(self, content: bytes) -> Iterator[Entry]:
        from mcap.records import Channel as McapChannel, Message, Schema

        for record in _unpacked(content):
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, McapChannel):
                schema = self._schemas[record.schema_id]
                self._channels[record.id] = Channel(
                    record.topic, schema.name, record.message_encoding, schema.encoding,
                    schema.data.decode())
            elif isinstance(record, Message):
                self.latest_ns = max(self.latest_ns, record.log_time)
                entry = self._message(
                    RawMessage(self._channels[record.channel_id], record.log_time, record.data))
                if entry is not None:
                    yield entry

    def _message(self, raw: RawMessage) -> Entry | None:
        topic = raw.channel.topic
        if topic == FACTS_TOPIC:
            self._facts = decode_facts(bytes(raw.data))
        elif topic == VIEW_TOPIC:
            self._views.append(self._view(raw))
        elif topic == ENTRY_TOPIC:
            return self._entry(json.loads(bytes(raw.data)))
        return None

    def _view(self, raw: RawMessage) -> RangeView:
        facts, self._facts = self._facts, None
        if facts is None:
            raise InputError('a view stands there without its facts')
        points, colors = point_cloud2.decode(self._decoder.decode(raw))
        view = with_facts(Frame('', points, colors), facts).view
        if view is None:
            raise InputError(f'{facts.name} is no view')
        return view

    def _entry(self, content: dict[str, Any]) -> Entry:
        (kind, value), views = next(iter(content.items())), tuple(self._views)
        self._views = []
        if kind == 'command':
            return Entry(kind, command=str(value))
        if kind == 'count':
            return Entry(kind, counts={
                Word(word): {str(why): int(number) for why, number in reasons.items()}
                for word, reasons in value.items()})
        if kind != 'frame':
            return Entry(kind, value if isinstance(value, int) else -1)
        report = FrameReport.from_json(value)
        if report.views != tuple(view.name for view in views):
            raise InputError(f'the entry on {report.name} does not go with the views before it')
        return Entry(kind, report=report, views=views)


def _records(stream: IO[bytes], size: int) -> Iterator[tuple[int, int, bytes]]:
    """Yield (opcode, where it ends, content) of each whole record of the file."""
    while True:
        head = stream.read(9)
        if len(head) < 9:
            return
        opcode, length = struct.unpack('<BQ', head)
        if opcode not in OPCODES:
            raise InputError(f'no record begins at byte {stream.tell() - 9}')
        if stream.tell() + length > size:
            return
        content = stream.read(length)
        yield opcode, stream.tell(), content


def _unpacked(content: bytes) -> list[Any]:
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk
    from mcap.stream_reader import breakup_chunk

    try:
        chunk = Chunk.read(ReadDataStream(io.BytesIO(content)))
        return breakup_chunk(chunk, validate_crc=True)
    except Exception as error:  # damaged bytes make the library raise all sorts of things
        raise InputError(f'a chunk is damaged ({error or type(error).__name__})') from None


def aside_of(journal: Path) -> Path:
    """Return where a damaged journal is kept whole."""
    return journal.with_suffix('.damaged.mcap')


def set_aside(journal: Path) -> None:
    """
    Keep a damaged journal whole: what follows the damage may be of use to somebody.

    Raises
    ------
    OSError
        If its copy cannot be written.
    """
    shutil.copyfile(journal, aside_of(journal))
