# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of an MCAP file: by its index, or in sequence if it breaks off before that."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, IO

from ros_rops.core.errors import InputError
from ros_rops.recordings.mcap_sequence import Found, Sequence, TornError
from ros_rops.recordings.messages import Channel, Cut, RawMessage, spelled


class McapFile:
    """
    An open MCAP file.

    Parameters
    ----------
    path : Path
        Named in messages.
    stream : binary file
        Can seek.

    Raises
    ------
    InputError
        If it is no MCAP file.
    """

    def __init__(self, path: Path, stream: IO[bytes]) -> None:
        self._path, self._stream = path, stream
        self._summary = self._find_summary()
        self._known: dict[int, Channel] | None = None

    def channels(self) -> list[Channel]:
        """Return the channels; a file without an index is read through for them, once."""
        if self._known is None:
            self._known = self._counted()
        return list(self._known.values())

    def messages(self, topics: frozenset[str]) -> Iterator[RawMessage | Cut]:
        """Yield the messages of `topics` in the order of log time; last a `Cut` if it is cut."""
        records = self._in_sequence() if self._summary is None else self._by_index(topics)
        known: dict[int, Channel] = {}
        while True:
            try:
                schema, channel, time, data = next(records)
            except StopIteration:
                return
            except TornError as error:
                yield Cut(str(error))
                return
            except Exception as error:  # damaged bytes make the library raise all sorts of things
                yield Cut(f'{type(error).__name__} {error}'.strip())
                return
            if channel.topic in topics:
                if channel.id not in known:
                    known[channel.id] = _channel(schema, channel)
                yield RawMessage(known[channel.id], time, data)

    def _counted(self) -> dict[int, Channel]:
        if self._summary is not None:
            counts = self._summary.statistics.channel_message_counts
            return {
                number: replace(
                    _channel(self._summary.schemas.get(channel.schema_id), channel),
                    count=counts.get(number, 0))
                for number, channel in self._summary.channels.items()}
        known: dict[int, Channel] = {}
        try:
            for schema, channel, _, _ in self._in_sequence():
                one = known.get(channel.id) or replace(_channel(schema, channel), count=0)
                known[channel.id] = replace(one, count=(one.count or 0) + 1)
        except TornError:
            return known  # the end of what can be read, which `messages` tells of
        return known

    def _reader(self) -> Any:
        from mcap.reader import make_reader

        self._stream.seek(0)
        return make_reader(self._stream, validate_crcs=True)

    def _find_summary(self) -> Any:
        """Return the index at the end, or None: a recording that breaks off has none."""
        try:
            reader = self._reader()
        except Exception:  # a file of a few bytes raises struct.error, not one of mcap's own
            empty = self._stream.seek(0, 2) == 0
            raise InputError(
                f'{self._path}: is {"empty" if empty else "not an MCAP file"}') from None
        try:
            summary = reader.get_summary()
        except Exception:  # whatever the bytes at the end provoke, they are no index
            return None
        return summary if summary is not None and _is_complete(summary) else None

    def _in_sequence(self) -> Iterator[Found]:
        return Sequence(self._stream).messages()

    def _by_index(self, topics: frozenset[str]) -> Iterator[Found]:
        for schema, channel, message in self._reader().iter_messages(topics=sorted(topics)):
            yield schema, channel, message.log_time, memoryview(message.data)


def _is_complete(summary: Any) -> bool:
    """Tell whether all can be found by the index; without chunks, mcap would load the file."""
    statistics = summary.statistics
    return bool(
        summary.chunk_indexes and statistics is not None
        and sum(statistics.channel_message_counts.values()) == statistics.message_count
        and summary.channels.keys() >= statistics.channel_message_counts.keys()
        and all(c.schema_id in {0, *summary.schemas} for c in summary.channels.values()))


def _channel(schema: Any, channel: Any) -> Channel:
    if schema is None:
        return Channel(channel.topic, '', channel.message_encoding)
    return Channel(
        channel.topic, spelled(schema.name), channel.message_encoding, schema.encoding,
        schema.data.decode('utf-8', 'replace'))
