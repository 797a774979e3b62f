# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The engine on real scans. Truth: their reference poses, within 5 degrees and 5 dres."""

import os
from pathlib import Path

import numpy as np
import pytest
from ros_rops.bench.truth import load_dataset
from ros_rops.core.config import Config
from ros_rops.core.pairwise import register
from ros_rops.core.types import Status
from ros_rops.pipeline.prepare import prepare
from ros_rops.pipeline.session import Session

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))


def _load(name):
    if not (DATA / name).is_dir():
        pytest.skip(f'no real scans: {DATA / name} is missing (set ROPS_DATA)')
    return load_dataset(DATA / name)


@pytest.fixture(scope='module')
def bunny():
    return _load('bunny')


def check(found, truth, points, dres):
    turn = (np.trace(found[:3, :3].T @ truth[:3, :3]) - 1) / 2
    assert np.degrees(np.arccos(np.clip(turn, -1, 1))) < 5
    assert np.linalg.norm((found - truth)[:3] @ [*points.mean(axis=0), 1]) < 5 * dres


@pytest.mark.parametrize(('source', 'target'), [
    ('bun045', 'bun000'),   # overlap above 0.6
    ('bun090', 'bun000'),   # 0.3 to 0.6
    ('bun180', 'bun270'),
    ('chin', 'bun000'),
    ('top2', 'bun180'),
    ('ear_back', 'bun180'),
])
def test_pairs_of_the_bunny(bunny, source, target):
    a, b = (prepare(bunny.views[f'{name}.ply'], Config()).surface for name in (source, target))
    found = register(a, b, Config())
    truth = np.linalg.inv(bunny.T_world_view[f'{target}.ply']) @ bunny.T_world_view[
        f'{source}.ply']
    assert found.status is Status.PLACED, found.reason
    check(found.T_target_source, truth, bunny.views[f'{source}.ply'].points, bunny.dres)


def test_bunny_and_chef_mixed(bunny):
    chef = _load('chef')
    chosen = [
        (bunny, 'bun000.ply'), (chef, 'chef_view001.txt.gz'), (bunny, 'bun045.ply'),
        (chef, 'chef_view002.txt.gz'), (chef, 'chef_view003.txt.gz'), (bunny, 'bun315.ply')]
    session = Session()
    for dataset, name in chosen:
        session.add(dataset.views[name])
    session.finish()
    found = sorted(sorted(view.name for view in shape.views) for shape in session.objects)
    assert found == [
        sorted(name for dataset, name in chosen if dataset is one) for one in (bunny, chef)]
    shapes = sorted(session.objects, key=lambda shape: shape.views[0].name)
    for shape, one in zip(shapes, (bunny, chef), strict=True):
        first, *others = shape.views
        factor = 1.0 if session.units == one.units else 1e-3
        for view in others:
            pose = np.linalg.inv(first.T_object_view) @ view.T_object_view
            pose[:3, 3] /= factor
            truth = np.linalg.inv(one.T_world_view[first.name]) @ one.T_world_view[view.name]
            check(pose, truth, one.views[view.name].points, one.dres)
