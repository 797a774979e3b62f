# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Publishers of one owner: sending from any thread, also while the node goes down."""

from collections.abc import Iterator
from contextlib import contextmanager
import threading
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Reliable; who comes late gets the last message."""
NO_EVENTS = PublisherEventCallbacks(use_default_callbacks=False)
"""No handlers of events: an executor that waits for one while it is destroyed fails (rclpy 7)."""


class Wire:
    """
    Make publishers of a node, send on them, and take them away.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        # Held while sending, so that no publisher is taken away under it.
        self._lock = threading.Lock()
        self._publishers: list[Publisher] = []
        self._closed = False

    def publisher(
        self, kind: type, topic: str, qos: QoSProfile | int = LATCHED
    ) -> Publisher | None:
        """
        Make a publisher; None when closed, or when ROS was shut down meanwhile.

        `topic` is relative to the node's namespace, or begins with '/'.
        """
        with self._lock, self._going_down():
            if not self._closed:
                found = self._node.create_publisher(kind, topic, qos, event_callbacks=NO_EVENTS)
                self._publishers.append(found)
                return found
        return None

    def send(self, publisher: Publisher | None, message: Any) -> None:
        """Send a message; nothing when closed, or when ROS was shut down meanwhile."""
        with self._lock, self._going_down():
            if publisher in self._publishers:
                publisher.publish(message)

    def remove(self, publisher: Publisher | None) -> None:
        """Take a publisher away, and what it latched with it."""
        with self._lock:
            if publisher in self._publishers:
                self._publishers.remove(publisher)
                self._node.destroy_publisher(publisher)

    def close(self) -> None:
        """Take all publishers away; what is sent later goes nowhere."""
        with self._lock:
            self._closed = True
            while self._publishers:
                self._node.destroy_publisher(self._publishers.pop())

    @contextmanager
    def _going_down(self) -> Iterator[None]:
        """Let errors go by that come of ROS having been shut down."""
        try:
            yield
        except Exception:
            if self._node.context.ok():
                raise
