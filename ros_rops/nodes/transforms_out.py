# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Where objects and views stand, as transforms: latched for all views, on /tf for objects."""

from collections.abc import Sequence
import re
import threading
from typing import Any

from geometry_msgs.msg import TransformStamped
from msg_adapters import transforms
from msg_adapters.transforms import StampedTransform
import numpy as np
from rclpy.node import Node
from ros_rops.live.places import FrameNames, Place, poses
from ros_rops.live.words import Update
from ros_rops.nodes.wire import Wire

TF_DEPTH = 100
"""As tf2_ros has it."""


class TransformsOut:
    """
    Publish `transforms` and `/tf`; where tf2_msgs is missing, say so once and do nothing.

    Parameters
    ----------
    node : Node
    wire : Wire
    names : FrameNames
    broadcast : bool
        Whether `/tf` is wanted.
    """

    def __init__(self, node: Node, wire: Wire, names: FrameNames, *, broadcast: bool) -> None:
        self._node, self._wire, self._names = node, wire, names
        self._lock = threading.Lock()
        self._places: tuple[Place, ...] = ()
        self._stamp = 0
        self._refused: set[str] = set()
        self._kind, self._tf = self._message_kind(), None
        if self._kind is not None:
            self._all = wire.publisher(self._kind, 'transforms')
            if broadcast:
                self._tf = wire.publisher(self._kind, '/tf', TF_DEPTH)

    def publish(self, update: Update, places: Sequence[Place]) -> None:
        """
        Publish where views stand to their objects, and broadcast where objects stand from now on.

        Parameters
        ----------
        update : Update
        places : sequence of Place
            As `live.places.last_places` has them.
        """
        if self._kind is None:
            return
        with self._lock:
            self._places = tuple(place for place in places if self._may_stand(place))
        newest = update.views.get(update.newest)
        stamp_ns = (newest.stamp_ns if newest else None) or 0
        self._wire.send(self._all, self._message([
            StampedTransform(
                self._names.of_object(object_id), self._names.of_view(update.numbers[name]),
                stamp_ns, T)
            for object_id, views in poses(update).items() for name, T in views.items()]))
        self.rebroadcast()

    def rebroadcast(self) -> None:
        """Send on /tf where objects stand, as of now; nothing if there are none."""
        if self._tf is None:
            return
        # One at a time: stamps must not go back.
        with self._lock:
            now = self._node.get_clock().now().nanoseconds
            # A clock that stands still, or has not begun, gives stamps that tf2 warns of.
            if not self._places or now == self._stamp:
                return
            self._stamp = now
            self._wire.send(self._tf, self._message([
                StampedTransform(
                    place.frame_id, self._names.of_object(place.object_id), now,
                    place.T_frame_object)
                for place in self._places]))

    def _may_stand(self, place: Place) -> bool:
        """Tell whether a transform makes sense in a tree; say once of each frame if not."""
        ours = self._names.of_object(place.object_id)
        why = ''
        if not np.isfinite(place.T_frame_object).all():
            why = 'its pose is not finite'
        elif re.fullmatch(rf'{re.escape(self._names.prefix)}object_\d+', place.frame_id):
            why = (f'the sensor says that its frame is {place.frame_id}, which is a name of ours: '
                   'choose another publish.frame_prefix')
        if why and ours not in self._refused:
            self._refused.add(ours)
            self._node.get_logger().warning(f'{ours} is not put on /tf: {why}')
        return not why

    def _message(self, values: Sequence[StampedTransform]) -> Any:
        items = []
        for value in values:
            item = TransformStamped()
            transforms.fill(item, value)
            items.append(item)
        return self._kind(transforms=items)

    def _message_kind(self) -> Any:
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            self._node.get_logger().warning(
                'tf2_msgs is not installed: nothing goes out on /tf and transforms; poses are in '
                'markers and in what ~/save writes')
            return None
        return TFMessage
