# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Write views as an MCAP recording of organized PointCloud2, their exact poses beside them."""

from collections.abc import Sequence
import io
import os
from pathlib import Path
from typing import Any

from msg_adapters import point_cloud2
import numpy as np

from ros_rops.core.errors import InputError
from ros_rops.core.types import Bytes, Floats, RangeView
from ros_rops.recordings import cdr
from ros_rops.recordings.synthetic import Capture

POSE_TOPIC = '/exact_poses'
"""Not /tf: one camera frame below two objects would be no tree."""


def organized(view: RangeView) -> tuple[Floats, Bytes | None]:
    """Return (H, W, 3) points, NaN where none, and colours; (N, 3) if not organized."""
    if view.grid is None:
        return view.points, view.colors
    empty = view.grid < 0
    if not len(view.points):
        return np.full((*view.grid.shape, 3), np.nan), None
    points = view.points[view.grid]
    points[empty] = np.nan
    colors = None if view.colors is None else view.colors[view.grid]
    if colors is not None:
        colors[empty] = 0
    return points, colors


def write_mcap(
    path: str | os.PathLike[str], captures: Sequence[Capture], *, topic: str = '/points'
) -> None:
    """
    Write a recording: one PointCloud2 per view and, on `/exact_poses`, its pose.

    Parameters
    ----------
    path : path
    captures : sequence of Capture
        In the order of their `stamp_ns`, which also is the log time.
    topic : str
        Of the clouds.

    Raises
    ------
    InputError
        If a view has no stamp, or the file cannot be written.
    """
    from mcap.writer import CompressionType, Writer

    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start(profile='ros2', library='ros_rops')
    clouds = _channel(
        writer, topic, 'sensor_msgs/msg/PointCloud2', cdr.POINT_CLOUD2_SCHEMA)
    poses = _channel(writer, POSE_TOPIC, 'tf2_msgs/msg/TFMessage', cdr.TF_SCHEMA)
    for sequence, capture in enumerate(captures):
        stamp, frame = capture.view.stamp_ns, capture.view.frame_id
        if stamp is None:
            raise InputError(f'{path}: view {capture.view.name!r} has no stamp')
        parent = capture.object_name or 'world'
        pose = cdr.tf_message(capture.T_world_view, stamp, parent, frame)
        writer.add_message(poses, stamp, pose, stamp, sequence)
        values = point_cloud2.encode(*organized(capture.view))
        cloud = cdr.point_cloud2(values, stamp, frame)
        writer.add_message(clouds, stamp, cloud, stamp, sequence)
    writer.finish()  # type: ignore[no-untyped-call]
    try:
        Path(path).write_bytes(stream.getvalue())
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None


def _channel(writer: Any, topic: str, name: str, schema: str) -> int:
    known: int = writer.register_schema(name, 'ros2msg', schema.encode())
    channel: int = writer.register_channel(topic, 'cdr', known)
    return channel
