# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Case `compare`: what became better or worse, beyond noise, from one file of results to another.

Cases are matched by what they are of. A wrong answer that is new is always worse. Seconds are
divided by those of a reference kernel measured in the same run, so that a file of another machine
will do; without it they are not compared.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
import json
from pathlib import Path
import sys

from ros_rops.bench.compare_cases import Group, Measured, read_measured, Series, side_by_side
from ros_rops.bench.compare_kinds import Kind, kind_at
from ros_rops.bench.compare_verdicts import Judge, State, Verdict
from ros_rops.bench.table import table
from ros_rops.core.errors import InputError, ParameterError

# What a case is run on; right answers are judged over all of it together too.
_DATA = ('dataset', 'datasets', 'set', 'data', 'object', 'model', 'pairs', 'pairs_all', 'views')
_ORDER = (State.WORSE, State.BETTER, State.UNKNOWN, State.ONLY_A, State.ONLY_B, State.SAME)


@dataclass(frozen=True, slots=True)
class Line:
    """One number of one case, compared."""

    case: str
    what: str
    verdict: Verdict


def compare(a: Measured, b: Measured, judge: Judge) -> list[Line]:
    """
    Compare all cases of two files.

    Raises
    ------
    InputError
        If they have no case in common.
    """
    groups = side_by_side(a, b)
    if not any(group.a and group.b for group in groups):
        raise InputError(f'{a.name} and {b.name} have no case in common')
    lines = [line for group in groups for line in _of_group(group, judge)]
    return lines + _together(groups, judge)


def _of_group(group: Group, judge: Judge) -> list[Line]:
    if not group.a or not group.b:
        state = State.ONLY_A if group.a else State.ONLY_B
        return [Line(group.label, 'all', Verdict(state, '', ''))]
    lines = []
    for path in dict.fromkeys((*group.a, *group.b)):
        one, other = group.a.get(path), group.b.get(path)
        if one and other:
            verdict = judge.judge(kind_at(path), path, one, other)
        else:
            verdict = Verdict(State.ONLY_A if one else State.ONLY_B, '', '')
        lines.append(Line(group.label, ' '.join(path), verdict))
    return lines


def _together(groups: Sequence[Group], judge: Judge) -> list[Line]:
    """Judge right answers known one by one over all data too: small losses everywhere add up."""
    pools: dict[tuple[str, tuple[str, ...]], tuple[Series, Series, list[str]]] = {}
    for group in groups:
        label = ' '.join(v for k, v in group.identity.items() if k not in _DATA)
        for path in group.a:
            if kind_at(path) is not Kind.RIGHT or path not in group.b:
                continue
            one, other, labels = pools.setdefault((label, path), ({}, {}, []))
            for pool, series in ((one, group.a[path]), (other, group.b[path])):
                pool.update({(group.label, *item): value for item, value in series.items()
                             if isinstance(value, bool)})
            labels.append(group.label)
    return [
        Line(f'{label}, together', ' '.join(path), judge.judge(Kind.RIGHT, path, one, other))
        for (label, path), (one, other, labels) in pools.items()
        if len(labels) > 1 and one and other]


def compare_table(lines: Sequence[Line], *, everything: bool) -> str:
    """Return what is not the same, or everything, as a table, and how many of each there are."""
    counts = Counter(line.verdict.state for line in lines)
    silent = {State.SAME, State.UNKNOWN}
    rows = [
        [line.verdict.state.value, line.case, line.what, line.verdict.a, line.verdict.b,
         line.verdict.why]
        for state in _ORDER for line in lines
        if line.verdict.state is state
        and (everything or state not in silent or line.verdict.changed)]
    shown = table(['', 'case', 'what', 'A', 'B', 'why'], rows) + '\n' if rows else ''
    reasons = Counter(v.why for v in (one.verdict for one in lines) if v.state is State.UNKNOWN)
    said = ', '.join(f'{state.value} {counts[state]}' for state in _ORDER)
    return f'{shown}{said}\n' + ''.join(
        f'{count} not compared: {why}\n' for why, count in reasons.items())


def worse(lines: Sequence[Line], *, strict: bool) -> bool:
    """Tell whether something became worse; where strict, a case or number that went counts too."""
    bad = {State.WORSE, State.ONLY_A} if strict else {State.WORSE}
    return any(line.verdict.state in bad for line in lines)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench compare`."""
    for name in ('a', 'b'):
        parser.add_argument(
            name, type=Path, metavar=f'{name.upper()}.json',
            help='written by --json or --out of a case' + (', the newer one' * (name == 'b')))
    parser.add_argument(
        '--strict', action='store_true',
        help='a single right answer lost is worse, and so is what is only in A')
    parser.add_argument(
        '--slower', type=float, metavar='SHARE',
        help='how much more time, in units of the reference kernel, is noise (default: 0.15 of '
        'many values, 0.25 of few, 0.4 on another machine, and the noise of the kernel)')
    parser.add_argument('--all', action='store_true', help='show what is the same, too')
    parser.add_argument('--json', metavar='FILE', help='write the lines there')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench compare`; returns 0, or 1 if something is worse."""
    if args.slower is not None and not 0 <= args.slower < 100:
        raise ParameterError(f'--slower: expected a share from 0 to 100, got {args.slower}')
    a, b = read_measured(args.a), read_measured(args.b)
    lines = compare(a, b, Judge(a.machine, b.machine, args.strict, args.slower))
    sys.stdout.write(compare_table(lines, everything=args.all))
    if args.json:
        _write(Path(args.json), lines)
    return int(worse(lines, strict=args.strict))


def _write(path: Path, lines: Sequence[Line]) -> None:
    content = [
        {'case': line.case, 'what': line.what, **asdict(line.verdict),
         'state': line.verdict.state.value} for line in lines]
    try:
        path.write_text(json.dumps({'lines': content}, indent=1) + '\n', encoding='utf-8')
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None
