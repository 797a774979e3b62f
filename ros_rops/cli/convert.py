# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Convert scan folders to recordings, recordings to scan folders, and other recordings to MCAP.

With --out X.mcap, INPUT is folders or view files, or one recording of another kind; else INPUT
is one recording and --out the folder. Views keep every bit: points, grid, colours, units,
sensor, stamp, and reference poses where they are known.
"""

import argparse
from pathlib import Path
import sys

from ros_rops.cli.options import refuse_existing
from ros_rops.core.errors import InputError
from ros_rops.recordings.convert import Conversion, to_folder, to_recording
from ros_rops.recordings.convert_recording import to_mcap
from ros_rops.recordings.poses import POSES_NAME
from ros_rops.recordings.sensor import CHOICES
from ros_rops.recordings.sources import find_views, Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('inputs', nargs='+', metavar='INPUT', help='folders, files, or recording')
    parser.add_argument('--out', type=Path, required=True, metavar='OUT', help='X.mcap or folder')
    parser.add_argument('--force', action='store_true', help='overwrite what exists')
    parser.add_argument('--topic', dest='topics', action='append', default=[], metavar='TOPIC',
                        help='of a recording; may be given again (default: all frames)')
    parser.add_argument('--units', choices=('auto', 'm', 'mm'), default='auto',
                        help='of the input (default: as stated or inferred)')
    parser.add_argument('--sensor', choices=CHOICES, default='auto',
                        help='of the input (default: as stated or inferred)')


def run(args: argparse.Namespace) -> int:
    """Convert and say what came of it."""
    sources = find_views(args.inputs)
    recording = isinstance(sources[0], Recording)
    if recording and len(sources) > 1:
        raise InputError('one recording at a time can be converted')
    if args.out.suffix.lower() == '.mcap':
        refuse_existing(args.force, args.out)
        if recording:
            if (args.units, args.sensor) != ('auto', 'auto'):
                raise InputError('--units, --sensor: a recording is copied as it is')
            count = to_mcap(sources[0].path, args.out, topics=args.topics)
            print(f'{count} messages written to {args.out}')
            return 0 if count else 1
        return _said(args.out, to_recording(
            args.inputs, args.out, units=args.units, sensor=args.sensor))
    if not recording:
        raise InputError(f'--out: {args.out} does not end in .mcap, and the input is no recording')
    refuse_existing(args.force, args.out / 'views', args.out / POSES_NAME)
    return _said(args.out, to_folder(
        sources[0].path, args.out, topics=args.topics, units=args.units, sensor=args.sensor))


def _said(out: Path, done: Conversion) -> int:
    for fault in done.faults:
        print(f'left out: {fault}', file=sys.stderr)
    print(f'{done.views} views written to {out}')
    return 0 if done.views else 1
