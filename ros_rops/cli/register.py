# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Register range views of one or several objects, in any order, into one model per object.

INPUT is a folder of views (PLY, PCD, XYZ, NPZ), a view file, or a recording (MCAP, rosbag2,
ROS 1 bag) with point clouds or depth images. A file is a view as it stands. The frames of a
recording go through `selection.*` and `segmentation.*` first, just as `rops replay` does it: by
default every frame is taken, and one that shows more than the object is cut down to it.

The result goes to the folder that --out names: poses.json, a PLY an object, config.yaml,
metrics.json, frames.json, trace.json (for `rops explain`), picture.png; `latest` beside it points
to it. Every view is kept in journal.mcap before it is worked on: after a crash or Ctrl-C,
`rops resume DIR` goes on and gives the same result, byte by byte.
Exit code 0 if at least one view was placed, 1 if none, 2 for a mistake in the command.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ros_rops.cli.options import add_engine_arguments, add_run_arguments, config_of
from ros_rops.cli.runs import begin, outcome
from ros_rops.core.config import Config
from ros_rops.recordings.sources import find_views


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('inputs', nargs='+', metavar='INPUT', help='folder, view or recording')
    add_run_arguments(parser)
    add_engine_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Register, write the run folder, print the table."""
    return outcome(register(
        args.inputs, args.out, config_of(args), threads=args.threads, units=args.units,
        topics=args.topics, picture=not args.no_picture, journal=not args.no_journal,
        overwrite=args.overwrite,
        background=args.background, models=not args.no_model, report=not args.no_report), args.out)


def register(
    inputs: Sequence[str | Path], out: Path, config: Config, *, threads: int = 0,
    units: str = 'auto', topics: Sequence[str] = (), picture: bool = True, journal: bool = True,
    overwrite: bool = False, background: Path | None = None, models: bool = True,
    report: bool = True,
) -> dict[str, Any]:
    """
    Run a session over `inputs`, write the run folder, return the content of its poses.json.

    Raises
    ------
    InputError
        If an input does not exist or is of no known kind, the folder cannot be written or holds
        an unfinished run that is not to be overwritten.
        An input that turns out unreadable is refused instead, and the run goes on.
    """
    return begin(
        inputs, find_views(inputs), out, config, threads=threads, units=units, topics=topics,
        picture=picture, journal=journal, overwrite=overwrite, background=background,
        models=models, report=report)
