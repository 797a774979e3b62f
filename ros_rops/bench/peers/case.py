# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `peers`: other programs on the same data in the same run."""

import argparse
from dataclasses import replace
from functools import partial
import shlex

from ros_rops.bench.experiment import Experiment
from ros_rops.bench.laboratory import add_laboratory_arguments, run_laboratory
from ros_rops.bench.peers.descriptor import DESCRIPTOR
from ros_rops.bench.peers.pairs import PAIRS, run as run_pairs
from ros_rops.bench.peers.roster import ROSTER
from ros_rops.bench.peers.views import VIEWS
from ros_rops.core.errors import ParameterError

EXPERIMENTS: tuple[Experiment, ...] = (
    PAIRS,
    VIEWS,
    DESCRIPTOR,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench peers`."""
    add_laboratory_arguments(parser, EXPERIMENTS, count='+')
    parser.add_argument(
        '--by', nargs='+', choices=tuple(ROSTER), metavar='NAME',
        help='these contestants on pairs alone, and ours: ' + ', '.join(ROSTER))


def run(args: argparse.Namespace) -> int:
    """
    Run `rops bench peers`; returns the exit code.

    Raises
    ------
    ParameterError
        If meshes are given: the contest is on scans.
    """
    if args.mesh:
        raise ParameterError('--mesh: rops bench peers runs on data sets only')
    if not args.by:
        return run_laboratory('peers', args, EXPERIMENTS)
    some = replace(PAIRS, run=partial(run_pairs, names=args.by))
    return run_laboratory(
        'peers', args, [some if one is PAIRS else one for one in EXPERIMENTS],
        options=['--by', *map(shlex.quote, args.by)])
