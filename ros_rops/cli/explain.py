# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Tell where the correspondences of a run were lost, stage by stage.

Without a view: a line a view. With one: every registration it took part in, by itself or within
an object ("with 3 more"). With two: those that had one on either side.
"""

import argparse
from pathlib import Path

from ros_rops.core.errors import ParameterError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, metavar='RUN', help='run folder')
    parser.add_argument('views', nargs='*', metavar='VIEW', help='one view, or two')


def run(args: argparse.Namespace) -> int:
    """Print the explanation."""
    from ros_rops.reporting.explain import explain

    if len(args.views) > 2:
        raise ParameterError(f'VIEW: one or two, got {len(args.views)}')
    print(explain(args.folder, args.views), end='')
    return 0
