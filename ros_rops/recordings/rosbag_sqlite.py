# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Messages of a rosbag2 sqlite3 file, sound or broken off.

The table is read in the order in which it was written, without its index of times: that index
lies behind the messages that a broken file has lost.
"""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
import sqlite3
from urllib.parse import quote

from ros_rops.core.errors import InputError
from ros_rops.recordings.messages import Channel, Cut, RawMessage, spelled, unpacked

ZSTD = b'\x28\xb5\x2f\xfd'
"""No message in CDR begins so: its first byte is 0."""
MAGIC = b'SQLite format 3\0'
MOST_GAPS = 1000
"""So many damaged places are stepped over."""


class SqliteFile:
    """
    An open rosbag2 sqlite3 file.

    Parameters
    ----------
    path : Path
    unpack : bool
        Whether messages that are compressed each by itself are unpacked: without the folder's
        metadata nothing else tells that they are.

    Raises
    ------
    InputError
        If it is no sqlite3 file or lacks rosbag2's tables.
    """

    def __init__(self, path: Path, *, unpack: bool = False) -> None:
        self._path, self._unpack = path, unpack
        self._connection = _connect(path)
        self._tail = _tail(path)
        try:
            self._channels = self._read_channels()
        except (sqlite3.Error, ValueError, OverflowError) as error:
            self.close()
            raise InputError(f'{path}: is no rosbag2 file, or damaged ({error})') from None

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def channels(self) -> list[Channel]:
        """Return the channels."""
        counts = dict.fromkeys(self._channels, 0)
        for row in self._scan('topic_id', ''):
            if not isinstance(row, Cut) and row[0] in counts:
                counts[row[0]] += 1
        return [
            Channel(c.topic, c.kind, c.encoding, c.schema_encoding, c.definition, counts[number])
            for number, c in self._channels.items()]

    def messages(self, topics: frozenset[str]) -> Iterator[RawMessage | Cut]:
        """Yield the messages of `topics` in the order of log time; last a `Cut` if it is cut."""
        wanted = [number for number, c in self._channels.items() if c.topic in topics]
        cut: Cut | None = None
        order: list[tuple[int, int, int]] = []
        numbers = ','.join(map(str, wanted)) or '-1'
        for row in self._scan('timestamp, id, topic_id', f'AND topic_id IN ({numbers})'):
            if isinstance(row, Cut):
                cut = row
            elif all(isinstance(value, int) for value in row):
                time, number, topic = row
                order.append((time, number, topic))
        last = max((number for _, number, _ in order), default=0)
        for time, number, topic in sorted(order):
            try:
                data = bytes(self._connection.execute(
                    'SELECT data FROM messages WHERE id = ?', (number,)).fetchone()[0])
            except (sqlite3.Error, TypeError, ValueError) as error:
                cut = cut or Cut(str(error))
                continue
            if number == last and self._is_torn(data):
                cut = cut or Cut('its last page is not whole')
                continue
            raw = RawMessage(self._channels[topic], time, data)
            packed = self._unpack and raw.channel.encoding == 'cdr' and data.startswith(ZSTD)
            yield unpacked(raw) if packed else raw
        if cut is not None:
            yield cut

    def _is_torn(self, data: bytes) -> bool:
        """Tell whether a message ends in the part page at the end of a broken file."""
        # sqlite takes what is missing of that page for zeros.
        return self._tail is not None and data.rstrip(b'\0').endswith(self._tail.rstrip(b'\0'))

    def _scan(self, columns: str, where: str) -> Iterator[tuple[int, ...] | Cut]:
        """Yield rows of the messages that can be read; last a `Cut` if there are others."""
        query = f'SELECT id, {columns} FROM messages NOT INDEXED WHERE id > ? {where}'
        low: int | None = 0
        cut: Cut | None = None
        for _ in range(MOST_GAPS):
            try:
                with closing(self._connection.execute(query, (low,))) as rows:
                    for number, *row in rows:
                        low = number
                        yield tuple(row)
                break
            except sqlite3.Error as error:
                cut = Cut(str(error))
            low = self._behind_gap(low or 0)
            if low is None:
                break
        if cut is not None:
            yield cut

    def _behind_gap(self, low: int) -> int | None:
        """Return the least number found behind which messages can be read again."""
        width: int | None = next(
            (2**k for k in range(40) if self._is_sound(low + 2**k)), None)
        if width is None:
            return None
        lost, sound = low + width // 2, low + width
        while sound - lost > 1:
            middle = (lost + sound) // 2
            lost, sound = (lost, middle) if self._is_sound(middle) else (middle, sound)
        return sound

    def _is_sound(self, low: int) -> bool:
        try:
            found = self._connection.execute(
                'SELECT id FROM messages NOT INDEXED WHERE id > ? LIMIT 1', (low,)).fetchone()
        except sqlite3.Error:
            return False
        return found is not None

    def _read_channels(self) -> dict[int, Channel]:
        definitions = self._read_definitions()
        rows = self._connection.execute(
            'SELECT id, name, type, serialization_format FROM topics ORDER BY id').fetchall()
        self._connection.execute('SELECT id, topic_id, timestamp, data FROM messages LIMIT 0')
        return {
            int(number): Channel(
                str(topic), spelled(str(kind)), str(encoding), *definitions.get(kind, ('', '')))
            for number, topic, kind, encoding in rows}

    def _read_definitions(self) -> dict[str, tuple[str, str]]:
        """Return (encoding, text) by type; recordings before Iron have none."""
        try:
            return {
                str(kind): (str(encoding), str(text))
                for kind, encoding, text in self._connection.execute(
                    'SELECT topic_type, encoding, encoded_message_definition '
                    'FROM message_definitions') if text}
        except sqlite3.Error:
            return {}


def _connect(path: Path) -> sqlite3.Connection:
    with path.open('rb') as stream:
        head = stream.read(len(MAGIC))
    if head != MAGIC:
        raise InputError(f'{path}: is {"not a sqlite3 file" if head else "empty"}')
    # immutable: no lock, no journal, also on a disk that cannot be written.
    connection = sqlite3.connect(
        f'file:{quote(str(path.resolve()))}?mode=ro&immutable=1', uri=True,
        check_same_thread=False)
    # Makes sqlite open a file that is shorter than its first page says.
    connection.execute('PRAGMA writable_schema = ON')
    connection.text_factory = lambda data: data.decode('utf-8', 'replace')
    return connection


def _tail(path: Path) -> bytes | None:
    """Return what the part page at the end of a broken file holds of a message, or None."""
    with path.open('rb') as stream:
        stream.seek(16)
        size = int.from_bytes(stream.read(2), 'big')
        part = path.stat().st_size % (65536 if size == 1 else max(size, 512))
        stream.seek(-part, 2)
        # The first four bytes are the number of the next page.
        return stream.read(part)[4:] if part else None
