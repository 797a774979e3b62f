# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The clouds that go out: all objects together, and each in its own frame."""

import array
from collections.abc import Sequence
import sys

from rclpy.publisher import Publisher
from ros_rops.core.groups_node import PublishConfig
from ros_rops.live.assembly import Assembly, Cloud, GEOMETRY, IDS, Piece, pieces_of
from ros_rops.live.places import FrameNames, Place, poses
from ros_rops.live.words import Update
from ros_rops.nodes.wire import Wire
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

MOST_POINTS = (2**32 - 1) // (4 * (len(GEOMETRY) + 1 + len(IDS)))
"""More do not fit into a message: its size is a number of 32 bits."""


class CloudsOut:
    """
    Publish `assembled` and `objects/object_<k>/assembled`.

    For one thread.

    Parameters
    ----------
    wire : Wire
    config : PublishConfig
    names : FrameNames
    """

    def __init__(self, wire: Wire, config: PublishConfig, names: FrameNames) -> None:
        self._wire, self._names, self._each = wire, names, config.objects
        self._assembly = Assembly(config.spacing_mr, min(config.most_points, MOST_POINTS))
        self._all = wire.publisher(PointCloud2, 'assembled')
        self._objects: dict[int, Publisher | None] = {}
        self._sent: dict[int, object] = {}
        self._last = PointCloud2()
        self._last_key: object = None

    def publish(self, update: Update, places: Sequence[Place], header: Header) -> None:
        """
        Publish what changed.

        Parameters
        ----------
        update : Update
        places : sequence of Place
            Objects in the frame of `header`.
        header : Header
            Of `assembled`.
        """
        self._assembly.take(update)
        known = poses(update)
        self._publish_all([
            Piece(place.object_id, name, place.T_frame_object @ T)
            for place in places for name, T in known[place.object_id].items()], header)
        if self._each:
            self._forget(gone=set(self._objects) - set(known))
            for object_id in known:
                self._publish_one(object_id, pieces_of(known, object_id))

    def _publish_all(self, pieces: list[Piece], header: Header) -> None:
        key = self._assembly.key(pieces)
        if key != self._last_key or not pieces:
            self._last, self._last_key = message_of(self._assembly.cloud(pieces)), key
        self._last.header = header
        self._wire.send(self._all, self._last)

    def _publish_one(self, object_id: int, pieces: list[Piece]) -> None:
        key = self._assembly.key(pieces)
        if self._sent.get(object_id) == key:
            return
        if object_id not in self._objects:
            self._objects[object_id] = self._wire.publisher(
                PointCloud2, f'objects/object_{object_id}/assembled')
        self._send_one(object_id, self._assembly.cloud(pieces))
        self._sent[object_id] = key

    def _send_one(self, object_id: int, cloud: Cloud) -> None:
        message = message_of(cloud)
        message.header = Header(frame_id=self._names.of_object(object_id))
        self._wire.send(self._objects[object_id], message)

    def _forget(self, gone: set[int]) -> None:
        for object_id in gone:
            self._send_one(object_id, self._assembly.cloud([]))
            self._wire.remove(self._objects.pop(object_id))
            del self._sent[object_id]


def message_of(cloud: Cloud) -> PointCloud2:
    """Return a cloud as a message, its header empty."""
    data = array.array('B')
    data.frombytes(cloud.words.data.cast('B') if len(cloud.words) else b'')
    fields = [
        PointField(
            name=name, offset=4 * k, count=1,
            datatype=PointField.INT32 if name in IDS else PointField.FLOAT32)
        for k, name in enumerate(cloud.fields)]
    step = 4 * len(fields)
    return PointCloud2(
        height=1, width=len(cloud.words), fields=fields, is_bigendian=sys.byteorder == 'big',
        point_step=step, row_step=step * len(cloud.words), data=data, is_dense=True)
