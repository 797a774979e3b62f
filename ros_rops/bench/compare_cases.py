# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Two files of results: read, and their cases laid side by side.

A case is known by its strings and parameters. Cases that differ by seed or order alone are repeats
of one: their numbers become one series. So do the numbers of the items in a case (pairs, objects,
views), by what each item is of.
"""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import json
import math
from pathlib import Path
from typing import Any

from ros_rops.bench.compare_kinds import (
    Kind, kind_at, kind_of, OUTCOMES, REPEATS, superfluous)
from ros_rops.core.errors import InputError

# What a number is of, as (repeat, item, ...).
Item = tuple[str, ...]
# Of one number in all repeats and items. Lists of names are one value.
Series = dict[Item, float | bool | tuple[str, ...]]
RELATIVE = 'of the reference kernel'
_TELLING = (Kind.OTHER, Kind.PARAMETER)


@dataclass(frozen=True, slots=True)
class Measured:
    """A file of results: the machine's facts and the cases."""

    name: str
    machine: Mapping[str, Any]
    cases: Sequence[Mapping[str, Any]]


@dataclass(slots=True)
class Group:
    """The repeats of one case in both files: each number's series, by its path."""

    label: str
    identity: Mapping[str, str]
    a: dict[tuple[str, ...], Series] = field(default_factory=lambda: defaultdict(dict))
    b: dict[tuple[str, ...], Series] = field(default_factory=lambda: defaultdict(dict))


def _constant(name: str) -> None:
    """Take NaN and infinities, which JSON does not know, as not measured."""


def read_measured(path: Path) -> Measured:
    """
    Read what `--json` or `--out` of a case of `rops bench` wrote.

    Raises
    ------
    InputError
        If it cannot be read or is no such file.
    """
    try:
        content = json.loads(path.read_text(encoding='utf-8'), parse_constant=_constant)
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    except (ValueError, RecursionError) as error:
        raise InputError(f'{path}: is not JSON ({error})') from None
    cases = content.get('cases') if isinstance(content, dict) else None
    if not isinstance(cases, list) or not all(isinstance(case, dict) for case in cases):
        raise InputError(f'{path}: is no file of results: a list named "cases" is missing')
    if not cases:
        raise InputError(f'{path}: holds no cases')
    machine = content.get('machine')
    mark = {'experiment': content['experiment']} if 'experiment' in content else {}
    return Measured(
        str(path), machine if isinstance(machine, dict) else {},
        [{**mark, **case} for case in cases])


def _number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _names(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def _identity(case: Mapping[str, Any], extra: Sequence[str]) -> dict[str, str]:
    """Return what a case is known by."""
    found = {}
    for name, value in case.items():
        if name in REPEATS or name in OUTCOMES or value is None:
            continue
        kind = kind_of(name)
        if (isinstance(value, str) and kind in _TELLING) or name in extra:
            found[name] = str(value)
        elif name == 'datasets' and _names(value):
            found[name] = ' + '.join(value)
        elif _number(value) and kind is Kind.PARAMETER:
            found[name] = f'{value:g}'
    return found


def _label(identity: Mapping[str, str]) -> str:
    """Return the words of a case; numbers after their names."""
    return ' '.join(
        f'{name}={value}' if kind_of(name) is Kind.PARAMETER else value
        for name, value in identity.items()) or 'results'


def _repeat(case: Mapping[str, Any]) -> str:
    return ' '.join(str(case[name]) for name in REPEATS if isinstance(case.get(name), (int, str)))


def _told_apart(a: Sequence[Mapping[str, Any]], b: Sequence[Mapping[str, Any]]) -> list[str]:
    """
    Return further names that tell cases apart: numbers and flags nobody has a meaning for.

    Only where cases would be one otherwise, and where the values of one file are among the
    other's, as those of a parameter are and those of a measurement are not.
    """
    known = [
        Counter((*sorted(_identity(case, ()).items()), _repeat(case)) for case in cases)
        for cases in (a, b)]
    if all(count == 1 for counts in known for count in counts.values()):
        return []
    found = []
    for name in dict.fromkeys(key for case in a for key in case):
        values = [
            {case[name] for case in cases if isinstance(case.get(name), (bool, int, float))}
            for cases in (a, b)]
        if name in REPEATS or kind_of(name) is not Kind.OTHER or not min(values, key=len):
            continue
        if min(values, key=len) <= max(values, key=len):
            found.append(name)
    return found


def side_by_side(a: Measured, b: Measured) -> list[Group]:
    """Return all cases of both files, those of `a` first, in their order."""
    extra = _told_apart(a.cases, b.cases)
    groups: dict[tuple, Group] = {}
    for side, cases in (('a', a.cases), ('b', b.cases)):
        seen: Counter[tuple] = Counter()
        for case in cases:
            identity = _identity(case, extra)
            key = tuple(sorted(identity.items()))
            repeat = _repeat(case)
            seen[key, repeat] += 1
            item = (repeat, str(seen[key, repeat]))
            group = groups.setdefault(key, Group(_label(identity), identity))
            for path, of, value in _leaves(case, (), item, top=True):
                getattr(group, side)[path][of] = value
    return list(groups.values())


def _leaves(
    node: Mapping[str, Any], path: tuple[str, ...], item: Item, *, top: bool = False
) -> Iterator[tuple[tuple[str, ...], Item, Any]]:
    """Yield (path, item, value) of every number, flag and list of names that is judged."""
    left_out = superfluous(node) | (set(REPEATS) if top else set())
    reference = node.get('reference_seconds')
    relative = reference if _number(reference) and reference > 0 else None
    for name, value in node.items():
        if name in left_out:
            continue
        here = (*path, name)
        if isinstance(value, dict):
            if name == 'errors' and all(isinstance(one, dict) for one in value.values()):
                for of, one in value.items():  # of views, by name
                    yield from _leaves(one, here, (*item, of))
            else:
                yield from _leaves(value, here, item)
        elif isinstance(value, list):
            yield from _listed(value, here, item)
        elif kind_at(here) is Kind.SECONDS and relative is not None and _number(value):
            yield (*here, RELATIVE), item, value / relative
        else:
            yield from _leaf(value, here, item)


def _leaf(
    value: object, path: tuple[str, ...], item: Item
) -> Iterator[tuple[tuple[str, ...], Item, Any]]:
    if kind_of(path[-1]) is Kind.PARAMETER or kind_at(path) is Kind.OTHER:
        return
    if isinstance(value, bool) or (_number(value) and math.isfinite(value)):
        yield path, item, value


def _listed(
    value: Sequence[Any], path: tuple[str, ...], item: Item
) -> Iterator[tuple[tuple[str, ...], Item, Any]]:
    if kind_at(path) is Kind.WRONG and not any(map(_number, value)):
        yield path, item, tuple(sorted(_joined(one) for one in value))
        return
    for number, one in enumerate(value):
        if isinstance(one, dict):
            words = [
                text for name, text in one.items()
                if isinstance(text, str) and name not in OUTCOMES]
            yield from _leaves(one, path, (*item, *(words or [str(number)])))
        else:
            yield from _leaf(one, path, (*item, str(number)))


def _joined(name: object) -> str:
    return ' - '.join(map(str, name)) if isinstance(name, list) else str(name)
