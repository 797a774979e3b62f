# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Words on views and on the station to diagnostic_msgs/DiagnosticStatus, by names only."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
import math
from typing import Any


class Level(Enum):
    """How good or bad the news is; the values are DiagnosticStatus's constants."""

    OK = 'OK'
    WARN = 'WARN'
    ERROR = 'ERROR'


@dataclass(frozen=True, slots=True)
class Health:
    """
    A word on something.

    Parameters
    ----------
    name : str
    level : Level
    message : str
        One sentence.
    values : mapping of str to str, int or float
        What it rests on.
    hardware_id : str
    """

    name: str
    level: Level
    message: str
    values: Mapping[str, str | float] = field(default_factory=dict)
    hardware_id: str = ''


def fill(status: Any, make_value: Callable[[], Any], health: Health) -> None:
    """
    Fill a DiagnosticStatus handed in.

    Parameters
    ----------
    status : object
        For example `diagnostic_msgs.msg.DiagnosticStatus()`.
    make_value : callable
        Returns an empty key and value, for example `diagnostic_msgs.msg.KeyValue`.
    health : Health
        Numbers are written with six digits; those that are none, as they are in IEEE 754: nan.
    """
    status.level = getattr(status, health.level.value)
    status.name, status.message = _sendable(health.name), _sendable(health.message)
    status.hardware_id = _sendable(health.hardware_id)
    values = []
    for key, value in health.values.items():
        item = make_value()
        item.key, item.value = _sendable(key), _sendable(text_of(value))
        values.append(item)
    status.values = values


def text_of(value: str | float) -> str:
    """Return a value as a text: whole numbers whole, others with six digits."""
    if isinstance(value, str):
        return value
    if math.isfinite(value) and value == int(value):
        return str(int(value))
    return f'{float(value):.6g}'


def _sendable(text: str) -> str:
    # Names of files may hold bytes that are no UTF-8; ROS would not send the message.
    return text.encode('utf-8', 'replace').decode()
