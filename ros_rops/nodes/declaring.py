# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""From the dataclasses' parameters to those of a ROS node, and what it was started with."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from difflib import get_close_matches
import sys

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from ros_rops.core.parameter import ParameterInfo, Scalar

OF_ROS = ('use_sim_time', 'start_type_description_service', 'qos_overrides')
"""What rclpy declares by itself."""
LARGEST_INT = 2**63 - 1


def given_values(node: Node, infos: Sequence[ParameterInfo]) -> dict[str, object]:
    """
    Return the values that a node was started with, unchecked; names that are none are told of.

    Parameters
    ----------
    node : Node
        Made with `automatically_declare_parameters_from_overrides`, so that they are there.
    infos : sequence of ParameterInfo
        All parameters that the node has.
    """
    names = frozenset(info.name for info in infos)
    given = dict(_overrides(node))
    for name in sorted(given.keys() - names):
        near = get_close_matches(name, names, 1)
        node.get_logger().warning(
            f'{name}: no such parameter' + (f'; did you mean {near[0]}?' if near else ''))
    return {name: given[name] for name in given.keys() & names}


def declare(
    node: Node, infos: Sequence[ParameterInfo], values: Mapping[str, Scalar], *,
    read_only: Collection[str] = (),
) -> None:
    """Declare parameters with their values."""
    node.declare_parameters(
        '', [(info.name, values[info.name], _descriptor(info, info.name in read_only))
             for info in infos], ignore_override=True)


def _overrides(node: Node) -> Iterator[tuple[str, object]]:
    """Yield what the node was started with, and take it back: it has no descriptions yet."""
    for name, parameter in node.get_parameters_by_prefix('').items():
        if name.partition('.')[0] not in OF_ROS:
            yield name, parameter.value
            node.undeclare_parameter(name)


def _descriptor(info: ParameterInfo, read_only: bool) -> ParameterDescriptor:
    text = f'{info.description} Unit: {info.unit}.' if info.unit else info.description
    found = ParameterDescriptor(
        name=info.name, description=text, read_only=read_only,
        additional_constraints=f'one of: {", ".join(info.choices)}' if info.choices else '')
    if info.low is None and info.high is None:
        return found
    if isinstance(info.default, float):
        most = sys.float_info.max
        found.floating_point_range = [FloatingPointRange(
            from_value=float(-most if info.low is None else info.low),
            to_value=float(most if info.high is None else info.high))]
    else:
        found.integer_range = [IntegerRange(
            from_value=int(-LARGEST_INT if info.low is None else info.low),
            to_value=int(LARGEST_INT if info.high is None else info.high))]
    return found
