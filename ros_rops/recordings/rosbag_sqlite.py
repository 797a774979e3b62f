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
from ros_rops.recordings.messages import Channel, Cut, RawMessage, spelled

MAGIC = b'SQLite format 3\0'
LARGEST_BLOB = 2**31 - 1


class SqliteFile:
    """
    An open rosbag2 sqlite3 file.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If it is no sqlite3 file or lacks rosbag2's tables.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._connection = _connect(path)
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
        numbers = ','.join(map(str, wanted))
        for row in self._scan('timestamp, id, topic_id', f'WHERE topic_id IN ({numbers})'):
            if isinstance(row, Cut):
                cut = row
            elif all(isinstance(value, int) for value in row):
                order.append(row)
        for time, number, topic in sorted(order):
            try:
                data = self._connection.execute(
                    'SELECT data FROM messages WHERE id = ?', (number,)).fetchone()[0]
                yield RawMessage(self._channels[topic], time, data if data else b'')
            except (sqlite3.Error, TypeError) as error:
                cut = cut or Cut(str(error))
        if cut is not None:
            yield cut

    def _scan(self, columns: str, where: str) -> Iterator[tuple[int, ...] | Cut]:
        """Yield rows of the messages as far as they go; last a `Cut` if not to the end."""
        query = f'SELECT {columns} FROM messages NOT INDEXED {where}'
        try:
            with closing(self._connection.execute(query)) as rows:
                yield from rows
        except sqlite3.Error as error:
            yield Cut(str(error))

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
