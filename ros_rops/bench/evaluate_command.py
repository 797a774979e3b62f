# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The command `rops evaluate RUN DATASET...`: options, table, JSON."""

import argparse
import json
from pathlib import Path
import sys

from ros_rops.bench.evaluate import evaluate_run, Evaluation
from ros_rops.bench.settings import plain
from ros_rops.bench.table import table
from ros_rops.core.errors import InputError


def evaluation_text(evaluation: Evaluation) -> str:
    """Return a table by object and what was counted, as `rops evaluate` prints it."""
    found = evaluation.judgement
    rows = [
        [one.label, f'{one.placed}/{one.views}', one.mean_rotation_deg, one.max_rotation_deg,
         one.mean_translation_dres, one.max_translation_dres,
         evaluation.residuals.get(one.label)]
        for one in found.objects
    ]
    heads = ['object', 'placed', 'deg', 'max deg', 'dres', 'max dres', 'residual']
    lines = [
        f'{found.placed} of {found.views} views placed, '
        f'{len(found.wrong_placements)} wrongly; {found.wrong_merges} wrong merges, '
        f'{found.splits} splits; {evaluation.attempts} registrations attempted; '
        f'translations measured at the {evaluation.measured_at} of each view']
    lines += [f'wrong: {name}' for name in found.wrong_placements]
    lines += [f'without a reference: {name}' for name in found.unknown]
    lines += [f'note: {note}' for note in evaluation.notes]
    return table(heads, rows) + '\n'.join(lines) + '\n'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops evaluate`."""
    parser.add_argument('run_folder', metavar='RUN', help='a run folder, or its poses.json')
    parser.add_argument(
        'references', nargs='+', metavar='DATASET',
        help='folders with views/ and reference_poses.json, or JSON files of poses alone')
    parser.add_argument('--json', metavar='FILE', help='write the numbers there')


def run(args: argparse.Namespace) -> int:
    """
    Run `rops evaluate`; returns the exit code.

    Raises
    ------
    InputError
        If the run or a reference cannot be read, or the JSON cannot be written.
    """
    evaluation = evaluate_run(args.run_folder, args.references)
    sys.stdout.write(evaluation_text(evaluation))
    if args.json:
        try:
            Path(args.json).write_text(
                json.dumps(plain(evaluation.numbers()), indent=1) + '\n', encoding='utf-8')
        except OSError as error:
            raise InputError(
                f'{args.json}: cannot be written ({error.strerror or error})') from None
    return 0
