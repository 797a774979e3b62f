# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Views of an MCAP recording: every sensor_msgs/PointCloud2 in it, in order of log time."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, IO

from msg_adapters import point_cloud2
from ros_rops.core.errors import InputError
from ros_rops.recordings.cloud import Cloud, full_grid
from ros_rops.recordings.reader import BadView, finish, NotedView

POINT_CLOUD2 = frozenset({'sensor_msgs/msg/PointCloud2', 'sensor_msgs/PointCloud2'})


def count_views(path: Path) -> int:
    """
    Return how many point clouds a recording holds, from its index if it has one.

    Raises
    ------
    InputError
        If the file cannot be read or is no MCAP file.
    """
    with _open(path) as stream:
        summary = _summary(path, stream)
        if summary is not None and summary.statistics is not None:
            counts = summary.statistics.channel_message_counts
            return sum(counts.get(channel.id, 0) for channel in _channels(summary))
        return sum(isinstance(item, tuple) for item in _messages(path, stream))


def read_views(
    path: Path, *, units: str = 'auto', sensor: str = 'auto'
) -> Iterator[NotedView | BadView]:
    """
    Yield the views of a recording, named '<topic>@<log time in ns>'.

    A message that cannot be decoded is yielded as a `BadView` and the rest follows; so is the
    end of a recording that breaks off, after all that could be read of it.

    Parameters
    ----------
    path : Path
    units, sensor : str
        As for `read_view`; 'auto' follows REP 103: metres, and unorganized points in an
        `*optical_frame` are seen from the frame's origin.

    Raises
    ------
    InputError
        If the file cannot be read, is no MCAP file or holds no point cloud.
    """
    from mcap_ros2.decoder import DecoderFactory

    factory = DecoderFactory()
    used: dict[str, int] = {}
    with _open(path) as stream:
        for item in _messages(path, stream):
            if isinstance(item, BadView):
                yield item
                return
            schema, channel, message = item
            name = _unique(f'{channel.topic}@{message.log_time}', used)
            if channel.message_encoding != 'cdr' or schema.encoding != 'ros2msg':
                yield BadView(name, f'{name}: encoding {channel.message_encoding!r} with schema '
                              f'{schema.encoding!r} is not read')
                continue
            yield _view(name, factory, schema, message.data, units, sensor)
    if not used:
        raise InputError(f'{path}: holds no sensor_msgs/msg/PointCloud2')


def _view(
    name: str, factory: Any, schema: Any, data: bytes, units: str, sensor: str
) -> NotedView | BadView:
    try:
        message = factory.decoder_for('cdr', schema)(data)
    except Exception as error:  # the decoder is generated from the file: it raises what it likes
        return BadView(name, f'{name}: the message cannot be decoded ({error})')
    try:
        xyz, rgb = point_cloud2.decode(message)
    except InputError as error:
        return BadView(name, f'{name}: {error}')
    grid = full_grid(*xyz.shape[:2]) if xyz.ndim == 3 else None
    colors = None if rgb is None else rgb.reshape(-1, 3)
    frame_id = str(message.header.frame_id)
    if sensor == 'auto' and grid is None and frame_id.endswith('optical_frame'):
        sensor = 'pinhole'  # REP 103: such a frame is the camera's, z forward
    if units == 'auto':
        units = 'm'  # REP 103
    noted = finish(name, Cloud(xyz.reshape(-1, 3), grid, colors), units=units, sensor=sensor)
    stamp = message.header.stamp
    view = replace(
        noted.view,
        stamp_ns=int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec),
        frame_id=frame_id,
    )
    return NotedView(view, tuple(f'{name}: {note}' for note in noted.notes))


def _is_cloud(schema: Any) -> bool:
    return schema is not None and schema.name in POINT_CLOUD2


def _channels(summary: Any) -> list[Any]:
    return [c for c in summary.channels.values() if _is_cloud(summary.schemas.get(c.schema_id))]


def _unique(name: str, used: dict[str, int]) -> str:
    used[name] = used.get(name, 0) + 1
    return name if used[name] == 1 else f'{name}#{used[name]}'


@contextmanager
def _open(path: Path) -> Iterator[IO[bytes]]:
    try:
        stream = path.open('rb')
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    with stream:
        yield stream


def _reader(path: Path, stream: IO[bytes]) -> Any:
    from mcap.reader import make_reader

    stream.seek(0)
    try:
        return make_reader(stream, validate_crcs=True)
    except Exception:  # a file of a few bytes raises struct.error, not one of mcap's own
        empty = path.stat().st_size == 0
        raise InputError(f'{path}: is {"empty" if empty else "not an MCAP file"}') from None


def _summary(path: Path, stream: IO[bytes]) -> Any:
    """Return the index at the end, or None: a recording that breaks off has none."""
    reader = _reader(path, stream)
    try:
        return reader.get_summary()
    except Exception:  # whatever the bytes at the end provoke, they are no index
        return None


def _messages(path: Path, stream: IO[bytes]) -> Iterator[tuple[Any, Any, Any] | BadView]:
    """Yield (schema, channel, message) of every point cloud; last a `BadView` if it breaks off."""
    indexed = _summary(path, stream) is not None
    records = _reader(path, stream).iter_messages() if indexed else _in_sequence(stream)
    done = 0
    while True:
        try:
            item = next(records)
        except StopIteration:
            return
        except Exception as error:  # damaged bytes make the library raise all sorts of things
            reason = f'{type(error).__name__} {error}'.strip()
            yield BadView(path.name, f'{path}: the recording is truncated or damaged after '
                          f'{done} {"view" if done == 1 else "views"} ({reason})')
            return
        if _is_cloud(item[0]):
            done += 1
            yield item


def _in_sequence(stream: IO[bytes]) -> Iterator[tuple[Any, Any, Any]]:
    """Yield (schema, channel, message) as they stand in the file, without an index."""
    from mcap.records import Channel, Message, Schema
    from mcap.stream_reader import StreamReader

    schemas: dict[int, Any] = {}
    channels: dict[int, Any] = {}
    stream.seek(0)
    for record in StreamReader(stream, validate_crcs=True).records:
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Message):
            channel = channels[record.channel_id]
            yield schemas.get(channel.schema_id), channel, record
