# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Run a case: `python -m ros_rops.bench pairwise|multiview DATASET...`, as `rops bench` does."""

import argparse
from collections.abc import Sequence
import sys

from ros_rops.bench.cases import CASES
from ros_rops.core.errors import RopsError


def main(words: Sequence[str] | None = None) -> int:
    """Parse the command line, run the case, return the exit code (2: the caller's mistake)."""
    parser = argparse.ArgumentParser(prog='python -m ros_rops.bench')
    cases = parser.add_subparsers(dest='case', required=True)
    for name, case in CASES.items():
        case.add_arguments(cases.add_parser(name, help=case.summary))
    args = parser.parse_args(words)
    try:
        return CASES[args.case].run(args)
    except RopsError as error:
        sys.stderr.write(f'{error}\n')
        return 2


if __name__ == '__main__':
    raise SystemExit(main())
