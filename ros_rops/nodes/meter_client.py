# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What stands beside the registration node while it is measured: sensor, screen and PLC in one."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import struct
import threading
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.srv import GetState
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_rops.nodes.meter_process import NAMESPACE
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from std_srvs.srv import SetBool

NODE = f'{NAMESPACE}/rops_registration'
RELIABLE = QoSProfile(depth=200, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STEP_S = 0.002
STATUS_NAMES = ('placed', 'pending', 'ambiguous', 'refused')


class MeterClient:
    """Publishes clouds, listens, calls services; use as a context."""

    def __enter__(self) -> 'MeterClient':
        """Join the network."""
        self._context = rclpy.Context()
        self._context.init()
        self._node = Node('meter', namespace=NAMESPACE, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._sent_at: dict[int, float] = {}
        self._done_at: dict[int, float] = {}
        self._assembled: list[float] = []
        self._words: dict[str, str] = {}
        self._last_word = 0.0
        self.answers: list[float] = []
        self.diagnostics: dict[str, str] = {}
        self._make_entities()
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()
        return self

    def _make_entities(self) -> None:
        node = self._node
        self._views = node.create_publisher(PointCloud2, 'views', RELIABLE)
        node.create_subscription(PointCloud2, 'assembled', self._on_assembled, LATCHED, raw=True)
        node.create_subscription(Header, 'handled', self._on_handled, RELIABLE)
        node.create_subscription(DiagnosticStatus, 'view_reports', self._on_report, RELIABLE)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self._get_state = node.create_client(GetState, f'{NODE}/get_state')
        self._services = {'pause': node.create_client(SetBool, f'{NODE}/pause')}

    def __exit__(self, *error: object) -> None:
        """Leave the network."""
        self._executor.shutdown()
        self._context.try_shutdown()
        self._thread.join()
        self._node.destroy_node()

    def wait_active(self, patience_s: float) -> None:
        """Wait until the node says that it is active."""
        self._wait(self._is_active, patience_s, 'the node did not become active')

    def wait_matched(self, patience_s: float) -> None:
        """Wait until the node listens, and is listened to."""
        self._wait(
            lambda: self._views.get_subscription_count() > 0
            and self._node.count_publishers('handled') > 0
            and self._node.count_publishers('assembled') > 0, patience_s,
            'the node does not listen')

    def send(self, cloud: bytes) -> int:
        """Publish a cloud, stamped anew; return its stamp."""
        stamp = time.time_ns()
        self._sent_at[stamp] = time.monotonic()
        self._views.publish(_stamped(cloud, stamp))
        return stamp

    def send_and_wait(self, cloud: bytes, patience_s: float) -> dict[str, float]:
        """Publish a cloud; return the seconds until its word, and until a new assembled cloud."""
        before = len(self._assembled)
        stamp = self.send(cloud)
        self._wait(lambda: stamp in self._done_at, patience_s, 'no word on a cloud')
        began = self._sent_at[stamp]
        row = {'handled_s': self._done_at[stamp] - began}
        try:
            self._wait(lambda: len(self._assembled) > before, 1.0, '')
            row['assembled_s'] = self._assembled[before] - began
        except TimeoutError:
            pass  # a view that changed nothing
        return row

    def wait_quiet(self, patience_s: float) -> None:
        """Wait until no word has come for a second."""
        self._wait(lambda: time.monotonic() - self._last_word > 1.0, patience_s, 'no end of words')

    @contextmanager
    def calling(self, name: str, pause_s: float) -> Iterator[None]:
        """Call a service again and again while the context lasts; times go to `answers`."""
        ended = threading.Event()

        def call() -> None:
            while not ended.wait(pause_s):
                began = time.monotonic()
                future = self._services[name].call_async(SetBool.Request(data=False))
                self._wait(future.done, 30.0, f'{name} does not answer')
                self.answers.append(time.monotonic() - began)

        thread = threading.Thread(target=call)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()

    @property
    def sent(self) -> int:
        """Clouds sent so far."""
        return len(self._sent_at)

    @property
    def handled(self) -> int:
        """Clouds that have their word."""
        return len(self._done_at.keys() & self._sent_at.keys())

    def waits(self) -> list[float]:
        """Return the seconds from sending to the word, in the order sent."""
        return [self._done_at[stamp] - began for stamp, began in self._sent_at.items()
                if stamp in self._done_at]

    def statuses(self) -> dict[str, int]:
        """Count the views by their last status."""
        words = list(self._words.values())
        return {name: words.count(name) for name in STATUS_NAMES}

    @staticmethod
    def sleep_until(moment: float) -> None:
        """Sleep until a time of the monotonic clock."""
        time.sleep(max(0.0, moment - time.monotonic()))

    def _is_active(self) -> bool:
        if not self._get_state.service_is_ready():
            return False
        future = self._get_state.call_async(GetState.Request())
        deadline = time.monotonic() + 1.0
        while not future.done() and time.monotonic() < deadline:
            time.sleep(STEP_S)
        answer: Any = future.result() if future.done() else None
        return answer is not None and answer.current_state.label == 'active'

    def _wait(self, condition: Callable[[], bool], patience_s: float, what: str) -> None:
        deadline = time.monotonic() + patience_s
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(what)
            time.sleep(STEP_S)

    def _spin(self) -> None:
        try:
            self._executor.spin()
        except ExternalShutdownException:
            pass

    def _on_assembled(self, data: bytes) -> None:
        self._assembled.append(time.monotonic())

    def _on_handled(self, message: Header) -> None:
        self._last_word = time.monotonic()
        stamp = message.stamp.sec * 1_000_000_000 + message.stamp.nanosec
        self._done_at.setdefault(stamp, self._last_word)

    def _on_report(self, message: DiagnosticStatus) -> None:
        for item in message.values:
            if item.key == 'status':
                self._words[message.name] = item.value

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            for item in status.values:
                self.diagnostics[f'{status.name}: {item.key}'] = item.value


def _stamped(cloud: bytes, stamp_ns: int) -> bytes:
    """Return a message in CDR with another stamp: its first field, behind the encapsulation."""
    order = '<' if cloud[1] & 1 else '>'
    stamp = struct.pack(f'{order}iI', stamp_ns // 1_000_000_000, stamp_ns % 1_000_000_000)
    return cloud[:4] + stamp + cloud[12:]
