# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Write report.html of a run: one file to look at, in any browser, without a network.

RUN is a run folder, of an earlier version too. The report says what its files say; where models
or pictures are missing, it does without them (`rops model RUN` makes the models). Every run writes
it at its end; this writes it again.
"""

import argparse
from pathlib import Path

from ros_rops.cli.results import read_result
from ros_rops.core.errors import InputError
from ros_rops.intake.lock import locked


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, metavar='RUN', help='run folder')


def run(args: argparse.Namespace) -> int:
    """Write the report, and say where it is."""
    from ros_rops.reporting.report import write_report

    read_result(args.folder)
    with locked(args.folder):
        try:
            print(write_report(args.folder))
        except OSError as error:
            raise InputError(
                f'{error.filename or args.folder}: cannot be written '
                f'({error.strerror or error})') from None
    return 0
