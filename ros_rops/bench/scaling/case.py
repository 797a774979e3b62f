# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `scaling`: how time, memory and registrations grow with views and with objects."""

import argparse
from collections.abc import Sequence

from ros_rops.bench.experiment import Experiment
from ros_rops.bench.laboratory import add_laboratory_arguments, run_laboratory
from ros_rops.bench.scaling.objects import OBJECTS, objects_experiment, TOTAL
from ros_rops.bench.scaling.views import PIXELS, VIEWS, views_experiment
from ros_rops.core.errors import ParameterError

EXPERIMENTS: tuple[Experiment, ...] = (views_experiment(), objects_experiment())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench scaling`."""
    add_laboratory_arguments(parser, EXPERIMENTS)
    parser.add_argument(
        '--views', nargs='+', type=int, default=list(VIEWS), metavar='N',
        help=f'views of one object (default: {_words(VIEWS)})')
    parser.add_argument(
        '--objects', nargs='+', type=int, default=list(OBJECTS), metavar='K',
        help=f'objects of which --total views are mixed (default: {_words(OBJECTS)})')
    parser.add_argument(
        '--total', type=int, default=TOTAL, metavar='N',
        help=f'views of all objects together (default: {TOTAL})')
    parser.add_argument(
        '--pixels', type=int, default=PIXELS,
        help=f'side of the square images (default: {PIXELS})')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench scaling`; returns the exit code."""
    _check(args)
    return run_laboratory('scaling', args, (
        views_experiment(args.views, args.pixels),
        objects_experiment(args.objects, args.total, args.pixels)), options=changed(args))


def changed(args: argparse.Namespace) -> list[str]:
    """Return the words of the options of this case that differ from their defaults."""
    words = []
    for name, default in (
            ('views', VIEWS), ('objects', OBJECTS), ('total', TOTAL), ('pixels', PIXELS)):
        value = getattr(args, name)
        values = value if isinstance(value, list) else [value]
        if value not in (default, list(default) if isinstance(default, tuple) else default):
            words += [f'--{name}', *map(str, values)]
    return words


def _check(args: argparse.Namespace) -> None:
    if min(args.views) < 2 or min(args.objects) < 1:
        raise ParameterError(
            f'--views, --objects: expected at least 2 and 1, got {args.views}, {args.objects}')
    if args.total < 2 * max(args.objects):
        raise ParameterError(
            f'--total: expected two views of each of {max(args.objects)} objects at least, '
            f'got {args.total}')
    if not 32 <= args.pixels <= 4096:
        raise ParameterError(f'--pixels: expected 32 to 4096, got {args.pixels}')


def _words(numbers: Sequence[int]) -> str:
    return ' '.join(map(str, numbers))
