# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The node's health while it has no session, and so nothing else that tells of it."""

from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from msg_adapters import diagnostics
from msg_adapters.diagnostics import Health, Level
from rclpy.node import Node


class IdleHealth:
    """
    Publishes on `/diagnostics` that the node has no session.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)

    def publish(self, lifecycle: str, values: Mapping[str, str | float]) -> None:
        """Publish the state, and why there is no session if that is known."""
        failure = values.get('last failure')
        health = Health(
            f'{self._node.get_name()}: state', Level.ERROR if failure else Level.WARN,
            f'{lifecycle}: {failure or "no session"}', dict(values),
            self._node.get_fully_qualified_name())
        status = DiagnosticStatus()
        diagnostics.fill(status, KeyValue, health)
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
