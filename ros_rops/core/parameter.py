# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How a parameter is declared and checked: default, bounds, unit and one sentence."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
import math
from typing import Any

from ros_rops.core.errors import ParameterError

Scalar = bool | int | float | str


@dataclass(frozen=True, slots=True)
class ParameterInfo:
    """Description of one parameter: dotted `name`, `default`, bounds, unit, text."""

    name: str
    default: Scalar
    description: str
    unit: str
    low: float | None
    high: float | None
    choices: tuple[str, ...]


def param(
    default: Scalar,
    description: str,
    *,
    unit: str = '',
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """Declare one parameter of a group."""
    return field(
        default=default,
        metadata={
            'description': description,
            'unit': unit,
            'low': low,
            'high': high,
            'choices': choices,
        },
    )


def _check(info: ParameterInfo, value: object) -> Scalar:
    kind = type(info.default)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type(value) is not kind:
        raise ParameterError(f'{info.name}: expected {kind.__name__}, got {value!r}')
    if isinstance(value, str) and info.choices and value not in info.choices:
        raise ParameterError(f'{info.name}: {value!r} is none of {", ".join(info.choices)}')
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if not math.isfinite(value):
            raise ParameterError(f'{info.name}: must be finite, got {value!r}')
        if info.low is not None and value < info.low:
            raise ParameterError(f'{info.name}: {value!r} is below {info.low}')
        if info.high is not None and value > info.high:
            raise ParameterError(f'{info.name}: {value!r} is above {info.high}')
    return value


class Group:
    """A group of parameters; values are checked when it is made."""

    def __post_init__(self) -> None:
        """Check every value against its declaration."""
        for info in describe_group(type(self)):
            object.__setattr__(self, info.name, _check(info, getattr(self, info.name)))


def describe_group(group: type, prefix: str = '') -> Iterator[ParameterInfo]:
    """Yield the parameters of a group class, their names behind `prefix`."""
    for item in fields(group):
        default: Any = item.default
        yield ParameterInfo(name=prefix + item.name, default=default, **item.metadata)
