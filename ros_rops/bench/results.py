# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Results on disk: one JSON file an experiment, with the command and the machine."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any

from ros_rops.bench.settings import plain
from ros_rops.core.errors import InputError


@dataclass(frozen=True, slots=True)
class Result:
    """
    What one experiment gave.

    Parameters
    ----------
    name : str
        Of the experiment.
    command : str
        That makes it again.
    machine : mapping
        Facts of the machine (`measured_machine`), the commit among them.
    seconds : float
        That the whole experiment took.
    cases : sequence of mapping
        Its lines.
    """

    name: str
    command: str
    machine: Mapping[str, Any]
    seconds: float
    cases: Sequence[Mapping[str, Any]]


def write_result(folder: Path, result: Result) -> Path:
    """
    Write `<folder>/<name>.json`.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    path = folder / f'{result.name}.json'
    content = plain({
        'experiment': result.name, 'command': result.command, 'machine': result.machine,
        'seconds': result.seconds, 'cases': list(result.cases)})
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(content, indent=1, allow_nan=False) + '\n', encoding='utf-8')
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None
    return path


def read_result(path: Path) -> Result:
    """
    Read a file of `write_result`.

    Raises
    ------
    InputError
        If it cannot be read or is none.
    """
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
        return Result(
            str(content['experiment']), str(content['command']), dict(content['machine']),
            float(content['seconds']), [dict(case) for case in content['cases']])
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f'{path}: is not the result of an experiment ({error!r})') from None
