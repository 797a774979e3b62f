# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The words that go out: on views and frames, on messages handled, on the node's health."""

from collections.abc import Iterator, Mapping, Sequence
import threading
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from msg_adapters import diagnostics
from msg_adapters.diagnostics import Health
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_rops.intake.reports import Word
from ros_rops.live.health import (
    frame_health, gone_health, Inlet, Lately, station_health, view_health)
from ros_rops.live.places import FrameNames
from ros_rops.live.words import Handled, StationState, Update
from ros_rops.nodes.console import Console
from ros_rops.nodes.wire import Wire
from std_msgs.msg import Header

REPORTS = QoSProfile(depth=200, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Who comes late gets the last words, the oldest first."""
HANDLED = QoSProfile(depth=1000)
SECOND = 1_000_000_000
LATELY_S = 60.0


class ReportsOut:
    """
    Publish `view_reports`, `handled` and `/diagnostics`; log what matters of it.

    Parameters
    ----------
    node : Node
    wire : Wire
    names : FrameNames
    skipped : bool
        Whether frames that were not selected have a report too.
    """

    def __init__(self, node: Node, wire: Wire, names: FrameNames, *, skipped: bool) -> None:
        self._node, self._wire, self._names, self._skipped = node, wire, names, skipped
        self._reports = wire.publisher(DiagnosticStatus, 'view_reports', REPORTS)
        self._handled = wire.publisher(Header, 'handled', HANDLED)
        self._health = wire.publisher(DiagnosticArray, '/diagnostics', 10)
        self._console = Console(node)
        self._frames: dict[str, str] = {}
        self._epoch = 0
        self._lock = threading.Lock()
        self._longest_s = 0.0
        self._dropped, self._failed, self._lost = _Growth(), _Growth(), _Growth()

    def tell_skipped(self, on: bool) -> None:
        """Report frames that were not selected too, or no longer."""
        self._skipped = on

    def publish(self, update: Update) -> None:
        """Publish the words that changed; of views that are gone, that."""
        for health in self._changes(update):
            self._send_report(health)
            self._console.view(health)

    def handled(self, handled: Handled) -> None:
        """Publish that a message has its word, and the word if it gave no view."""
        report = handled.report
        with self._lock:
            self._longest_s = max(self._longest_s, handled.waited_s)
        wanted = report is not None and report.word is not Word.TAKEN and (
            self._skipped or report.word is not Word.SKIPPED)
        if report is not None and wanted:
            health = frame_health(report, handled.frame_id)
            self._send_report(health)
            self._console.frame(health)
        header = Header(frame_id=handled.frame_id)
        header.stamp.sec, header.stamp.nanosec = (
            int(part) for part in divmod(handled.stamp_ns, SECOND))
        self._wire.send(self._handled, header)

    def diagnostics(
        self, state: StationState, lifecycle: str, inlets: Sequence[Inlet],
        values: Mapping[str, str | float],
    ) -> None:
        """Publish how the node stands."""
        with self._lock:
            lately = Lately(
                self._dropped.lately(state.dropped), self._failed.lately(state.errors),
                self._lost.lately(sum(state.lost.values())), self._longest_s)
        parts = tuple(station_health(state, lifecycle, inlets, lately, values))
        self._console.station(parts, state)
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [
            self._status(health, f'{self._node.get_name()}: {health.name}',
                         self._node.get_fully_qualified_name())
            for health in parts]
        self._wire.send(self._health, message)

    def _changes(self, update: Update) -> Iterator[Health]:
        if update.epoch != self._epoch:
            self._frames, self._epoch = {}, update.epoch
            with self._lock:
                self._longest_s = 0.0
        for name in [name for name in self._frames if name not in update.views]:
            yield gone_health(name, self._frames.pop(name))
        for report in update.changed:
            if report.name in update.views:
                frame_id = self._names.of_sensor(update.views[report.name])
                self._frames[report.name] = frame_id
                yield view_health(report, frame_id, update.numbers[report.name])

    def _send_report(self, health: Health) -> None:
        self._wire.send(self._reports, self._status(health, health.name, health.hardware_id))

    def _status(self, health: Health, name: str, hardware_id: str) -> DiagnosticStatus:
        status = DiagnosticStatus()
        diagnostics.fill(status, KeyValue, health)
        status.name, status.hardware_id = name, hardware_id
        return status


class _Growth:
    """Tells whether a count grew within the last minute."""

    def __init__(self) -> None:
        self._count, self._grew = 0, -LATELY_S

    def lately(self, count: int) -> bool:
        now = time.monotonic()
        if count > self._count:
            self._grew = now
        self._count = count
        return now - self._grew < LATELY_S
