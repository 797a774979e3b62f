# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The parameters that only the station's node has, beside those of `ros_rops.core.config`.

Both stand in one parameter file: the node reads all of it, `rops` what is the engine's.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ros_rops.core.groups_node import InputConfig, NodeGroup, OutputConfig, PublishConfig
from ros_rops.core.parameter import (
    describe_groups, ParameterInfo, Scalar, values_of, with_values)

BARE = 'node'
"""The group whose parameters have no group in their names."""


@dataclass(frozen=True, slots=True)
class NodeConfig:
    """All parameters of the node, by group; those of `node` have no group in their names."""

    node: NodeGroup = NodeGroup()
    input: InputConfig = InputConfig()  # noqa: A003
    publish: PublishConfig = PublishConfig()
    output: OutputConfig = OutputConfig()

    @classmethod
    def from_flat(cls, values: Mapping[str, object]) -> 'NodeConfig':
        """
        Make a configuration from names such as ``input.kind``, the rest at their defaults.

        Raises
        ------
        ParameterError
            For an unknown name, a wrong type or a value out of bounds.
        """
        config: NodeConfig = with_values(cls(), values, BARE)
        return config

    def to_flat(self) -> dict[str, Scalar]:
        """Return all values by name, in the order of declaration."""
        return values_of(self, BARE)


def describe_node() -> Iterator[ParameterInfo]:
    """Yield every parameter of the node by name, in the order of declaration."""
    yield from describe_groups(NodeConfig, BARE)
