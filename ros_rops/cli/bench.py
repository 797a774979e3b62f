# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure the engine on data sets.

A data set is a folder with views/ and reference_poses.json. `rops bench CASE --help` tells the
options of a case.
"""

import argparse

from ros_rops.bench.cases import CASES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the cases and their options."""
    cases = parser.add_subparsers(dest='case', required=True, metavar='CASE')
    for name, case in CASES.items():
        case.add_arguments(cases.add_parser(name, help=case.summary, description=case.summary))


def run(args: argparse.Namespace) -> int:
    """Run the case."""
    return CASES[args.case].run(args)
