# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Go on with a run that was killed, interrupted, or stopped by a full disk.

RUN is the folder of `rops register` or `rops replay`. The views in its journal go through the
session again, then the input is read on from where it stopped. The result is that of a run that
was never interrupted, byte by byte. Where the input is gone or has changed, this is said and the
run ends with what the journal holds. Of a run whose poses are there already, the models and the
report that are missing are made; one that is finished is left as it is.
Exit code 0 if at least one view was placed, 1 if none, 2 for a mistake in the command.
"""

import argparse
from pathlib import Path

from ros_rops.cli.options import threads_of
from ros_rops.cli.runs import go_on, outcome


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('run_folder', type=Path, metavar='RUN', help='run folder')
    parser.add_argument(
        '--threads', type=threads_of, default=0, metavar='N',
        help='threads; 0, the default, for all cores. The result does not depend on it')


def run(args: argparse.Namespace) -> int:
    """Resume, write the run folder, print the table."""
    document = go_on(args.run_folder, threads=args.threads)
    if document is None:
        print(f'{args.run_folder}: this run is finished; there is nothing to go on with')
        return 0
    return outcome(document, args.run_folder)
