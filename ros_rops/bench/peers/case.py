# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `peers`: other programs on the same data in the same run."""

import argparse

from ros_rops.bench.experiment import Experiment
from ros_rops.bench.laboratory import add_laboratory_arguments, run_laboratory
from ros_rops.bench.peers.descriptor import DESCRIPTOR
from ros_rops.bench.peers.pairs import PAIRS
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
    return run_laboratory('peers', args, EXPERIMENTS)
