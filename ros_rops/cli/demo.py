# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Register the recording that ships with the package, and judge it by its exact poses.

It was rendered by the project: 20 views of two objects in mixed order, with the noise and the
holes of a depth camera.
"""

import argparse
from pathlib import Path

from ros_rops.cli.evaluate import judgement_table, right
from ros_rops.cli.options import add_engine_arguments, config_of
from ros_rops.cli.register import register
from ros_rops.core.errors import InputError
from ros_rops.reporting.table import result_table

RECORDING, TRUTH = 'demo.mcap', 'demo_poses.json'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        '--out', type=Path, default=Path('runs/demo'), metavar='DIR',
        help='where the run is written (default: runs/demo)')
    add_engine_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Register, judge, and say where the picture is."""
    from ros_rops.bench.evaluate import evaluate_run

    bags = find_bags()
    document = register(
        [bags / RECORDING], args.out, config_of(args), threads=args.threads, units=args.units,
        overwrite=True)
    print(result_table(document))
    numbers = evaluate_run(args.out, [bags / TRUTH]).numbers()
    print('against the exact poses (deg; dres: mesh resolutions)')
    print(judgement_table(numbers))
    print(f'written to {args.out}; open {args.out / "report.html"}')
    return 0 if right(numbers) and numbers['placed'] else 1


def find_bags() -> Path:
    """
    Return the folder of the recordings, in the source tree or installed.

    Raises
    ------
    InputError
        If it is nowhere.
    """
    for parent in Path(__file__).resolve().parents:
        for folder in (parent / 'bags', parent / 'share' / 'ros_rops' / 'bags'):
            if (folder / RECORDING).is_file() and (folder / TRUTH).is_file():
                return folder
    raise InputError(f'bags/{RECORDING}: is neither in the source tree nor installed')
