# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Judge a run against reference poses.

RUN is a run folder or its poses.json. TRUTH is a data set folder (views/, reference_poses.json)
or a JSON file of exact poses. Errors are those after the best rigid alignment of each object;
dres is the mesh resolution.
"""

import argparse
from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

from ros_rops.core.errors import InputError
from ros_rops.reporting.table import columns, number


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, metavar='RUN')
    parser.add_argument('truths', type=Path, nargs='+', metavar='TRUTH')
    parser.add_argument('--json', type=Path, metavar='FILE', help='write the numbers there')


def run(args: argparse.Namespace) -> int:
    """Print the judgement; the exit code is 1 if a view or an object is in the wrong place."""
    from ros_rops.bench.evaluate import evaluate_run
    from ros_rops.bench.settings import plain

    numbers = plain(evaluate_run(args.folder, args.truths).numbers())
    print(judgement_table(numbers), end='')
    if args.json:
        try:
            text = json.dumps(numbers, indent=1, allow_nan=False)
            args.json.write_text(text + '\n', encoding='utf-8')
        except OSError as error:
            raise InputError(f'{args.json}: cannot be written ({error.strerror})') from None
    return 0 if right(numbers) else 1


def right(numbers: Mapping[str, Any]) -> bool:
    """Return whether nothing is in the wrong place: no view, no merged or split object."""
    return not (numbers['wrong_placements'] or numbers['wrong_merges'] or numbers['splits'])


def judgement_table(numbers: Mapping[str, Any]) -> str:
    """Return the judgement: a line an object, what is wrong, the notes."""
    keys = (
        'mean_rotation_deg', 'max_rotation_deg', 'mean_translation_dres', 'max_translation_dres',
        'residual_dres')
    rows = [['object', 'placed', 'mean deg', 'max deg', 'mean dres', 'max dres', 'residual']]
    for item in numbers['objects']:
        rows.append([
            item['label'], f'{item["placed"]}/{item["views"]}',
            *(number(item[key]) for key in keys)])
    lines = [
        f'{numbers["placed"]} of {numbers["views"]} views placed, '
        f'{numbers["wrong_placements"]} in the wrong place; {numbers["wrong_merges"]} wrong '
        f'merges, {numbers["splits"]} splits',
        *(f'wrong: {name}' for name in numbers['wrong_views']), *numbers['notes']]
    return columns(rows) + '\n' + '\n'.join(lines) + '\n'
