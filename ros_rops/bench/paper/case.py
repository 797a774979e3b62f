# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `paper`: every table and figure of section V by one command."""

import argparse

from ros_rops.bench.experiment import Experiment
from ros_rops.bench.laboratory import add_laboratory_arguments, run_laboratory
from ros_rops.bench.paper import (
    fig11, fig4, fig5, fig6, fig8, fig9, table1, table2, table3, table4, table5, table6, times)

# In the order of the paper.
EXPERIMENTS: tuple[Experiment, ...] = (
    table1.EXPERIMENT,
    table2.EXPERIMENT,
    table2.EXPERIMENT_AS_PAPER,
    fig4.EXPERIMENT,
    fig5.EXPERIMENT,
    fig6.EXPERIMENT,
    fig8.EXPERIMENT,
    fig9.EXPERIMENT,
    table3.EXPERIMENT,
    table4.EXPERIMENT,
    fig11.EXPERIMENT,
    table5.EXPERIMENT,
    table6.EXPERIMENT,
    times.EXPERIMENT,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench paper`."""
    add_laboratory_arguments(parser, EXPERIMENTS)


def run(args: argparse.Namespace) -> int:
    """Run `rops bench paper`; returns the exit code."""
    return run_laboratory('paper', args, EXPERIMENTS)
