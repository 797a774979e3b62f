# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The outputs of a node in this process, and a client beside them."""

from contextlib import contextmanager
from types import SimpleNamespace

import rclpy
from rclpy.node import Node
from reference.updates import Station
from ros.harness import Client, wait_for
from ros_rops.core.groups_node import PublishConfig
from ros_rops.core.node_config import NodeConfig
from ros_rops.nodes.outputs import Outputs

ALL = PublishConfig(spacing_mr=0.0)


@contextmanager
def outputs(namespace='', publish=ALL, fixed_frame='', **more):
    """Yield the outputs of a node, with the node as `node`, and a client beside it."""
    context = rclpy.Context()
    context.init()
    node = Node('rops_registration', namespace=namespace, context=context, **more)
    found = Outputs(node, NodeConfig(publish=publish), fixed_frame=fixed_frame)
    try:
        with Client(namespace=namespace) as client:
            client.collect = _known_to_writers(client.collect, node)
            yield SimpleNamespace(out=found, node=node, client=client)
    finally:
        found.close()
        node.destroy_node()
        context.try_shutdown()


def _known_to_writers(collect, node):
    """Wait for the writer, too: what it says before it knows a reader is lost to that one."""
    def collect_matched(kind, topic, *given, **more):
        found = collect(kind, topic, *given, **more)
        wait_for(
            lambda: any(
                one.get_subscription_count() for one in node.publishers
                if one.topic_name.endswith(topic)), f'{topic} knows its reader')
        return found

    return collect_matched


def two_objects(**given):
    station = Station(**given)
    for name, object_id in (('a', 1), ('b', 2), ('c', 1), ('d', 2), ('e', 1)):
        station.see(name, object_id)
    return station


def last(found, count=1):
    return wait_for(lambda: len(found) >= count and found[-1], f'{count} messages')
