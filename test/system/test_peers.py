# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Other programs on rendered views. Truth: the poses rendered; lengths in other units."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from ros_rops.bench.contest import errors_in
from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.paper.rendered import rendered_set
from ros_rops.bench.peers import descriptor, kiss
from ros_rops.bench.peers.extras import missing, open3d_missing
from ros_rops.bench.peers.open3d_views import multiway, Way
from ros_rops.bench.peers.pair_run import PairJob, run_job
from ros_rops.bench.peers.roster import ROSTER
from ros_rops.bench.rivals.pcl import pcl_missing
from ros_rops.core.config import Config
from ros_rops.core.se3 import move
from ros_rops.core.types import Status
from ros_rops.recordings.procedural import blob, mesh_of
from ros_rops.recordings.synthetic import Model

# Open3D and its dependencies warn when they are imported.
pytestmark = pytest.mark.filterwarnings('ignore')


@cache
def rendered():
    vertices, faces = mesh_of(blob(), cell=0.004)
    return rendered_set(Model(vertices, faces, name='blob'), views=3, step_deg=20, pixels=110)


def pair_of(dataset):
    first, second, *_ = dataset.views
    return PairTruth(first, second, 0.8, dataset.reference(first, second))


@pytest.mark.parametrize('name', ROSTER)
def test_everybody_registers_neighbours(name):
    if why := missing(name, ROSTER[name].needs):
        pytest.skip(why)
    dataset = rendered()
    rounds = run_job(PairJob(name, dataset, (pair_of(dataset),), Config(), 1, 1))
    assert [one[0].correct for one in rounds.records] == [True]
    assert rounds.records[0][0].errors.translation_dres < 2.0


def test_kiss_matcher_finds_the_same_pose_in_metres_and_millimetres():
    if why := missing('KISS-Matcher', ('kiss_matcher', 'small_gicp')):
        pytest.skip(why)
    dataset = rendered()
    pair = pair_of(dataset)
    found = []
    for factor in (1.0, 1000.0):
        contestant = kiss.with_small_gicp('kiss', dataset.dres * factor, 1)
        i, j = (contestant.prepare(replace(view, points=view.points * factor)) for view in (
            dataset.views[pair.name_i], dataset.views[pair.name_j]))
        np.testing.assert_allclose(np.ptp(i.points, axis=0).max(), 0.3 / 2.5 * np.ptp(
            dataset.views[pair.name_i].points, axis=0).max() / dataset.dres, rtol=1e-5)
        answer = contestant.register(i, j)
        assert answer.status is Status.PLACED
        found.append(kiss.scaled(answer.T_target_source, 1.0 / factor))
    errors = errors_in(dataset)(PairTruth(pair.name_i, pair.name_j, 0.8, found[0]), found[1])
    assert errors.rotation_deg < 0.05
    assert errors.translation_dres < 0.05


def test_kiss_matcher_refuses_what_shows_nothing_in_common():
    if why := missing('KISS-Matcher', ('kiss_matcher', 'small_gicp')):
        pytest.skip(why)
    view = next(iter(rendered().views.values()))
    contestant = kiss.with_small_gicp('kiss', rendered().dres, 1)
    x, y = np.meshgrid(np.arange(40.0), np.arange(40.0))
    plane = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3) * rendered().dres
    answer = contestant.register(
        contestant.prepare(view),
        contestant.prepare(replace(view, points=plane, grid=None)))
    assert answer.status is Status.REFUSED
    assert answer.T_target_source is None


@pytest.mark.parametrize('way', [Way(), Way(thinned=True)])
def test_open3d_places_all_views(way):
    if why := open3d_missing():
        pytest.skip(why)
    dataset = rendered()
    poses = multiway(list(dataset.views.values()), dataset.dres, way)
    world = list(dataset.T_world_view.values())
    assert len(poses) == 3
    for pose, truth, view in zip(poses, world, dataset.views.values(), strict=True):
        there = move(np.linalg.inv(world[0]) @ truth, view.points)
        off = np.linalg.norm(move(np.linalg.inv(poses[0]) @ pose, view.points) - there, axis=1)
        assert off.max() < 2 * dataset.dres


def test_rops_in_the_convention_of_pcl_is_that_of_pcl():
    if why := pcl_missing():
        pytest.skip(why)
    one = replace(rendered(), views=dict(list(rendered().views.items())[:1]))
    cases = descriptor.run(Laboratory((one,), (), Config()))
    for case in cases:
        assert case['correlation_median'] > 0.9999
        assert case['share_alike'] > 0.95
        assert case['pcl_ms'] > 0 and case['ours_ms'] > 0
    assert 'PCL / ours' in descriptor.show(cases)
    assert len(descriptor.notes(cases)) == 1
