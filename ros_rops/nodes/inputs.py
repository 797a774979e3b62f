# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the node listens to: messages as they stand on the wire, handed on unread."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import partial
import time
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.event_handler import QoSRequestedIncompatibleQoSInfo, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy, qos_policy_name_from_kind, QoSPolicyKind, QoSProfile, ReliabilityPolicy)
from ros_rops.core.groups_node import InputConfig
from ros_rops.core.node_config import NodeConfig
from ros_rops.live.health import Inlet
from ros_rops.live.losses import Losses
from ros_rops.recordings.live_frames import COLOR_TOPIC, DEPTH_TOPIC, INFO_TOPIC, VIEWS_TOPIC
from ros_rops.recordings.messages import Channel, RawMessage
from ros_rops.recordings.topics import is_rectified
from ros_rops.recordings.view_facts import FACTS_TOPIC
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import String

Offer = Callable[[RawMessage], None]
Lose = Callable[[str, int], None]
FACTS_DEPTH = 100
KEPT = 1000
"""The times of so many callbacks of a topic are remembered."""
OPTIONAL = (COLOR_TOPIC, FACTS_TOPIC)
"""Nobody needs to publish these."""
ADVICE = (
    'DDS loses most large clouds sent best effort: let the driver publish reliable, or give Fast '
    'DDS a larger shared-memory segment')


class Inputs:
    """
    Subscriptions to the topics of one kind of input; `close` ends them.

    Parameters
    ----------
    node : Node
    config : InputConfig
    offer : callable
        Is given every message; returns at once and raises nothing.
    lose : callable
        Is told a topic, and how many more of its messages never came.
    """

    def __init__(self, node: Node, config: InputConfig, offer: Offer, lose: Lose) -> None:
        # The executor takes what waits in this order: what belongs to a frame before the frame,
        # however late both are taken.
        self._inputs = [
            _Input(node, own, offer, lose, Channel(topic, name, 'cdr'), kind)
            for own, topic, name, kind in _topics(config)]

    def close(self) -> None:
        """Listen no more."""
        for item in self._inputs:
            item.close()

    @property
    def callback_p99_ms(self) -> float:
        """All but one in a hundred of the last callbacks took less; 0 without any."""
        seconds = sorted(span for item in self._inputs for span in item.callbacks_s.copy())
        return 1e3 * seconds[int(0.99 * (len(seconds) - 1))] if seconds else 0.0

    def inlets(self) -> list[Inlet]:
        """Return how each topic is listened to, and what is wrong with it."""
        return [item.inlet() for item in self._inputs]


def with_lens(node: Node, config: NodeConfig) -> NodeConfig:
    """Return the parameters, `input.lens` taken from the name that depth/image is remapped to."""
    if config.input.lens != 'auto':
        return config
    lens = 'rectified' if is_rectified(node.resolve_topic_name(DEPTH_TOPIC)) else 'raw'
    return replace(config, input=replace(config.input, lens=lens))


def _topics(config: InputConfig) -> list[tuple[InputConfig, str, str, type]]:
    if config.kind == 'cloud':
        facts = InputConfig(reliability='reliable', depth=FACTS_DEPTH)
        return [(facts, FACTS_TOPIC, 'std_msgs/msg/String', String),
                (config, VIEWS_TOPIC, 'sensor_msgs/msg/PointCloud2', PointCloud2)]
    image = 'sensor_msgs/msg/Image'
    color = [(config, COLOR_TOPIC, image, Image)] if config.color else []
    return [(config, INFO_TOPIC, 'sensor_msgs/msg/CameraInfo', CameraInfo), *color,
            (config, DEPTH_TOPIC, image, Image)]


class _Input:
    """One topic, and what becomes of publishers that offer less than is asked for."""

    def __init__(
        self, node: Node, config: InputConfig, offer: Offer, lose: Lose, channel: Channel,
        kind: type,
    ) -> None:
        self._node, self._config, self._offer, self._lose = node, config, offer, lose
        self._channel, self._kind = channel, kind
        # Of its own: an event that is destroyed while the executor takes it locks its group.
        self._group = MutuallyExclusiveCallbackGroup()
        self._closed = False
        self._fault = ''
        self.callbacks_s: deque[float] = deque(maxlen=KEPT)
        self._best_effort = config.reliability == 'best_effort'
        self._subscription = self._subscribe()

    @property
    def topic(self) -> str:
        """Return the topic's whole name."""
        return str(self._subscription.topic_name)

    def inlet(self) -> Inlet:
        """Return how the topic is listened to, and what is known of its publishers."""
        how = 'best effort' if self._best_effort else 'reliable'
        publishers = self._node.count_publishers(self.topic)
        return Inlet(
            self.topic, publishers, how, self._fault if publishers else '',
            needed=self._channel.topic not in OPTIONAL)

    def close(self) -> None:
        self._closed = True
        self._node.destroy_subscription(self._subscription)

    def _subscribe(self) -> Any:
        config = self._config
        losses = Losses(self._only_publisher)
        profile = QoSProfile(
            depth=config.depth,
            reliability=(ReliabilityPolicy.BEST_EFFORT if self._best_effort
                         else ReliabilityPolicy.RELIABLE),
            durability=(DurabilityPolicy.TRANSIENT_LOCAL if config.durability == 'transient_local'
                        else DurabilityPolicy.VOLATILE))
        return self._node.create_subscription(
            self._kind, self._channel.topic.lstrip('/'), partial(self._take, losses),
            profile, callback_group=self._group, raw=True,
            event_callbacks=SubscriptionEventCallbacks(
                incompatible_qos=self._incompatible,
                message_lost=partial(self._note_lost, losses)))

    def _take(self, losses: Losses, data: bytes, info: dict[str, Any]) -> None:
        began = time.perf_counter()
        self._offer(RawMessage(self._channel, time.time_ns(), data))
        self._tell(losses.take(info['publication_sequence_number']))
        self.callbacks_s.append(time.perf_counter() - began)

    def _note_lost(self, losses: Losses, event: Any) -> None:
        self._tell(losses.note(int(event.total_count)))

    def _tell(self, lost: int) -> None:
        if lost:
            self._lose(self.topic, lost)

    def _only_publisher(self) -> bytes | None:
        found = self._node.get_publishers_info_by_topic(self.topic)
        return bytes(found[0].endpoint_gid) if len(found) == 1 else None

    def _incompatible(self, event: QoSRequestedIncompatibleQoSInfo) -> None:
        policy = event.last_policy_kind
        say = self._node.get_logger()
        if self._closed:
            return
        if policy != QoSPolicyKind.RELIABILITY or self._config.reliability != 'auto':
            self._fault = (
                f'{self.topic}: a publisher is not heard, since it {self._remedy(policy)}')
            say.error(self._fault)
        elif not self._best_effort:
            say.warning(f'{self.topic}: a publisher offers best effort only, which is taken now. '
                        f'{ADVICE}')
            self._best_effort = True
            old, self._subscription = self._subscription, self._subscribe()
            self._node.destroy_subscription(old)

    def _remedy(self, policy: int) -> str:
        if policy == QoSPolicyKind.RELIABILITY:
            return ('offers best effort where reliable is asked for; set input.reliability to '
                    f'auto or best_effort. {ADVICE}')
        if policy == QoSPolicyKind.DURABILITY:
            return ('offers volatile where transient_local is asked for; set input.durability '
                    'to volatile')
        return f'offers less than is asked for ({qos_policy_name_from_kind(policy)})'
