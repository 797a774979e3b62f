# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Write the result of a run as an MCAP recording: poses, assembled clouds, the word on every view.

RUN is a run folder. RViz, Foxglove and rosbag2 open the file: poses on /tf_static, a PointCloud2
an object on /object_<id>/cloud, a String of JSON a view on /view_reports; lengths in metres.
"""

import argparse
from pathlib import Path

from ros_rops.cli.options import refuse_existing
from ros_rops.core.errors import InputError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, metavar='RUN')
    parser.add_argument('--out', type=Path, required=True, metavar='X.mcap')
    parser.add_argument('--force', action='store_true', help='overwrite what exists')


def run(args: argparse.Namespace) -> int:
    """Export; the exit code is 1 if the run has no object."""
    from ros_rops.reporting.export import export_run

    if args.out.suffix.lower() != '.mcap':
        raise InputError(f'--out: {args.out} does not end in .mcap')
    refuse_existing(args.force, args.out)
    document = export_run(args.folder, args.out)
    count = sum(len(shape['views']) for shape in document['objects'])
    print(f'{count} poses, {len(document["objects"])} clouds written to {args.out}')
    if document['units'] not in ('m', 'mm'):
        print('units of the run are unknown: lengths are as they are')
    return 0 if count else 1
