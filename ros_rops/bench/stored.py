# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `document`: stored results into the sections of BENCHMARKS.md, nothing measured anew."""

import argparse
from pathlib import Path
import sys

from ros_rops.bench.ablation import EXPERIMENTS as ABLATION
from ros_rops.bench.document import section, update_document
from ros_rops.bench.experiment import Experiment
from ros_rops.bench.paper.case import EXPERIMENTS as PAPER
from ros_rops.bench.peers.case import EXPERIMENTS as PEERS
from ros_rops.bench.results import read_result
from ros_rops.bench.scaling.case import EXPERIMENTS as SCALING
from ros_rops.core.errors import InputError

EXPERIMENTS: dict[str, Experiment] = {
    one.name: one for one in (*PAPER, *PEERS, *SCALING, *ABLATION)}


def stored_sections(folder: Path) -> dict[str, str]:
    """
    Return the section of every result in a folder, by the name of its experiment.

    Raises
    ------
    InputError
        If there is none, or one cannot be read or is of no known experiment.
    """
    paths = sorted(folder.glob('*.json'))
    if not paths:
        raise InputError(f'{folder}: holds no results (*.json)')
    sections = {}
    for path in paths:
        result = read_result(path)
        if result.name not in EXPERIMENTS:
            raise InputError(f'{path}: there is no experiment {result.name!r}')
        sections[result.name] = section(EXPERIMENTS[result.name], result)
    return sections


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench document`."""
    parser.add_argument('results', type=Path, metavar='RESULTS', help='folder given to --out')
    parser.add_argument(
        '--into', type=Path, metavar='FILE',
        help='rewrite the sections in this Markdown file (default: show them)')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench document`; returns the exit code."""
    sections = stored_sections(args.results)
    if args.into:
        update_document(args.into, sections)
    else:
        sys.stdout.write('\n'.join(sections.values()))
    return 0
