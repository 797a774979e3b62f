# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a node by its parameter services, as `ros2 param` has them."""

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import parameter_value_to_python
from ros.harness import Client, NODE

KINDS = {
    bool: ParameterType.PARAMETER_BOOL, int: ParameterType.PARAMETER_INTEGER,
    float: ParameterType.PARAMETER_DOUBLE, str: ParameterType.PARAMETER_STRING}
FIELDS = {bool: 'bool_value', int: 'integer_value', float: 'double_value', str: 'string_value'}


def message_of(name: str, value: object) -> Parameter:
    kind = type(value)
    return Parameter(name=name, value=ParameterValue(type=KINDS[kind], **{FIELDS[kind]: value}))


def set_values(client: Client, **values: object) -> list[tuple[bool, str]]:
    """Set parameters one after the other; names have __ for their dots."""
    request = SetParameters.Request(
        parameters=[message_of(name.replace('__', '.'), value) for name, value in values.items()])
    answer = client.call(SetParameters, f'{NODE}/set_parameters', request)
    return [(result.successful, result.reason) for result in answer.results]


def get_values(client: Client, *names: str) -> list[object]:
    answer = client.call(
        GetParameters, f'{NODE}/get_parameters', GetParameters.Request(names=names))
    return [parameter_value_to_python(value) for value in answer.values]


def names_of(client: Client) -> list[str]:
    return sorted(client.call(ListParameters, f'{NODE}/list_parameters').result.names)
