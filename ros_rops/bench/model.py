# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `model`: surfaces made of views in their places, against reference meshes."""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from ros_rops.bench.model_cases import (
    dataset_case, engine_case, is_dataset, Limits, ModelCase, shape_case)
from ros_rops.bench.model_distance import Triangles
from ros_rops.bench.model_frames import settled
from ros_rops.bench.model_maps import draw_map
from ros_rops.bench.model_peers import PEERS
from ros_rops.bench.model_run import Made, made_apart, Maker, ModelJob, OURS
from ros_rops.bench.model_score import (
    COMPLETE_DRES, judge_surface, ModelScore, SAMPLES, surface_facts)
from ros_rops.bench.model_shapes import Scanner
from ros_rops.bench.peers.extras import open3d_missing
from ros_rops.bench.settings import add_common_arguments, config_of, load_all, report, SEED, teller
from ros_rops.bench.table import table
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError, ShapeError
from ros_rops.core.se3 import move
from ros_rops.recordings.reader import read_mesh
from scipy.spatial import cKDTree

HEADS = (
    'data', 'poses', 'by', 'accuracy', 'must', 'aim', 'complete', 'of seen', 'must', 'aim',
    'reached', 'floor', 'after ICP', 'median', '99%', 'bias', 'deg', 'fit', 'faces', 'holes',
    'floating', 's', 'MiB')


def reached(score: ModelScore, limits: Limits | None) -> str | None:
    """Return 'aim', 'must' or 'neither'; None where nothing is asked."""
    if limits is None:
        return None
    share = score.completeness_seen if limits.over_seen else score.completeness
    share = score.completeness if share is None else share
    if score.accuracy <= limits.accuracy_aim and share >= limits.completeness_aim:
        return 'aim'
    good = score.accuracy <= limits.accuracy_must and share >= limits.completeness_must
    return 'must' if good else 'neither'


def raw(case: ModelCase) -> dict[str, Any]:
    """Return, in the same keys, how the views' points as they are would be judged."""
    tree = cKDTree(np.concatenate([move(T, view.points) for view, T in case.views]))
    if case.reference is None:
        raise ShapeError(f'{case.name}: has no reference')
    away = tree.query(case.reference.vertices)[0] <= COMPLETE_DRES * case.dres
    score = {'accuracy': case.floor(), 'completeness': float(away.mean()),
             'completeness_seen': None if case.seen is None else float(away[case.seen].mean())}
    return {
        'case': 'model', 'data': case.name, 'poses': case.poses, 'by': 'points as they are',
        'dres': case.dres, 'views': len(case.views), 'error': None, 'score': score,
        'score_icp': None, 'floor': None, 'limits': None, 'seconds_warm': None,
        'peak_rss_mib': None}


def measure(
    case: ModelCase, maker: Maker, job: ModelJob, maps: Path | None = None,
    samples: int = SAMPLES,
) -> dict[str, Any]:
    """
    Make a surface in a process of its own and judge it; returns plain JSON values.

    `fit` is within which distance 90% of the views' own points lie of the surface, in dres: it
    needs no reference. `score_icp` is the score after the surface was laid onto the reference.
    """
    found = made_apart(maker, job)
    result: dict[str, Any] = {
        'case': 'model', 'data': case.name, 'poses': case.poses, 'by': maker.name,
        'dres': case.dres, 'voxel_mr': job.config.model.voxel_mr, 'views': len(case.views),
        'error': found.error or None, 'seconds': list(found.seconds),
        'seconds_warm': found.warm_s, 'base_rss_mib': found.base_mib,
        'peak_rss_mib': found.peak_mib,
        'seen_share': None if case.seen is None else float(case.seen.mean()),
        'score': None, 'score_icp': None, 'floor': case.floor(),
        'limits': None if case.limits is None else limits_of(case.limits)}
    if found.surface is None or not len(found.surface.faces):
        return {**result, 'error': found.error or 'no face'}
    return {**result, **_judged(case, found, maps, maker.name, samples)}


def limits_of(limits: Limits) -> dict[str, float | bool]:
    """Return limits as plain JSON values."""
    return {name: getattr(limits, name) for name in Limits.__slots__}


def _judged(
    case: ModelCase, found: Made, maps: Path | None, by: str, samples: int
) -> dict[str, Any]:
    surface = found.surface
    if surface is None:
        return {}
    model = Triangles(surface.vertices, surface.faces)
    points = np.concatenate([move(T, view.points[::7]) for view, T in case.views])
    fit = float(np.quantile(model.closest(points).distance, 0.9) / case.dres)
    result: dict[str, Any] = {
        'fit': fit, 'counted': dict(surface_facts(surface)), 'told': dict(surface.facts)}
    if case.reference is None:
        return result
    score = judge_surface(
        surface, case.reference, np.eye(4), case.dres, case.seen, samples=samples)
    settling = settled(surface.vertices, surface.faces, case.reference, case.dres)
    after = judge_surface(
        surface, case.reference, settling, case.dres, case.seen, samples=samples)
    if maps is not None:
        draw_map(
            maps, f'{case.name} {case.poses} {by}', surface, case.reference, case.dres, samples)
    return {
        **result, 'score': score.numbers(), 'score_icp': after.numbers(),
        'reached': reached(score, case.limits)}


def model_table(cases: Sequence[Mapping[str, Any]]) -> str:
    """Return the table that `rops bench model` prints."""
    return table(HEADS, [_row(case) for case in cases])


def _row(case: Mapping[str, Any]) -> list[object]:
    score, limits = case['score'] or {}, case['limits'] or {}
    icp, counted = case['score_icp'] or {}, case.get('counted') or {}
    names = [case['data'], case['poses'], case['by']]
    if case['error']:
        return [*names, *[None] * (len(HEADS) - 4), case['error'][:40]]
    return [
        *names, score.get('accuracy'),
        limits.get('accuracy_must'), limits.get('accuracy_aim'),
        _percent(score.get('completeness')), _percent(score.get('completeness_seen')),
        _percent(limits.get('completeness_must')), _percent(limits.get('completeness_aim')),
        case.get('reached'), case['floor'], icp.get('accuracy'), score.get('median'),
        score.get('p99'), score.get('bias'), score.get('normals_deg'), case.get('fit'),
        counted.get('faces'), counted.get('holes'), counted.get('floating'),
        case['seconds_warm'], case['peak_rss_mib'] and round(case['peak_rss_mib'])]


def _percent(share: float | None) -> str | None:
    return None if share is None else f'{100 * share:.2f}%'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench model`."""
    add_common_arguments(
        parser, metavar='WHAT', what='folder with views/ and reference_poses.json; or a shape to '
        'be scanned: thin:cup, thin:knot, procedural:blob, procedural:bracket, a mesh file')
    parser.add_argument(
        '--reference', action='append', default=[], metavar='SET=MESH',
        help='reference mesh of a data set, in the world of its poses; may be given again')
    parser.add_argument(
        '--poses', nargs='+', choices=('reference', 'engine'), default=['reference', 'engine'],
        help='of data sets (default: both)')
    parser.add_argument(
        '--by', nargs='+', choices=[*OURS, *PEERS], default=['volume'], metavar='MAKER',
        help=f'what is made: {", ".join([*OURS, *PEERS])} (default: volume)')
    parser.add_argument(
        '--noise', type=float, nargs='+', default=[0.0, 0.5], metavar='DRES',
        help='of shapes: standard deviations along the ray (default: 0 0.5)')
    parser.add_argument(
        '--sights', nargs='+', choices=('pinhole', 'orthographic'), default=['pinhole'],
        help='of shapes (default: pinhole)')
    parser.add_argument(
        '--unorganized', action='store_true', help='of shapes: without their grid too')
    parser.add_argument(
        '--pixels', type=int, default=240, help='side of the image of shapes (default: 240)')
    parser.add_argument('--seed', type=int, default=0, help='of the noise and of the engine')
    parser.add_argument(
        '--samples', type=int, default=SAMPLES, help=f'points on a surface (default: {SAMPLES})')
    parser.add_argument('--repeats', type=int, default=0, help='times made again, warm')
    parser.add_argument('--peers', action='store_true', help="Open3D's surfaces in the same run")
    parser.add_argument(
        '--maps', type=Path, metavar='FOLDER', help='draw where each surface errs, as PNG')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench model`; returns the exit code."""
    for name, least in (('repeats', 0), ('pixels', 16), ('samples', 100)):
        if getattr(args, name) < least:
            raise ParameterError(
                f'--{name}: expected at least {least}, got {getattr(args, name)}')
    if any(not 0 <= noise < 100 for noise in args.noise):
        raise ParameterError(f'--noise: expected at least 0 dres, got {args.noise}')
    tell, config = teller(args), config_of(args, {SEED: args.seed})
    absent = open3d_missing() if args.peers else None
    makers = [{**OURS, **PEERS}[name] for name in args.by]
    makers += list(PEERS.values()) if args.peers and not absent else []
    results = []
    for case in _cases(args, config, tell):
        results += [raw(case)] if case.reference is not None else []
        for maker in makers:
            tell(f'{case.name}, {case.poses}: {maker.name}')
            repeats = args.repeats if maker.name in OURS else 0
            job = ModelJob(case.views, case.dres, config, args.threads, repeats)
            results.append(measure(case, maker, job, args.maps, args.samples))
    report(args, results, model_table(results) + (f'{absent}\n' if absent else ''))
    return 0


def _cases(
    args: argparse.Namespace, config: Config, tell: Callable[[str], None]
) -> Iterator[ModelCase]:
    references = _references(args.reference)
    folders = [name for name in args.datasets if is_dataset(name)]
    for dataset in load_all(folders, tell):
        case = dataset_case(dataset, references.pop(dataset.name, None))
        if 'reference' in args.poses:
            yield case
        if 'engine' in args.poses:
            tell(f'registering {dataset.name}')
            yield engine_case(case, config, args.threads)
    if references:
        raise InputError(f'--reference: no data set is named {", ".join(references)}')
    for name in args.datasets:
        if name not in folders:
            tell(f'scanning {name}')
            yield from _scans(args, name)


def _scans(args: argparse.Namespace, name: str) -> Iterator[ModelCase]:
    for sight in args.sights:
        for organized in (True, False) if args.unorganized else (True,):
            for noise in args.noise:
                yield shape_case(name, Scanner(sight, organized, noise, args.pixels), args.seed)


def _references(words: Sequence[str]) -> dict[str, Triangles]:
    result = {}
    for word in words:
        name, equals, path = word.partition('=')
        if not equals:
            raise ParameterError(f'--reference: expected SET=MESH, got {word!r}')
        result[name] = Triangles(*read_mesh(path))
    return result
