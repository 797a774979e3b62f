# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Tell where the correspondences of a run were lost, stage by stage.

Without a view: a line a view. With one: what was cut out of its frame and why, where it came from
one, and every registration it took part in, by itself or within an object ("with 3 more"). With
two: those that had one on either side.
"""

import argparse
from pathlib import Path

from ros_rops.core.errors import ParameterError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, metavar='RUN', help='run folder')
    parser.add_argument('views', nargs='*', metavar='VIEW', help='one view or frame, or two views')
    parser.add_argument(
        '--picture', type=Path, metavar='FILE.png',
        help='draw the frame of the one view: its depth, why points were dropped, what was kept')


def run(args: argparse.Namespace) -> int:
    """Print the explanation."""
    from ros_rops.reporting.explain import explain

    if len(args.views) > 2:
        raise ParameterError(f'VIEW: one or two, got {len(args.views)}')
    print(explain(args.folder, args.views, args.picture), end='')
    return 0
