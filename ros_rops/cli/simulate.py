# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Capture meshes by a simulated depth camera, on a turntable or held by hand.

MESH is a PLY, OBJ or STL file, or procedural:blob, procedural:bracket. Beside the recording lie
its exact poses, X_poses.json, which `rops evaluate` takes; they are on /tf too. Lengths are in
metres, angles in degrees. The same command gives the same bytes.
"""

import argparse
from pathlib import Path
import re

from ros_rops.cli.options import refuse_existing
from ros_rops.cli.progress import Progress
from ros_rops.core.errors import InputError
from ros_rops.recordings.depth_noise import PRESETS
from ros_rops.recordings.simulate import pinhole, poses_path, Sensor, simulate
from ros_rops.recordings.simulate_models import read_models, UPS
from ros_rops.recordings.station import Plan


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('meshes', nargs='+', metavar='MESH')
    parser.add_argument('--out', type=Path, required=True, metavar='X.mcap')
    parser.add_argument('--force', action='store_true', help='overwrite what exists')
    parser.add_argument('--seed', type=int, default=0, help='of everything random (default: 0)')
    parser.add_argument(
        '--units', choices=('auto', 'm', 'mm'), default='auto', help='of the meshes')
    parser.add_argument('--up', default='z', metavar='AXIS',
                        help=f'axis of the meshes that points up: {", ".join(UPS)} (default: z)')
    parser.add_argument('--size', type=float, metavar='M',
                        help='longest side of each mesh (default: as in the file)')
    parser.add_argument('--color', action='store_true', help='paint the objects, record colour')
    _plan_arguments(parser.add_argument_group('capture'))
    _sensor_arguments(parser.add_argument_group('camera'))


def _plan_arguments(group: argparse._ArgumentGroup) -> None:
    group.add_argument('--capture', choices=('turntable', 'hand-held'), default='turntable')
    group.add_argument('--views', type=int, default=18, metavar='N',
                       help='stops of each object, or of the scene (default: 18)')
    group.add_argument('--step', type=float, metavar='DEG',
                       help='turn between stops (default: a full turn in all)')
    group.add_argument('--elevation', type=float, nargs='+', default=[35.0], metavar='DEG',
                       help='of the camera; stops take turns (default: 35)')
    group.add_argument('--distance', type=float, default=0.0, metavar='M',
                       help='to the middle of the object (default: 2.8 radii of the largest)')
    group.add_argument('--together', action='store_true',
                       help='all objects on the table at once, not one after the other')
    group.add_argument('--in-order', action='store_true',
                       help='frames in the order of time (default: mixed)')
    group.add_argument('--still', type=int, default=1, metavar='N',
                       help='frames at each stop (default: 1)')
    group.add_argument('--moving', type=int, default=0, metavar='N',
                       help='frames between one stop and the next, with --in-order (default: 0)')
    group.add_argument('--rate', type=float, default=1.0, metavar='HZ',
                       help='frames a second (default: 1)')


def _sensor_arguments(group: argparse._ArgumentGroup) -> None:
    group.add_argument('--image', default='640x480', metavar='WxH', help='(default: 640x480)')
    group.add_argument('--fov', type=float, default=56.0, metavar='DEG',
                       help='horizontal field of view (default: 56)')
    group.add_argument('--noise', choices=tuple(PRESETS), default='d435',
                       help='errors of which camera (default: d435)')
    group.add_argument('--table', type=float, nargs='?', const=0.0, metavar='M',
                       help='a flat table of this radius (without one: three times the objects)')
    group.add_argument('--as', dest='output', choices=('points', 'depth', 'depth-float'),
                       default='points', help='PointCloud2; Image 16UC1 or 32FC1, with CameraInfo')


def plan_of(args: argparse.Namespace) -> Plan:
    """
    Return what the options say of the capture.

    Raises
    ------
    ParameterError
        If they make no sense.
    """
    return Plan(
        args.capture, args.views, args.step, tuple(args.elevation), args.distance, args.together,
        not args.in_order, args.still, args.moving, args.rate)


def sensor_of(args: argparse.Namespace) -> Sensor:
    """
    Return what the options say of the camera.

    Raises
    ------
    InputError, ParameterError
        If they make no sense.
    """
    size = re.fullmatch(r'(\d{1,5})x(\d{1,5})', args.image)
    if size is None:
        raise InputError(f'--image: expected WIDTHxHEIGHT, got {args.image!r}')
    camera = pinhole(int(size[1]), int(size[2]), args.fov)
    return Sensor(camera, args.output, PRESETS[args.noise], args.table)


def run(args: argparse.Namespace) -> int:
    """Render and write."""
    if args.out.suffix.lower() != '.mcap':
        raise InputError(f'--out: {args.out} does not end in .mcap')
    refuse_existing(args.force, args.out, poses_path(args.out))
    plan, sensor = plan_of(args), sensor_of(args)
    models = read_models(
        args.meshes, up=args.up, size=args.size, units=args.units, color=args.color)
    with Progress(plan.frames(len(models))) as progress:
        count = simulate(
            models, args.out, plan, sensor, seed=args.seed,
            note=f'Exact: rendered by rops simulate, seed {args.seed}.',
            tell=progress.step)
    print(f'{count} frames of {", ".join(model.name for model in models)} on {sensor.topic}')
    print(f'written to {args.out}, exact poses to {poses_path(args.out)}')
    return 0
