# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Register what a recording shows, frame by frame as it was recorded.

The frames go the way that a live station's go: `selection.*` says which become views (every one,
every k-th, or one whenever the scene is still and new), `segmentation.*` cuts the object out of
them, the session places them. The result is the same on every run and with any number of threads,
and the same as `rops register` gives for these views from files. `rops register` takes recordings
too, and files beside them; `rops replay` refuses what is no recording.

The result goes to the folder that --out names: as for `rops register`, frames.json saying what
became of every frame. Every view is kept in journal.mcap before it is worked on: after a crash
or Ctrl-C, `rops resume DIR` goes on and gives the same result, byte by byte.
Exit code 0 if at least one view was placed, 1 if none, 2 for a mistake in the command.
"""

import argparse

from ros_rops.cli.options import add_engine_arguments, add_run_arguments, config_of
from ros_rops.cli.runs import begin, outcome
from ros_rops.core.errors import InputError
from ros_rops.recordings.sources import find_views, Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        'recordings', nargs='+', metavar='RECORDING',
        help='MCAP file, rosbag2 folder, ROS 1 bag, or a folder of such')
    add_run_arguments(parser)
    add_engine_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Replay, write the run folder, print the table."""
    sources = find_views(args.recordings)
    for source in sources:
        if not isinstance(source, Recording):
            raise InputError(f'{source.path}: is no recording; `rops register` takes view files')
    document = begin(
        args.recordings, sources, args.out, config_of(args), threads=args.threads,
        units=args.units, topics=args.topics, picture=not args.no_picture,
        journal=not args.no_journal, overwrite=args.overwrite,
        background=args.background, models=not args.no_model, report=not args.no_report)
    return outcome(document, args.out)
