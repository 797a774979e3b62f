# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Look at an object of a run: in a window if there is a display, in a picture if not.

RUN is a run folder, OBJECT the number of an object in it (by default the first). The window is
Open3D's, or where that is not installed matplotlib's; it ends when it is closed. Without a
display, or with --png, a PNG shows the object from three sides.
"""

import argparse
import os
from pathlib import Path
import sys

from ros_rops.cli.results import read_result
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.reporting.shown import read_shown, Shown


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, metavar='RUN', help='run folder')
    parser.add_argument('object', type=int, nargs='?', metavar='OBJECT', help='its number')
    parser.add_argument(
        '--color', choices=('view', 'residual', 'rgb'), default='rgb',
        help='by the view that saw it; by how far its points lie from what the other views saw; '
        'or, the default, as the sensor saw it')
    parser.add_argument('--png', type=Path, metavar='FILE', help='draw a picture, open no window')


def run(args: argparse.Namespace) -> int:
    """Show the object, and say how; the exit code is 1 if the run has none."""
    from ros_rops.cli.window import show

    known = [int(shape['id']) for shape in read_result(args.folder)['objects']]
    if args.object is not None and args.object not in known:
        raise ParameterError(
            f'OBJECT: the run has no object {args.object}; it has: '
            f'{", ".join(map(str, known)) or "none"}')
    if not known:
        print(f'{args.folder}: the run has no object')
        return 1
    number = known[0] if args.object is None else args.object
    shown = read_shown(args.folder, number, args.color)
    title = f'{args.folder.resolve().name}: object {number}, {shown.what}'
    if args.png is None and (os.environ.get('DISPLAY') or os.environ.get('WAYLAND_DISPLAY')):
        if show(shown, title):
            return 0
        print('no window could be opened; a picture is drawn instead', file=sys.stderr)
    path = args.png or args.folder / f'object_{number}_{args.color}.png'
    _picture(path, shown, title)
    print(f'{title}: drawn to {path}')
    return 0


def _picture(path: Path, shown: Shown, title: str) -> None:
    from ros_rops.reporting.rendering import draw_shown

    if path.suffix.lower() != '.png':
        raise InputError(f'--png: {path} does not end in .png')
    try:
        draw_shown(path, shown, title)
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None
