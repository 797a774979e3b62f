# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Case `turntable`: a simulated station, recorded as `rops simulate` does, read back and registered.

Objects stand on the turntable one after the other, their frames mixed; every view goes through a
recording, so that what is measured is the way of a user's data.
"""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from ros_rops.bench.evaluate import KnownView
from ros_rops.bench.multiview import Job, multiview_table, run_all
from ros_rops.bench.resolution import mesh_resolution
from ros_rops.bench.settings import add_common_arguments, config_of, report, SEED, teller
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.core.types import RangeView
from ros_rops.recordings.depth_noise import PRESETS
from ros_rops.recordings.poses import Poses, read_poses
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.simulate import pinhole, poses_path, Sensor, simulate
from ros_rops.recordings.simulate_models import read_models, UPS
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.station import Plan
from ros_rops.recordings.synthetic import Model


def captured(
    models: list[Model], plan: Plan, sensor: Sensor, *, seed: int
) -> tuple[list[RangeView], Poses]:
    """
    Simulate, record, read back: the views in their order, and the exact poses.

    Raises
    ------
    InputError
        If a view cannot be read back.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'turntable.mcap'
        simulate(models, path, plan, sensor, seed=seed)
        source, = find_views([path])
        views = []
        for outcome in source.views():
            if isinstance(outcome, BadView):
                raise InputError(outcome.reason)
            views.append(outcome.view)
        return views, read_poses(poses_path(path))


def make_job(
    models: list[Model], noise: str, plan: Plan, image: tuple[int, int], config: Config, *,
    seed: int, threads: int,
) -> Job:
    """
    Capture a station by a camera of the kind `noise`.

    dres is that of the views without noise, which lengthens edges and would flatter the errors.
    """
    camera = pinhole(*image, 56.0)
    clean, _ = captured(models, plan, Sensor(camera), seed=seed)
    views, poses = captured(models, plan, Sensor(camera, noise=PRESETS[noise]), seed=seed)
    dres = {
        name: float(np.mean([
            mesh_resolution(view) for view in clean if poses.objects[view.name] == name]))
        for name in dict.fromkeys(poses.objects.values())}
    known = {
        view.name: KnownView(
            poses.objects[view.name], poses.T_world_view[view.name], 'm',
            dres[poses.objects[view.name]], view.points.mean(axis=0), view.points)
        for view in views}
    return Job(
        tuple(dres), f'{noise}, seed {seed}', tuple(views), known, config, threads,
        case='turntable')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench turntable`."""
    add_common_arguments(
        parser, metavar='MESH', what='PLY, OBJ or STL file, procedural:blob, procedural:bracket')
    parser.add_argument(
        '--noise', nargs='+', choices=tuple(PRESETS), default=['structured-light', 'd435'],
        help='errors of which cameras (default: structured-light d435)')
    parser.add_argument('--views', type=int, default=18, help='views an object (default: 18)')
    parser.add_argument('--up', default='y', help=f'axis up: {", ".join(UPS)} (default: y)')
    parser.add_argument(
        '--size', type=float, default=0.2, help='longest side in metres (default: 0.2)')
    parser.add_argument('--image', type=int, nargs=2, default=[640, 480], metavar=('W', 'H'))
    parser.add_argument('--seed', type=int, default=0, help='seed of the capture')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench turntable`; returns the exit code."""
    tell = teller(args)
    config = config_of(args, {SEED: args.seed})
    models = read_models(args.datasets, up=args.up, size=args.size)
    plan = Plan(views=args.views)
    jobs = []
    for noise in args.noise:
        tell(f'capturing by {noise}')
        jobs.append(make_job(
            models, noise, plan, (args.image[0], args.image[1]), config, seed=args.seed,
            threads=args.threads))
    cases = run_all(jobs, tell)
    report(args, cases, multiview_table(cases))
    return 0
