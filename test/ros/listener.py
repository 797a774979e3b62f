# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A real node that keeps what it is sent and, as a station does, says that it has handled it."""

from collections.abc import Callable, Sequence
from functools import partial
import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import NodeProcess, ros_arguments
from ros_rops.recordings.messages import Channel, Decoder, header, RawMessage
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

CLOUD, IMAGE, INFO, TEXT = (
    'sensor_msgs/msg/PointCloud2', 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CameraInfo',
    'std_msgs/msg/String')
TOPICS = {
    'views': (PointCloud2, CLOUD), 'depth/image': (Image, IMAGE),
    'depth/camera_info': (CameraInfo, INFO), 'color/image': (Image, IMAGE),
    'view_facts': (String, TEXT)}
PATIENCE_S = 60.0
"""For what takes less than a second on an idle machine."""


def replay(namespace: str, *, code: int = 0, **parameters: object) -> NodeProcess:
    """Start the replay node, which is to end with an exit code."""
    return NodeProcess(
        'replay_node', ros_arguments(parameters, {'__ns': namespace}), expected=(code,))


class Listener:
    """
    Keeps every message as (topic, bytes), and answers frames and facts on `handled`.

    Use as a context.
    """

    def __init__(
        self, namespace: str, topics: Sequence[str] = ('views', 'view_facts'), *,
        answers: bool = True, others: dict[str, type] | None = None,
    ) -> None:
        self.messages: list[tuple[str, bytes]] = []
        self.arrived: list[float] = []
        self.called: list[str] = []
        self._context = rclpy.Context()
        self._context.init()
        self.node = rclpy.create_node('listener', namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._decoder = Decoder()
        self._handled = self.node.create_publisher(Header, 'handled', 100) if answers else None
        for topic in topics:
            self._listen(topic, *TOPICS[topic])
        for topic, kind in (others or {}).items():
            latched = topic.endswith('static')
            self.node.create_subscription(
                kind, topic, partial(self._keep, topic), QoSProfile(
                    depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL
                    if latched else DurabilityPolicy.VOLATILE), raw=True)

    def __enter__(self) -> 'Listener':
        return self

    def __exit__(self, *error: object) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    def serve(self, name: str, *, success: bool = True) -> None:
        """Offer a service of the station."""
        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            self.called.append(name)
            response.success, response.message = success, f'{name} done'
            return response

        self.node.create_service(Trigger, f'rops_registration/{name}', answer)

    def until(self, ready: Callable[[], bool]) -> bool:
        """Let callbacks run until something is so; tell whether it became so in good time."""
        deadline = time.monotonic() + PATIENCE_S
        while not ready() and time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.02)
        return ready()

    def until_end_of(self, process: NodeProcess) -> str:
        """Let callbacks run until a process has ended, and return what it said."""
        assert self.until(lambda: process.code is not None)
        process.wait()
        return process.output

    def on(self, topic: str) -> list[bytes]:
        """Return the messages of a topic."""
        return [data for name, data in self.messages if name == topic]

    def _keep(self, topic: str, data: bytes) -> None:
        self.messages.append((topic, data))
        self.arrived.append(time.monotonic())

    def _listen(self, topic: str, kind: type, name: str) -> None:
        channel = Channel(topic, name, 'cdr')

        def hear(data: bytes) -> None:
            self._keep(topic, data)
            if self._handled is not None and topic in ('views', 'depth/image', 'view_facts'):
                self._handled.publish(self._word(channel, data))

        self.node.create_subscription(kind, topic, hear, 100, raw=True)

    def _word(self, channel: Channel, data: bytes) -> Header:
        if channel.kind == TEXT:
            return Header(frame_id='view_facts')
        stamp_ns, frame_id = header(self._decoder.decode(RawMessage(channel, 0, data)))
        word = Header(frame_id=frame_id)
        word.stamp.sec, word.stamp.nanosec = divmod(stamp_ns, 1_000_000_000)
        return word
