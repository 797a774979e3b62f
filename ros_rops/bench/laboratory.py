# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What `rops bench paper`, `peers` and `scaling` share: their options, their way of running."""

import argparse
from collections.abc import Sequence
from pathlib import Path
import shlex
import sys
import time

from ros_rops.bench.document import section, update_document
from ros_rops.bench.experiment import Experiment, Laboratory
from ros_rops.bench.reference_kernel import measured_machine
from ros_rops.bench.results import Result, write_result
from ros_rops.bench.settings import (
    add_common_arguments, config_of, load_all, SEED, teller, write_json)
from ros_rops.bench.synthetic import read_model
from ros_rops.core.errors import ParameterError


def add_laboratory_arguments(
    parser: argparse.ArgumentParser, experiments: Sequence[Experiment], *, count: str = '*',
) -> None:
    """Declare what the experiments run on, which of them, and where their results go."""
    add_common_arguments(parser, count=count)
    parser.add_argument(
        '--mesh', nargs='+', action='extend', default=[], type=Path, metavar='FILE',
        help='closed meshes to render views from')
    names = [one.name for one in experiments]
    parser.add_argument(
        '--only', nargs='+', action='extend', choices=names, metavar='NAME',
        help=f'these experiments alone: {", ".join(names)}')
    parser.add_argument(
        '--out', type=Path, metavar='FOLDER', help='write NAME.json and NAME.svg there')
    parser.add_argument(
        '--document', type=Path, metavar='FILE',
        help='rewrite the sections of these experiments in a Markdown file, as BENCHMARKS.md')
    parser.add_argument('--seed', type=int, default=0, help='seed of everything random')
    parser.add_argument(
        '--repeats', type=int, default=1, metavar='N', help='runs of what is timed (default: 1)')


def laboratory_of(args: argparse.Namespace) -> Laboratory:
    """
    Read what the options name.

    Raises
    ------
    InputError
        If a data set or a mesh cannot be read.
    ParameterError
        If nothing is to be repeated, or on less than no threads.
    """
    if args.repeats < 1:
        raise ParameterError(f'--repeats: expected at least 1, got {args.repeats}')
    if args.threads < 0:
        raise ParameterError(f'--threads: expected at least 0, got {args.threads}')
    tell = teller(args)
    return Laboratory(
        sets=tuple(load_all(args.datasets, tell)),
        models=tuple(read_model(path) for path in args.mesh),
        config=config_of(args, {SEED: args.seed}), threads=args.threads, seed=args.seed,
        repeats=args.repeats, tell=tell,
        folders={Path(folder).name: Path(folder) for folder in args.datasets})


def command_of(
    verb: str, args: argparse.Namespace, experiment: Experiment, options: Sequence[str] = (),
) -> str:
    """
    Return the command that makes one result again, paths without their folders.

    `options` are words of the case's own.
    """
    words = ['rops', 'bench', verb, *(f'$D/{Path(name).name}' for name in args.datasets)]
    if args.mesh:
        words += ['--mesh', *(path.name for path in args.mesh)]
    words += ['--only', experiment.name, *options]
    for name, default in (('seed', 0), ('repeats', 1), ('threads', 0)):
        if getattr(args, name) != default:
            words += [f'--{name}', str(getattr(args, name))]
    if args.config:
        words += ['--config', args.config.name]
    words += [word for change in args.changes for word in ('--set', shlex.quote(change))]
    return ' '.join(words)


def run_laboratory(
    verb: str, args: argparse.Namespace, experiments: Sequence[Experiment], *,
    options: Sequence[str] = (),
) -> int:
    """
    Run experiments one after another; show, store and document each as soon as it is done.

    `options` are words of the case's own, for the command that makes a result again.
    """
    laboratory = laboratory_of(args)
    everything, begun = [], measured_machine()
    for experiment in experiments:
        if args.only and experiment.name not in args.only:
            continue
        facts, start = measured_machine(), time.perf_counter()
        cases = experiment.run(laboratory)
        result = Result(
            experiment.name, command_of(verb, args, experiment, options), facts,
            time.perf_counter() - start, cases)
        everything += [{'experiment': experiment.name, **case} for case in cases]
        laboratory.tell('')
        text = section(experiment, result)
        sys.stdout.write(text + '\n')
        sys.stdout.flush()
        if args.out:
            write_result(args.out, result)
            if experiment.plot is not None:
                experiment.plot(cases, args.out / f'{experiment.name}.svg')
        if args.document:
            update_document(args.document, {experiment.name: text})
    write_json(args, everything, begun)
    return 0
