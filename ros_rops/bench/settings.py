# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the cases share: their options, the configuration they run with, the JSON they write."""

import argparse
from collections.abc import Callable, Mapping, Sequence
import json
import math
from pathlib import Path
import sys
from typing import Any

from ros_rops.bench.reference_kernel import measured_machine
from ros_rops.bench.truth import load_dataset, ReferenceSet
from ros_rops.core.config import Config, describe
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.pipeline.parameters import load_config

SEED = 'pairwise.seed'
# RoPS alone: no random starts and few candidates; the control: random starts alone, as few. Only a
# fifth of the starts joins the quick search, which is all there is then: 2,000 are scored.
FEW_REFINED: Mapping[str, object] = {'pairwise.refined': 20}
MODES: Mapping[str, Mapping[str, object]] = {
    'default': {},
    'features-only': {'pairwise.random_starts': 0, **FEW_REFINED},
    'control': {'pairwise.matches': False, **FEW_REFINED},
}


def derive(config: Config, changes: Mapping[str, object]) -> Config:
    """
    Return `config` with the parameters of `changes` (dotted names) replaced.

    Raises
    ------
    ParameterError
        For an unknown name, a wrong type or a value out of bounds.
    """
    return Config.from_flat({**config.to_flat(), **changes})


def parse_change(text: str) -> tuple[str, object]:
    """
    Read 'name=value', the value in the type of the parameter.

    Raises
    ------
    ParameterError
        If there is no such parameter or the value is not of its type.
    """
    name, equals, value = text.partition('=')
    kinds = {info.name: type(info.default) for info in describe()}
    if not equals or name not in kinds:
        raise ParameterError(f'{text!r}: expected PARAMETER=VALUE of a known parameter')
    kind = kinds[name]
    if kind is bool:
        if value not in ('true', 'false'):
            raise ParameterError(f'{name}: expected true or false, got {value!r}')
        return name, value == 'true'
    try:
        return name, kind(value)
    except ValueError:
        raise ParameterError(f'{name}: expected {kind.__name__}, got {value!r}') from None


def add_common_arguments(
    parser: argparse.ArgumentParser, *, metavar: str = 'DATASET',
    what: str = 'folder with views/ and reference_poses.json', count: str | None = '+',
) -> None:
    """Declare the options that all cases take, and what they are run on, `count` of these."""
    if count is not None:
        parser.add_argument('datasets', nargs=count, metavar=metavar, help=what)
    parser.add_argument('--json', metavar='FILE', help='write the numbers there')
    parser.add_argument(
        '--threads', type=int, default=0, help='threads of the engine, 0 for all (default)')
    parser.add_argument(
        '--config', type=Path, metavar='YAML',
        help='ROS parameter file, as config/paper.yaml; what it does not name is at its default')
    parser.add_argument(
        '--set', dest='changes', action='append', default=[], metavar='PARAMETER=VALUE',
        help='change one parameter of the engine; may be given again')
    parser.add_argument('--quiet', action='store_true', help='no progress')


def config_of(args: argparse.Namespace, extra: Mapping[str, object] | None = None) -> Config:
    """Return the defaults, changed by the file, then by `extra`, then by the options."""
    config = load_config(args.config) if args.config else Config()
    return derive(config, {**(extra or {}), **dict(map(parse_change, args.changes))})


def teller(args: argparse.Namespace) -> Callable[[str], None]:
    """Return what shows progress: one line on a terminal, rewritten; none elsewhere."""
    if args.quiet or not sys.stderr.isatty():
        return lambda text: None

    def tell(text: str) -> None:
        sys.stderr.write(f'\r\x1b[2K{text}')
        sys.stderr.flush()

    return tell


def load_all(folders: Sequence[str], tell: Callable[[str], None]) -> list[ReferenceSet]:
    """
    Read the data sets.

    Raises
    ------
    InputError
        If one cannot be read, or two have the same name (views could not be told apart).
    """
    sets: list[ReferenceSet] = []
    for folder in folders:
        tell(f'reading {folder}')
        one = load_dataset(folder)
        if any(one.name == other.name for other in sets):
            raise InputError(f'{folder}: a second data set named {one.name!r}')
        sets.append(one)
    return sets


def plain(value: Any) -> Any:
    """Return `value` with numbers that JSON does not know (NaN, infinities) as None."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def report(
    args: argparse.Namespace, cases: Sequence[Mapping[str, Any]], text: str,
    *, facts: Mapping[str, Any] | None = None,
) -> None:
    """
    Show a table and write {"machine", "cases"} where `--json` says.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    facts = measured_machine() if facts is None else facts
    teller(args)('')
    sys.stdout.write(text + f'{facts["cpu"]}, {facts["cores"]} cores\n')
    write_json(args, cases, facts)


def write_json(
    args: argparse.Namespace, cases: Sequence[Mapping[str, Any]], facts: Mapping[str, Any],
) -> None:
    """
    Write {"machine", "cases"} where `--json` says.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    if not args.json:
        return
    content = plain({'machine': facts, 'cases': list(cases)})
    try:
        Path(args.json).write_text(
            json.dumps(content, indent=1, allow_nan=False) + '\n', encoding='utf-8')
    except OSError as error:
        raise InputError(f'{args.json}: cannot be written ({error.strerror or error})') from None
