# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the replay publishes on, and the waiting for those who listen."""

from collections.abc import Callable, Iterable
import time
from typing import Any

from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_rops.core.errors import RopsError
from ros_rops.nodes.signals import asked_again as asked_to_end
from ros_rops.recordings.live_frames import (
    COLOR_TOPIC, DEPTH_TOPIC, INFO_TOPIC, VIEWS_TOPIC)
from ros_rops.recordings.playback import Piece, Playback, TF_STATIC_TOPIC, TF_TOPIC
from ros_rops.recordings.view_facts import FACTS_TOPIC
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import String

SMALL_DEPTH, LARGE_DEPTH = 100, 10
"""Messages that the middleware keeps for slow listeners: of a hundred bytes, of megabytes."""
STEP_S = 0.05
ARRIVAL_S = 5.0
"""A listener that is there says so long before."""


class EndedError(RopsError):
    """SIGINT or SIGTERM came."""


class Pump:
    """
    Lets the node's callbacks run while something is waited for.

    Raises
    ------
    EndedError
        By `until` and `sleep`, if the process is asked to end.
    """

    def __init__(self, node: Node, executor: SingleThreadedExecutor) -> None:
        self._executor = executor
        executor.add_node(node)

    def until(
        self, ready: Callable[[], bool], timeout_s: float, step_s: float = STEP_S
    ) -> bool:
        """Return whether `ready` came true in time; it is asked after every callback and step."""
        deadline = time.monotonic() + timeout_s
        while not ready():
            left = deadline - time.monotonic()
            if left <= 0:
                return False
            self._executor.spin_once(timeout_sec=min(left, step_s))
            if asked_to_end():
                raise EndedError('asked to end')
        return True

    def sleep(self, seconds: float) -> None:
        """Let callbacks run for some time."""
        self.until(lambda: False, seconds)


class Outlets:
    """
    A publisher for each topic of a recording.

    Parameters
    ----------
    node : Node
    pump : Pump
    playback : Playback
    tf : bool
        Also for its transforms; where tf2_msgs is missing, this is said.
    clock : bool

    Attributes
    ----------
    frames : Publisher
    frames_topic : str
    """

    def __init__(
        self, node: Node, pump: Pump, playback: Playback, *, tf: bool, clock: bool
    ) -> None:
        self._node, self._pump = node, pump
        self._publishers: dict[str, Publisher] = {}
        self._clock = node.create_publisher(Clock, '/clock', 10) if clock else None
        self.frames_topic = VIEWS_TOPIC if playback.kind == 'cloud' else DEPTH_TOPIC
        # In step there is one at a time; of more than one small message Fast DDS asks every 3 s
        # only whether they have arrived.
        small, large = (SMALL_DEPTH, LARGE_DEPTH) if clock else (1, 1)
        if playback.kind == 'cloud':
            self.frames = self._add(VIEWS_TOPIC, PointCloud2, large)
            if playback.facts:
                self._add(FACTS_TOPIC, String, small)
        else:
            self.frames = self._add(DEPTH_TOPIC, Image, large)
            self._add(INFO_TOPIC, CameraInfo, small)
            if playback.color:
                self._add(COLOR_TOPIC, Image, large)
        if tf and playback.has_transforms:
            self._add_transforms()

    def _add(self, topic: str, kind: Any, depth: int, *, latched: bool = False) -> Publisher:
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        name = topic.removeprefix('/') if topic == FACTS_TOPIC else topic
        self._publishers[topic] = self._node.create_publisher(
            kind, name, QoSProfile(depth=depth, durability=durability))
        return self._publishers[topic]

    def _add_transforms(self) -> None:
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            self._node.get_logger().warning(
                'tf2_msgs is not installed: the transforms of the recording are not sent')
            return
        self._add(TF_TOPIC, TFMessage, SMALL_DEPTH)
        self._add(TF_STATIC_TOPIC, TFMessage, SMALL_DEPTH, latched=True)

    def has(self, topic: str) -> bool:
        """Return whether there is such a topic."""
        return topic in self._publishers

    def heard(self, topic: str) -> bool:
        """Return whether somebody listens to it."""
        publisher = self._publishers.get(topic)
        return publisher is not None and publisher.get_subscription_count() > 0

    def send(self, piece: Piece) -> None:
        """Publish a message as it is."""
        self._publishers[piece.topic].publish(piece.data)

    def send_static(self, playback: Playback) -> None:
        """Publish the transforms that do not change; late joiners see them too."""
        if self.has(TF_STATIC_TOPIC):
            for piece in playback.static_transforms():
                if not piece.fault:
                    self.send(piece)

    def tell_time(self, time_ns: int) -> None:
        """Publish a time on /clock, if this is played by the clock."""
        if self._clock is not None:
            message = Clock()
            message.clock.sec, message.clock.nanosec = divmod(max(time_ns, 0), 1_000_000_000)
            self._clock.publish(message)

    def wait_for_listeners(self, timeout_s: float, grace_s: float = 3.0) -> bool:
        """
        Wait until somebody listens to what makes frames.

        Those of the other topics are matched soon after if there are any: that is waited for too,
        but not for long.
        """
        needed = [t for t in (VIEWS_TOPIC, DEPTH_TOPIC, INFO_TOPIC) if t in self._publishers]
        if not self._pump.until(lambda: all(map(self.heard, needed)), timeout_s):
            return False
        self._pump.until(lambda: all(map(self.heard, self._publishers)), grace_s)
        return True

    def wait_for_arrival(self, topics: Iterable[str] | None = None) -> None:
        """Wait until what was sent on some topics, by default on all, has arrived."""
        for topic in self._publishers if topics is None else topics:
            publisher = self._publishers[topic]
            self._pump.until(
                lambda one=publisher: one.wait_for_all_acked(Duration()), ARRIVAL_S, 0.001)
