# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Fine registration of real scans; truth: published poses, and the residual between views."""

import os
from pathlib import Path

import numpy as np
import pytest
from reference import bumpy
from ros_rops.bench.residual import residual
from ros_rops.bench.truth import load_dataset
from ros_rops.core.config import Config
from ros_rops.core.fine import FineView, refine_shape
from ros_rops.core.mesh import build_mesh

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))


@pytest.fixture(scope='module')
def bunny():
    if not (DATA / 'bunny').is_dir():
        pytest.skip(f'no real scans: {DATA / "bunny"} is missing (set ROPS_DATA)')
    found = load_dataset(DATA / 'bunny')
    meshes = [build_mesh(view, Config().mesh) for view in found.views.values()]
    return [FineView.of(mesh) for mesh in meshes], list(found.T_world_view.values()), found.dres


def centred(views, poses, truth, resolution):
    """Return the mean errors after the common motion that suits all views best."""
    left, _, right = np.linalg.svd(sum(
        t[:3, :3] @ p[:3, :3].T for p, t in zip(poses, truth, strict=True)))
    common = np.eye(4)
    common[:3, :3] = left @ right
    moved = [common @ pose for pose in poses]
    common = np.eye(4)
    common[:3, 3] = np.mean([
        (t - p)[:3, :3] @ v.points.mean(axis=0) + (t - p)[:3, 3]
        for v, p, t in zip(views, moved, truth, strict=True)], axis=0)
    turns, shifts = bumpy.errors(views, [common @ pose for pose in moved], truth, resolution)
    return turns.mean(), shifts.mean()


def test_disturbed_bunny_comes_home_and_fits_better_than_published(bunny):
    views, truth, resolution = bunny
    start = bumpy.disturbed(views, truth, resolution, degrees=2.0, shift_mr=2.0)
    result = refine_shape(views, start, resolution, Config().fine)
    turn, shift = centred(views, result.poses, truth, resolution)
    assert result.converged
    assert turn < 0.2
    assert shift < 0.3
    points = [view.points for view in views]
    published = residual(points, truth, resolution)
    assert residual(points, result.poses, resolution) < 0.97 * published
    assert all(view.constrained and view.component == 0 for view in result.views)


def test_a_wrong_view_of_the_bunny_stands_out(bunny):
    views, truth, resolution = bunny
    start = bumpy.disturbed(views, truth, resolution)
    middle = views[6].points.mean(axis=0)
    look = views[6].normals.mean(axis=0)
    flip = np.eye(4)
    flip[:3, :3] = 2 * np.outer(look, look) / (look @ look) - np.eye(3)
    flip[:3, 3] = middle - flip[:3, :3] @ middle
    start[6] = start[6] @ flip
    fits = refine_shape(views, start, resolution, Config().fine).views
    order = np.argsort([view.residual_mr for view in fits])
    assert order[-1] == 6
    assert fits[6].residual_mr > 1.5 * fits[order[-2]].residual_mr
    assert fits[6].agreement < min(fit.agreement for v, fit in enumerate(fits) if v != 6)
