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
        # One for each publisher, held while sending, so that it is not taken away under it.
        # A large cloud takes a while, and nothing else must wait for that.
        self._locks: dict[Publisher, threading.Lock] = {}
        self._making = threading.Lock()
        self._closed = False

    def publisher(
        self, kind: type, topic: str, qos: QoSProfile | int = LATCHED
    ) -> Publisher | None:
        """
        Make a publisher; None when closed, or when ROS was shut down meanwhile.

        `topic` is relative to the node's namespace, or begins with '/'.
        """
        with self._making, self._going_down():
            if not self._closed:
                found = self._node.create_publisher(kind, topic, qos, event_callbacks=NO_EVENTS)
                self._locks[found] = threading.Lock()
                return found
        return None

    def send(self, publisher: Publisher | None, message: Any) -> None:
        """Send a message; nothing when closed, or when ROS was shut down meanwhile."""
        lock = self._locks.get(publisher) if publisher is not None else None
        if lock is None:
            return
        with lock, self._going_down():
            if publisher in self._locks:
                publisher.publish(message)

    def remove(self, publisher: Publisher | None) -> None:
        """Take a publisher away, and what it latched with it."""
        lock = self._locks.get(publisher) if publisher is not None else None
        if lock is None:
            return
        with lock:
            if self._locks.pop(publisher, None) is not None:
                self._node.destroy_publisher(publisher)

    def close(self) -> None:
        """Take all publishers away; what is sent later goes nowhere."""
        with self._making:
            self._closed = True
        for publisher in list(self._locks):
            self.remove(publisher)

    @contextmanager
    def _going_down(self) -> Iterator[None]:
        """Let errors go by that come of ROS having been shut down."""
        try:
            yield
        except Exception:
            if self._node.context.ok():
                raise
