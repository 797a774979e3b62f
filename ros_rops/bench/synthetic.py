# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `synthetic`: views rendered from a mesh, so that the poses are exact, with noise."""

import argparse
from pathlib import Path

import numpy as np
from ros_rops.bench.evaluate import KnownView
from ros_rops.bench.multiview import Job, multiview_table, run_all, shuffled
from ros_rops.bench.resolution import mesh_resolution
from ros_rops.bench.settings import add_common_arguments, config_of, report, SEED, teller
from ros_rops.core.config import Config
from ros_rops.core.errors import ParameterError
from ros_rops.recordings.reader import read_mesh
from ros_rops.recordings.synthetic import Capture, Model, synthetic_views
from ros_rops.recordings.units import resolve_units


def read_model(path: Path | str) -> Model:
    """
    Read a PLY mesh to be captured, its units inferred from its extent.

    Raises
    ------
    InputError
        If the file is no mesh.
    """
    vertices, faces = read_mesh(path)
    units, _ = resolve_units(vertices, 'auto')
    return Model(vertices, faces, name=Path(path).stem, units=units)


def known_captures(captures: list[Capture], dres: float) -> dict[str, KnownView]:
    """Return the truth of captures, exact, by the name of the view."""
    return {
        one.view.name: KnownView(
            one.object_name, one.T_world_view, one.view.units, dres, one.view.points.mean(axis=0),
            one.view.points)
        for one in captures
    }


def make_job(
    model: Model, noise_mr: float, config: Config, *, views: int, pixels: int, seed: int,
    threads: int,
) -> Job:
    """
    Render the views of a model and put them in a random order.

    dres is that of the views without noise, which lengthens edges and would flatter the errors.
    """
    clean = synthetic_views(model, count=views, seed=seed, pixels=pixels)
    captures = clean
    if noise_mr > 0:
        captures = synthetic_views(
            model, count=views, seed=seed, pixels=pixels, noise_mr=noise_mr)
    dres = float(np.mean([mesh_resolution(one.view) for one in clean]))
    return Job(
        (model.name,), f'noise {noise_mr:g} dres, seed {seed}',
        shuffled([one.view for one in captures], seed), known_captures(captures, dres),
        config, threads, case='synthetic')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench synthetic`."""
    add_common_arguments(parser, metavar='MESH', what='PLY file with triangles')
    parser.add_argument(
        '--noise', type=float, nargs='+', default=[0.0, 0.5], metavar='DRES',
        help='standard deviations along the ray, in dres (default: 0 0.5)')
    parser.add_argument('--views', type=int, default=16, help='views of a mesh (default: 16)')
    parser.add_argument(
        '--pixels', type=int, default=320, help='side of the square image (default: 320)')
    parser.add_argument('--seed', type=int, default=0, help='seed of the poses and the noise')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench synthetic`; returns the exit code."""
    if any(not 0 <= noise < 100 for noise in args.noise):
        raise ParameterError(f'--noise: expected at least 0 dres, got {args.noise}')
    tell = teller(args)
    config = config_of(args, {SEED: args.seed})
    jobs = []
    for path in args.datasets:
        tell(f'rendering {path}')
        model = read_model(path)
        for noise in args.noise:
            jobs.append(make_job(
                model, noise, config, views=args.views, pixels=args.pixels,
                seed=args.seed, threads=args.threads))
    cases = run_all(jobs, tell)
    report(args, cases, multiview_table(cases))
    return 0
