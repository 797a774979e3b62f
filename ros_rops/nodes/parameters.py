# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the node: declared from the dataclasses, checked by them, some of them live."""

from collections.abc import Callable
from itertools import chain
import threading

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from ros_rops.core.config import Config, describe
from ros_rops.core.errors import ParameterError
from ros_rops.core.node_config import describe_node, NodeConfig
from ros_rops.modelling.libraries import check_libraries
from ros_rops.nodes.declaring import declare, given_values
from ros_rops.pipeline.parameters import configs_of

Configs = tuple[Config, NodeConfig]

LIVE = ('selection.', 'segmentation.', 'model.')
"""What stands behind these may change while the node is configured."""
LIVE_NAMES = frozenset({'publish.tf_rate_hz', 'publish.skipped'})
AT_START = 'autostart'


class Settings:
    """
    The node's parameters.

    Parameters
    ----------
    node : Node
        Made with `automatically_declare_parameters_from_overrides`, so that what it was started
        with is there to be checked.
    changed : callable
        Is given the new values when live ones have changed while they are fixed.

    Raises
    ------
    ParameterError
        If the node was started with values that cannot be.
    """

    def __init__(self, node: Node, changed: Callable[[Config, NodeConfig], None]) -> None:
        self._node, self._changed = node, changed
        self._lock = threading.RLock()
        self._fixed = False
        self._names = _declare(node)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._apply)

    def fix(self) -> Configs:
        """Return the values; from now on only live ones may change."""
        with self._lock:
            self._fixed = True
            return self.read()

    def free(self) -> None:
        """Let all values change again."""
        with self._lock:
            self._fixed = False

    def read(self) -> Configs:
        """Return the values as they stand."""
        return configs_of({name: self._node.get_parameter(name).value for name in self._names})

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        with self._lock:
            try:
                self._judge({item.name: item.value for item in parameters
                             if item.name in self._names})
            except ParameterError as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _judge(self, given: dict[str, object]) -> None:
        check_libraries(configs_of(given)[0].model)
        for name in given:
            if self._fixed and not _live(name) and given[name] != self._value(name):
                raise ParameterError(
                    f'{name}: cannot change while the node is configured; deactivate and clean '
                    'it up, set it, then configure it again (or set it in the parameter file)')

    def _value(self, name: str) -> object:
        return self._node.get_parameter(name).value

    def _apply(self, parameters: list[Parameter]) -> None:
        with self._lock:
            if self._fixed and any(_live(item.name) for item in parameters):
                self._changed(*self.read())


def _live(name: str) -> bool:
    return name.startswith(LIVE) or name in LIVE_NAMES


def _declare(node: Node) -> frozenset[str]:
    """Declare all parameters with the values that the node was started with, if it was."""
    infos = list(chain(describe_node(), describe()))
    engine, own = configs_of(given_values(node, infos))
    check_libraries(engine.model)
    declare(node, infos, {**own.to_flat(), **engine.to_flat()}, read_only=(AT_START,))
    return frozenset(info.name for info in infos)
