# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Small recordings of every kind, made by rosbags' and mcap's own writers from the same values."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer as McapWriter
import numpy as np
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore

JAZZY, NOETIC = get_typestore(Stores.ROS2_JAZZY), get_typestore(Stores.ROS1_NOETIC)
# The store of ROS 1 lacks it.
NOETIC.register(get_types_from_msg(
    'geometry_msgs/TransformStamped[] transforms', 'tf2_msgs/msg/TFMessage'))
SECOND = 1_000_000_000
Make = Callable[[Typestore], Any]


@dataclass(frozen=True, slots=True)
class Record:
    """A message to write: `make(store)` returns it in the types of a store."""

    topic: str
    kind: str
    time_ns: int
    make: Make


def header(store: Typestore, stamp_ns: int, frame: str) -> Any:
    """Return a std_msgs/Header."""
    stamp = store.types['builtin_interfaces/msg/Time'](stamp_ns // SECOND, stamp_ns % SECOND)
    kind = store.types['std_msgs/msg/Header']
    return kind(0, stamp, frame) if store is NOETIC else kind(stamp, frame)


def cloud(time_ns: int, xyz: np.ndarray, *, topic: str = '/points', stamp_ns: int | None = None,
          frame: str = 'eye') -> Record:
    """Return a PointCloud2 of (H, W, 3) float32."""
    kind = 'sensor_msgs/msg/PointCloud2'
    height, width = xyz.shape[:2]

    def make(store: Typestore) -> Any:
        field = store.types['sensor_msgs/msg/PointField']
        fields = [field(name, 4 * k, 7, 1) for k, name in enumerate('xyz')]
        return store.types[kind](
            header(store, time_ns if stamp_ns is None else stamp_ns, frame), height, width, fields,
            False, 12, 12 * width, np.frombuffer(xyz.astype('<f4').tobytes(), np.uint8), False)

    return Record(topic, kind, time_ns, make)


def image(time_ns: int, pixels: np.ndarray, encoding: str, *, topic: str = '/depth/image',
          frame: str = 'eye', stamp_ns: int | None = None, **changes: Any) -> Record:
    """Return an Image of (H, W) or (H, W, C) pixels, its bytes in the order of `pixels.dtype`."""
    kind = 'sensor_msgs/msg/Image'

    def make(store: Typestore) -> Any:
        data = np.frombuffer(pixels.tobytes(), np.uint8)
        values = {
            'header': header(store, time_ns if stamp_ns is None else stamp_ns, frame),
            'height': pixels.shape[0], 'width': pixels.shape[1], 'encoding': encoding,
            'is_bigendian': int(pixels.dtype.byteorder == '>'),
            'step': pixels[0].nbytes, 'data': data}
        return store.types[kind](**(values | changes))

    return Record(topic, kind, time_ns, make)


def info(time_ns: int, shape: tuple[int, int], *, focal: float = 20.0, frame: str = 'eye',
         topic: str = '/depth/camera_info', model: str = 'plumb_bob',
         distortion: Sequence[float] = (0, 0, 0, 0, 0)) -> Record:
    """Return a CameraInfo with the centre in the middle pixel."""
    kind = 'sensor_msgs/msg/CameraInfo'
    height, width = shape
    cx, cy = (width - 1) / 2, (height - 1) / 2

    def make(store: Typestore) -> Any:
        region = store.types['sensor_msgs/msg/RegionOfInterest'](0, 0, 0, 0, False)
        k = np.array([focal, 0, cx, 0, focal, cy, 0, 0, 1])
        p = np.array([focal, 0, cx, 0, 0, focal, cy, 0, 0, 0, 1, 0])
        return store.types[kind](
            header(store, time_ns, frame), height, width, model, np.array(distortion, float), k,
            np.eye(3).reshape(-1), p, 0, 0, region)

    return Record(topic, kind, time_ns, make)


def transform(time_ns: int, parent: str, child: str, translation: Sequence[float] = (0, 0, 0),
              quaternion: Sequence[float] = (0, 0, 0, 1), *, topic: str = '/tf') -> Record:
    """Return a TFMessage of one transform."""
    kind = 'tf2_msgs/msg/TFMessage'

    def make(store: Typestore) -> Any:
        t = store.types
        return t[kind]([t['geometry_msgs/msg/TransformStamped'](
            header(store, time_ns, parent), child, t['geometry_msgs/msg/Transform'](
                t['geometry_msgs/msg/Vector3'](*map(float, translation)),
                t['geometry_msgs/msg/Quaternion'](*map(float, quaternion))))])

    return Record(topic, kind, time_ns, make)


def text(time_ns: int, topic: str = '/chatter') -> Record:
    """Return a std_msgs/String."""
    return Record(topic, 'std_msgs/msg/String', time_ns,
                  lambda store: store.types['std_msgs/msg/String']('hello'))


def _mcap(path: Path, records: Sequence[Record], ros1: bool, chunk_size: int = 4000,
          **options: Any) -> None:
    store = NOETIC if ros1 else JAZZY
    with path.open('wb') as stream:
        writer = McapWriter(stream, chunk_size=chunk_size, **options)
        writer.start(profile='ros1' if ros1 else 'ros2')
        channels: dict[str, int] = {}
        for k, record in enumerate(records):
            if record.topic not in channels:
                name = record.kind.replace('/msg/', '/') if ros1 else record.kind
                words, _ = store.generate_msgdef(record.kind, ros_version=1 if ros1 else 2)
                schema = writer.register_schema(
                    name, 'ros1msg' if ros1 else 'ros2msg', words.encode())
                channels[record.topic] = writer.register_channel(
                    record.topic, 'ros1' if ros1 else 'cdr', schema)
            writer.add_message(
                channels[record.topic], record.time_ns, _bytes(record, ros1), record.time_ns, k)
        writer.finish()


def _bytes(record: Record, ros1: bool) -> bytes:
    store = NOETIC if ros1 else JAZZY
    write = store.serialize_ros1 if ros1 else store.serialize_cdr
    return bytes(write(record.make(store), record.kind))


def _rosbag2(path: Path, records: Sequence[Record], plugin: StoragePlugin,
             mode: CompressionMode) -> None:
    writer = Writer(path, version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        _fill(writer, records, JAZZY, ros1=False)


def write_ros1(path: Path, records: Sequence[Record], compression: Any, *,
               chunk: int = 4000) -> None:
    """Write a .bag; its chunks are small, so that a bag that breaks off keeps some."""
    writer = Ros1Writer(path)
    if compression is not None:
        writer.set_compression(compression)
    writer.chunk_threshold = chunk
    with writer:
        _fill(writer, records, NOETIC, ros1=True)


def _fill(writer: Any, records: Sequence[Record], store: Typestore, *, ros1: bool) -> None:
    connections: dict[str, Any] = {}
    for record in records:
        if record.topic not in connections:
            connections[record.topic] = writer.add_connection(
                record.topic, record.kind, typestore=store)
        writer.write(connections[record.topic], record.time_ns, _bytes(record, ros1))


FORMATS: dict[str, tuple[str, Callable[[Path, Sequence[Record]], None]]] = {
    'mcap': ('a.mcap', lambda p, r: _mcap(p, r, False)),
    'mcap lz4': ('a.mcap', lambda p, r: _mcap(p, r, False, compression=CompressionType.LZ4)),
    'mcap plain': ('a.mcap', lambda p, r: _mcap(p, r, False, use_chunking=False)),
    'mcap ros1': ('a.mcap', lambda p, r: _mcap(p, r, True)),
    'sqlite3': ('a', lambda p, r: _rosbag2(
        p, r, StoragePlugin.SQLITE3, CompressionMode.NONE)),
    'sqlite3 file': ('a', lambda p, r: _rosbag2(
        p, r, StoragePlugin.SQLITE3, CompressionMode.FILE)),
    'sqlite3 message': ('a', lambda p, r: _rosbag2(
        p, r, StoragePlugin.SQLITE3, CompressionMode.MESSAGE)),
    'folder mcap': ('a', lambda p, r: _rosbag2(p, r, StoragePlugin.MCAP, CompressionMode.NONE)),
    'folder mcap file': ('a', lambda p, r: _rosbag2(
        p, r, StoragePlugin.MCAP, CompressionMode.FILE)),
    'folder mcap storage': ('a', lambda p, r: _rosbag2(
        p, r, StoragePlugin.MCAP, CompressionMode.STORAGE)),
    'bag': ('a.bag', lambda p, r: write_ros1(p, r, None)),
    'bag bz2': ('a.bag', lambda p, r: write_ros1(p, r, Ros1Writer.CompressionFormat.BZ2)),
    'bag lz4': ('a.bag', lambda p, r: write_ros1(p, r, Ros1Writer.CompressionFormat.LZ4)),
}
"""By name: what the recording is called, and who writes it."""


def write_bag(folder: Path, kind: str, records: Sequence[Record]) -> Path:
    """Write a recording of a kind below `folder` and return its path."""
    name, write = FORMATS[kind]
    write(folder / name, records)
    return folder / name


def storage_file(path: Path) -> Path:
    """Return the file that holds the messages."""
    return path if path.is_file() else next(p for p in path.iterdir() if p.suffix != '.yaml')
