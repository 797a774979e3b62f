# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Write MCAP, message by message: clouds, depth images, transforms, finished views."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
import os
from typing import Any, IO, Literal

from msg_adapters import point_cloud2
import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.types import Bytes, Floats32or64, RangeView
from ros_rops.recordings import cdr, cdr_image
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.view_facts import (
    encode_facts, FACTS_TOPIC, organized, ViewFacts)

SCHEMAS: dict[str, tuple[str, str]] = {
    'sensor_msgs/msg/PointCloud2': ('ros2msg', cdr.POINT_CLOUD2_SCHEMA),
    'sensor_msgs/msg/Image': ('ros2msg', cdr_image.IMAGE_SCHEMA),
    'sensor_msgs/msg/CameraInfo': ('ros2msg', cdr_image.CAMERA_INFO_SCHEMA),
    'tf2_msgs/msg/TFMessage': ('ros2msg', cdr.TF_SCHEMA),
    'std_msgs/msg/String': ('ros2msg', cdr.STRING_SCHEMA),
    'ros_rops/IntakeEntry': ('jsonschema', '{"title": "ros_rops/IntakeEntry", "type": "object"}'),
}
LATCHED = """\
- history: keep_last
  depth: 1
  reliability: reliable
  durability: transient_local
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
"""
"""Quality of service, as rosbag2 notes it, of a topic that late joiners must see."""

Keep = Literal['buffered', 'flushed', 'synced']


class McapStream:
    """
    An MCAP file under construction.

    Parameters
    ----------
    stream : binary file object
        Written to, never closed.
    name : str
        What an error calls the file.
    keep : {'buffered', 'flushed', 'synced'}
        'flushed' gives each message to the operating system when it is added, 'synced' to the
        disk as well: wherever such a file breaks off, at most its last message is lost.
    compressed : bool
        By zstd.
    continued : bool
        The stream stands behind the last whole message of a file begun before. Such a file gets
        no index at its end; readers go through it instead.

    Raises
    ------
    InputError
        By every method, if the file cannot be written; the text names it.
    """

    def __init__(
        self, stream: IO[bytes], *, name: str = 'recording', keep: Keep = 'buffered',
        compressed: bool = True, continued: bool = False,
    ) -> None:
        from mcap.writer import CompressionType, IndexType, Writer

        self._stream, self._name, self._keep = stream, name, keep
        # A chunk a message, where each must be readable by itself.
        self._writer: Any = Writer(
            stream, chunk_size=1024 * 1024 if keep == 'buffered' else 0,
            compression=CompressionType.ZSTD if compressed else CompressionType.NONE,
            index_types=IndexType.NONE if continued else IndexType.ALL,
            repeat_channels=not continued, repeat_schemas=not continued,
            use_statistics=not continued, use_summary_offsets=not continued)
        self._schemas: dict[tuple[str, str], int] = {}
        self._channels: dict[str, int] = {}
        self._sequence: dict[str, int] = {}
        self._latest = 0
        if not continued:
            with self._writing():
                self._writer.start(profile='ros2', library='ros_rops')

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
            if self._keep != 'buffered':
                self._stream.flush()
            if self._keep == 'synced':
                os.fsync(self._stream.fileno())
        except OSError as error:
            raise InputError(
                f'{self._name}: cannot be written ({error.strerror or error})') from error

    def add(
        self, topic: str, kind: str, data: bytes, log_time_ns: int, *, latched: bool = False,
        schema: tuple[str, str] | None = None,
    ) -> None:
        """
        Add a message that is encoded already.

        Parameters
        ----------
        topic : str
        kind : str
            One of `SCHEMAS`, or what `schema` defines.
        data : bytes
        log_time_ns : int
        latched : bool
            Late joiners must see the topic's last message.
        schema : (str, str) or None
            Encoding and text of the definition.
        """
        with self._writing():
            if topic not in self._channels:
                self._channels[topic] = self._register(
                    topic, kind, latched, schema or SCHEMAS[kind])
            self._latest = max(self._latest, log_time_ns)
            number = self._sequence[topic] = self._sequence.get(topic, -1) + 1
            self._writer.add_message(
                self._channels[topic], log_time_ns, data, log_time_ns, number)

    def _register(
        self, topic: str, kind: str, latched: bool, schema: tuple[str, str]
    ) -> int:
        encoding, definition = schema
        key = (kind, definition)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                kind, encoding, definition.encode())
        channel: int = self._writer.register_channel(
            topic, 'json' if encoding == 'jsonschema' else 'cdr', self._schemas[key],
            {'offered_qos_profiles': LATCHED} if latched else {})
        return channel

    def add_cloud(
        self, points: Floats32or64, *, topic: str, stamp_ns: int, frame_id: str,
        log_time_ns: int | None = None, colors: Bytes | None = None,
        extra: Mapping[str, NDArray[Any]] | None = None, latched: bool = False,
    ) -> None:
        """
        Add a PointCloud2.

        Parameters
        ----------
        points : (H, W, 3) or (N, 3) float32 or float64
            Organized or not; NaN marks a hole. Float64 that float32 cannot hold exactly is
            written as float64 fields.
        topic, frame_id : str
        stamp_ns : int
        log_time_ns : int or None
            The stamp if None.
        colors : same shape, uint8, or None
        extra : mapping of str to (H, W) or (N,) arrays, or None
            Further fields.
        latched : bool
            Late joiners must see it.
        """
        values = point_cloud2.encode(points, colors, extra, wide=not _narrow(points))
        self.add(
            topic, 'sensor_msgs/msg/PointCloud2', cdr.point_cloud2(values, stamp_ns, frame_id),
            stamp_ns if log_time_ns is None else log_time_ns, latched=latched)

    def add_depth(
        self, depth: NDArray[Any], camera: Camera, *, topic: str, info_topic: str,
        stamp_ns: int, frame_id: str,
    ) -> None:
        """
        Add a depth image with its CameraInfo before it.

        Parameters
        ----------
        depth : (H, W) uint16 or float32
            Millimetres, 0 where none (16UC1); or metres, NaN where none (32FC1).
        camera : Camera
        topic, info_topic, frame_id : str
        stamp_ns : int
            Also the log time.
        """
        encoding = '16UC1' if depth.dtype == np.uint16 else '32FC1'
        self.add_camera_info(camera, topic=info_topic, stamp_ns=stamp_ns, frame_id=frame_id)
        self.add_image(depth, encoding, topic=topic, stamp_ns=stamp_ns, frame_id=frame_id)

    def add_camera_info(
        self, camera: Camera, *, topic: str, stamp_ns: int, frame_id: str
    ) -> None:
        """Add a CameraInfo."""
        self.add(topic, 'sensor_msgs/msg/CameraInfo',
                 cdr_image.camera_info(camera, stamp_ns, frame_id), stamp_ns)

    def add_image(
        self, pixels: NDArray[Any], encoding: str, *, topic: str, stamp_ns: int, frame_id: str
    ) -> None:
        """Add an Image; parameters as for `cdr_image.image`."""
        self.add(topic, 'sensor_msgs/msg/Image',
                 cdr_image.image(pixels, encoding, stamp_ns, frame_id), stamp_ns)

    def add_transforms(
        self, transforms: Sequence[cdr.Transform], *, stamp_ns: int, topic: str = '/tf',
        log_time_ns: int | None = None,
    ) -> None:
        """Add a TFMessage; one on `/tf_static` is seen by late joiners."""
        self.add(
            topic, 'tf2_msgs/msg/TFMessage', cdr.tf_message(transforms, stamp_ns),
            stamp_ns if log_time_ns is None else log_time_ns, latched=topic == '/tf_static')

    def add_view(
        self, view: RangeView, *, topic: str = '/points', log_time_ns: int | None = None
    ) -> None:
        """
        Add a view so that `read_frames` and `frame_view` give it back bit by bit.

        Parameters
        ----------
        view : RangeView
        topic : str
        log_time_ns : int or None
            The view's stamp if None, or the time of the last message where it has none.
        """
        points, colors = organized(view)
        whole = points.ndim == 3 or view.grid is None
        self._add_with_facts(points, colors, log_time_ns, ViewFacts(
            topic, 'view', view.name, view.units, view.sensor, view.stamp_ns, view.frame_id,
            points.shape[:-1], None if whole else view.grid, view.support,
            beyond=view.beyond, T_fixed_sensor=view.T_fixed_sensor))

    def add_frame(self, frame: Frame) -> None:
        """Add a frame so that `read_frames` gives it back as it is."""
        topic = frame.topic or '/points'
        if frame.view is not None:
            self.add_view(frame.view, topic=topic, log_time_ns=frame.log_time_ns)
            return
        self._add_with_facts(frame.points, frame.colors, frame.log_time_ns, ViewFacts(
            topic, 'frame', frame.name, frame.units, frame.sensor, frame.stamp_ns,
            frame.frame_id, frame.points.shape[:-1], notes=frame.notes))

    def _add_with_facts(
        self, points: Floats32or64, colors: Bytes | None, log_time_ns: int | None,
        facts: ViewFacts,
    ) -> None:
        stamp = facts.stamp_ns
        if log_time_ns is None:
            log_time_ns = self._latest if stamp is None or stamp < 0 else stamp
        self.add_text(encode_facts(facts).decode(), topic=FACTS_TOPIC, log_time_ns=log_time_ns)
        self.add_cloud(
            points, topic=facts.topic, stamp_ns=stamp or 0, frame_id=facts.frame_id,
            log_time_ns=log_time_ns, colors=colors)

    def add_text(
        self, text: str, *, topic: str, log_time_ns: int, latched: bool = False
    ) -> None:
        """Add a std_msgs/String."""
        self.add(topic, 'std_msgs/msg/String', cdr.string_message(text), log_time_ns,
                 latched=latched)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Add a metadata record about the whole file."""
        with self._writing():
            self._writer.add_metadata(name, dict(values))

    def finish(self) -> None:
        """Write the index and the end; nothing can be added any more."""
        with self._writing():
            self._writer.finish()
            self._stream.flush()


def _narrow(points: Floats32or64) -> bool:
    """Return whether float32 holds the points exactly."""
    if points.dtype == np.float32:
        return True
    with np.errstate(over='ignore'):
        return bool(np.array_equal(points.astype(np.float32), points, equal_nan=True))
