# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The replay's parameters, declared from their dataclass."""

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from ros_rops.core.groups_replay import ReplayConfig
from ros_rops.core.parameter import describe_group, ParameterInfo
from ros_rops.pipeline.parameters import bounds_text


def declare_replay(node: Node) -> ReplayConfig:
    """
    Declare the parameters and return their values.

    Raises
    ------
    ParameterError
        If a value is of a wrong type or out of bounds.
    """
    values = {
        info.name: node.declare_parameter(info.name, info.default, _descriptor(info)).value
        for info in describe_group(ReplayConfig)}
    return ReplayConfig(**values)


def _descriptor(info: ParameterInfo) -> ParameterDescriptor:
    # The dataclass checks type and bounds: it takes `rate:=2` for 2.0, and says what is wrong.
    return ParameterDescriptor(
        description=info.description, read_only=True, dynamic_typing=True,
        additional_constraints=', '.join(
            text for text in (info.unit, bounds_text(info)) if text))
