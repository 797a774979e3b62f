# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Options that several verbs take."""

import argparse
from pathlib import Path

from ros_rops.core.config import Config, describe
from ros_rops.core.errors import InputError
from ros_rops.pipeline.parameters import load_config, parse_assignments


def add_engine_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the engine is run with."""
    parser.add_argument(
        '--config', type=Path, metavar='YAML', help='ROS parameter file; the rest are defaults')
    parser.add_argument(
        '--set', dest='assignments', action='append', default=[], metavar='name=value',
        help='one parameter, over the file; may be given again (names: see README or config.yaml)')
    parser.add_argument(
        '--seed', type=int, metavar='N',
        help='seed of everything random: of each parameter whose name ends in .seed')
    parser.add_argument(
        '--threads', type=threads_of, default=0, metavar='N',
        help='threads; 0, the default, for all cores. The result does not depend on it')
    parser.add_argument(
        '--units', choices=('auto', 'm', 'mm'), default='auto',
        help='units of the input; auto, the default, takes what it states or infers them')


def add_run_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what a run takes beside its inputs and its engine."""
    parser.add_argument(
        '--out', type=Path, required=True, metavar='DIR', help='where the run is written')
    parser.add_argument(
        '--topic', dest='topics', action='append', default=[], metavar='NAME',
        help='topic of a recording: point clouds or depth images; may be given again. By default '
        'all point clouds, or where there is none all depth images')
    parser.add_argument(
        '--background', type=Path, metavar='RECORDING',
        help='recording of the station without an object; what its first frame shows is cut out '
        'of the frames')
    parser.add_argument('--no-picture', action='store_true', help='do not draw picture.png')
    parser.add_argument(
        '--no-model', action='store_true',
        help='write the poses and the plain cloud of each object only; `rops model` makes the '
        'models later')
    parser.add_argument('--no-report', action='store_true', help='do not write report.html')
    parser.add_argument(
        '--no-journal', action='store_true',
        help='keep no journal.mcap; a run that breaks off then begins anew')
    parser.add_argument(
        '--overwrite', action='store_true', help='give up an unfinished run that DIR may hold')


def config_of(args: argparse.Namespace) -> Config:
    """
    Return the parameters: defaults, the file's over them, the options' over these.

    Raises
    ------
    ParameterError
        If the file or an option is at fault.
    """
    config = load_config(args.config) if args.config else Config()
    changes = parse_assignments(args.assignments)
    if args.seed is not None:
        changes |= dict.fromkeys(seeds(), args.seed)
    return Config.from_flat({**config.to_flat(), **changes})


def seeds() -> list[str]:
    """Return the names of the parameters that are seeds."""
    return [info.name for info in describe() if info.name.endswith('.seed')]


def threads_of(text: str) -> int:
    """Return the number of threads that an option says."""
    try:
        count = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is no number') from None
    if count < 0:
        raise argparse.ArgumentTypeError(f'{count} is below 0')
    return count


def refuse_existing(force: bool, *paths: Path) -> None:
    """
    Refuse to overwrite, unless told to.

    Raises
    ------
    InputError
        If one of the paths exists and `force` is not set.
    """
    for path in paths:
        if path.exists() and not force:
            raise InputError(f'{path}: exists already (--force overwrites it)')
