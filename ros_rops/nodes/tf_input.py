# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What `/tf` and `/tf_static` say, for threads that ask where a frame stood at a time."""

from functools import partial
import threading
import time
from typing import Any

from msg_adapters import transforms
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats
from ros_rops.recordings.messages import Channel, Decoder, RawMessage
from ros_rops.recordings.transforms import TransformTree

KIND = 'tf2_msgs/msg/TFMessage'
SPAN_NS = 30_000_000_000
"""Moving transforms are kept for so long; no frame waits longer for its turn."""
WAIT_S = 0.2
"""A transform may come so much later than the frame that it belongs to."""
DEPTH = 100


class TfInput:
    """
    Listens to `/tf` and `/tf_static`, and answers `lookup` from any thread.

    Where tf2_msgs is missing it says so once, and knows nothing.

    Parameters
    ----------
    node : Node
    wait_s : float
        The longest that `lookup` waits for a transform that has not come yet.

    Attributes
    ----------
    available : bool
        Whether tf2_msgs is there.
    """

    def __init__(self, node: Node, *, wait_s: float = WAIT_S) -> None:
        self._node, self._wait_s = node, wait_s
        self._tree = TransformTree(span_ns=SPAN_NS)
        self._decoder = Decoder()
        self._news = threading.Condition()
        self._closed = False
        self._in_vain: set[tuple[str, str]] = set()
        self._bad = 0
        self._subscriptions: list[Any] = []
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            self.available = False
            node.get_logger().warning(
                'tf2_msgs is not installed: /tf and /tf_static are not listened to')
            return
        self.available = True
        # Of its own: an event that is destroyed while the executor takes it locks its group.
        group = MutuallyExclusiveCallbackGroup()
        for topic, durability in (
            ('/tf', DurabilityPolicy.VOLATILE), ('/tf_static', DurabilityPolicy.TRANSIENT_LOCAL),
        ):
            channel = Channel(topic, KIND, 'cdr')
            self._subscriptions.append(node.create_subscription(
                TFMessage, topic, partial(self._take, channel),
                QoSProfile(depth=DEPTH, durability=durability), callback_group=group,
                raw=True))

    @property
    def kept(self) -> int:
        """Return the number of transforms in memory."""
        with self._news:
            return self._tree.kept

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames heard of."""
        with self._news:
            return self._tree.frames

    def lookup(
        self, target_frame: str, source_frame: str, stamp_ns: int | None = None
    ) -> Floats | None:
        """
        Return T_target_source (4, 4), translation in m, at a time; None where it is not known.

        The transforms of the time itself may still be under way: they are waited for. After a
        wait in vain no more time is lost on that pair of frames, until it is known.

        Parameters
        ----------
        target_frame, source_frame : str
        stamp_ns : int or None
            None takes the latest.
        """
        pair = (target_frame, source_frame)
        deadline = time.monotonic() + self._wait_s
        with self._news:
            while True:
                found = self._tree.lookup(*pair, stamp_ns, beyond_ns=0)
                if found is not None:
                    self._in_vain.discard(pair)
                    return found
                left = deadline - time.monotonic()
                if self._closed or pair in self._in_vain or not self.available or left <= 0:
                    self._in_vain.add(pair)
                    return self._tree.lookup(*pair, stamp_ns)
                self._news.wait(left)

    def close(self) -> None:
        """Listen no more; what waits in `lookup` is answered now."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        while self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop())

    def _take(self, channel: Channel, data: bytes) -> None:
        try:
            found = transforms.decode(self._decoder.decode(RawMessage(channel, 0, data)))
        except InputError as error:
            self._bad += 1
            if self._bad == 1:  # a publisher of nonsense would say it a thousand times a second
                self._node.get_logger().warning(
                    f'{channel.topic}: {error}; such messages are passed by')
            return
        with self._news:
            for item in found:
                self._tree.add(item, static=channel.topic == '/tf_static')
            self._news.notify_all()
