# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How a parameter is declared and checked: default, bounds, unit and one sentence."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from difflib import get_close_matches
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


def describe_groups(config: Any, bare: str = '') -> Iterator[ParameterInfo]:
    """Yield the parameters of a class of groups, by dotted name but for the group `bare`."""
    for group in fields(config):
        yield from describe_group(type(group.default), prefix_of(group.name, bare))


def with_values(config: Any, values: Mapping[str, object], bare: str = '') -> Any:
    """
    Return a configuration made of groups with other values, given by name.

    Raises
    ------
    ParameterError
        For an unknown name, a wrong type or a value out of bounds.
    """
    known = [info.name for info in describe_groups(config, bare)]
    groups: dict[str, dict[str, object]] = {}
    for name, value in values.items():
        if name not in known:
            near = get_close_matches(name, known, 1)
            hint = f'; did you mean {near[0]}?' if near else ''
            raise ParameterError(f'{name}: no such parameter{hint}')
        group, _, leaf = name.rpartition('.')
        groups.setdefault(group or bare, {})[leaf] = value
    for group, items in groups.items():
        try:
            part = replace(getattr(config, group), **items)
        except ParameterError as error:
            raise ParameterError(f'{prefix_of(group, bare)}{error}') from None
        config = replace(config, **{group: part})
    return config


def values_of(config: Any, bare: str = '') -> dict[str, Scalar]:
    """Return all values of a configuration made of groups, by name, as they were declared."""
    return {
        f'{prefix_of(group.name, bare)}{item.name}': getattr(
            getattr(config, group.name), item.name)
        for group in fields(config)
        for item in fields(getattr(config, group.name))
    }


def prefix_of(group: str, bare: str = '') -> str:
    """Return what stands before the names of a group's parameters: nothing for `bare`."""
    return '' if group == bare else group + '.'
