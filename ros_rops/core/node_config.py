# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The parameters that only the station's node has, beside those of `ros_rops.core.config`.

Both stand in one parameter file: the node reads all of it, `rops` what is the engine's.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace

from ros_rops.core.errors import ParameterError
from ros_rops.core.groups_node import InputConfig, NodeGroup, OutputConfig, PublishConfig
from ros_rops.core.parameter import describe_group, ParameterInfo, Scalar


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
        known = {info.name for info in describe_node()}
        groups: dict[str, dict[str, object]] = {}
        for name, value in values.items():
            if name not in known:
                raise ParameterError(f'{name}: no such parameter')
            group, _, leaf = name.rpartition('.')
            groups.setdefault(group or 'node', {})[leaf] = value
        config = cls()
        for group, items in groups.items():
            try:
                part = replace(getattr(config, group), **items)
            except ParameterError as error:
                raise ParameterError(f'{_prefix(group)}{error}') from None
            config = replace(config, **{group: part})
        return config

    def to_flat(self) -> dict[str, Scalar]:
        """Return all values by name, in the order of declaration."""
        return {
            f'{_prefix(group.name)}{item.name}': getattr(getattr(self, group.name), item.name)
            for group in fields(self)
            for item in fields(getattr(self, group.name))
        }


def describe_node() -> Iterator[ParameterInfo]:
    """Yield every parameter of the node by name, in the order of declaration."""
    for group in fields(NodeConfig):
        yield from describe_group(type(group.default), _prefix(group.name))


def _prefix(group: str) -> str:
    return '' if group == 'node' else group + '.'
