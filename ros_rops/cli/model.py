# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Make the models of a run again, with other parameters, without registering again.

RUN is a run folder, of the station's node too: the poses are those of its poses.json, the views
those of its journal.mcap, or where there is none those of its inputs. Written are for every object
object_<k>.ply (the assembled cloud), object_<k>_surface.ply (.stl, .obj, .glb),
object_<k>_residuals.ply, and quality.json; then report.html. Lengths stay in the units of the run;
.glb is in metres. poses.json stays as it is. Voxel and memory are told before they are used.
Exit code 0 if something was made, 1 if nothing, 2 for a mistake in the command.
"""

import argparse
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
import sys
from typing import Any

from ros_rops.cli.options import threads_of
from ros_rops.cli.results import read_result
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.intake.lock import locked
from ros_rops.intake.reread import views_of_run
from ros_rops.intake.run_file import read_run_file
from ros_rops.modelling.libraries import check_libraries
from ros_rops.pipeline.parameters import dump_config, parse_assignments
from ros_rops.recordings.atomic import replace_file
from ros_rops.reporting.models import Made, make_models, ModelTask

SHORT = {'voxel_mr': 'model.voxel_mr', 'surface': 'model.surface', 'holes': 'model.holes',
         'formats': 'model.formats'}
"""Options that stand for parameters."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument('folder', type=Path, metavar='RUN', help='run folder')
    parser.add_argument(
        '--object', dest='objects', type=int, action='append', default=[], metavar='K',
        help='this object only; may be given again')
    parser.add_argument(
        '--voxel-mr', type=float, metavar='X', help='edge of a voxel, in mesh resolutions')
    parser.add_argument(
        '--surface', choices=('volume', 'poisson', 'none'), help='how the surface is made')
    parser.add_argument(
        '--holes', choices=('open', 'filled'), help='what no view saw stays open, or is filled')
    parser.add_argument(
        '--format', dest='formats', metavar='ply,stl,obj,glb', help='files of the surface')
    parser.add_argument(
        '--set', dest='assignments', action='append', default=[], metavar='model.name=value',
        help='one parameter of the models; may be given again')
    parser.add_argument(
        '--out', type=Path, metavar='DIR', help='where the models are written (default: RUN)')
    parser.add_argument(
        '--threads', type=threads_of, default=0, metavar='N',
        help='threads; 0, the default, for all cores. The result does not depend on it')


def run(args: argparse.Namespace) -> int:
    """Make the models, write them, say what they are."""
    document = read_result(args.folder)
    config = _config(args)
    chosen = _chosen(args.objects, document)
    if not chosen:
        print(f'{args.folder}: the run has no object')
        return 1
    out = args.out or args.folder
    _spare_other_run(args.folder, out)
    with _held(out):
        views = views_of_run(
            args.folder, _names(document, chosen), document['units'] or 'unknown',
            threads=args.threads)
        task = ModelTask(document, views, config, args.threads)
        _say(f'lengths in {document["units"]}')
        try:
            made = make_models(out, task, only=args.objects, say=_say)
            if out.resolve() == args.folder.resolve():
                _keep(out, config)
        except OSError as error:
            place = error.filename or out
            raise InputError(
                f'{place}: cannot be written ({error.strerror or error})') from None
    return _outcome(made, out)


def _config(args: argparse.Namespace) -> Config:
    """Return the parameters of the run, those of the models as asked for."""
    given = parse_assignments(args.assignments)
    for name in given:
        if not name.startswith('model.'):
            raise ParameterError(
                f'{name}: the poses stay as they are; only parameters of the models can be set')
    for option, name in SHORT.items():
        if getattr(args, option) is not None:
            given[name] = getattr(args, option)
    config = Config.from_flat({**read_run_file(args.folder).parameters, **given})
    check_libraries(config.model)
    return config


def _chosen(asked: Collection[int], document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    known = {shape['id']: shape for shape in document['objects']}
    for number in asked:
        if number not in known:
            there = ', '.join(map(str, known)) or 'none'
            raise ParameterError(f'--object: the run has no object {number}; it has: {there}')
    return [shape for number, shape in known.items() if not asked or number in asked]


def _names(document: Mapping[str, Any], chosen: Collection[Mapping[str, Any]]) -> set[str]:
    return {view['name'] for shape in chosen for view in shape['views']}


def _spare_other_run(folder: Path, out: Path) -> None:
    if out.resolve() != folder.resolve() and (out / 'poses.json').exists():
        raise InputError(f'--out: {out} holds another run, whose models would be written over')


@contextmanager
def _held(out: Path) -> Iterator[None]:
    """Hold the folder that is written to, once it is known that it can be."""
    with locked(out, make=True):
        probe = out / 'quality.json.new'
        try:
            probe.write_text('', encoding='utf-8')
            probe.unlink()
        except OSError as error:
            raise InputError(f'{out}: cannot be written ({error.strerror or error})') from None
        yield


def _keep(folder: Path, config: Config) -> None:
    """Let the folder say by which parameters its models were made, and report on them."""
    from ros_rops.cli.modelling import report

    replace_file(folder / 'config.yaml', dump_config(config))
    report(folder)


def _outcome(made: Made, out: Path) -> int:
    for note in made.notes:
        print(f'warning: {note}', file=sys.stderr)
    for number, names in made.objects.items():
        print(f'object {number}: {", ".join(names) or "nothing could be made"}')
    print(f'written to {out}')
    return 0 if any(made.objects.values()) else 1


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
