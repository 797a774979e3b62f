# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Poses that have not arrived. Truth: the poses that the views were rendered from."""

import numpy as np
import pytest
from ros_rops.bench.errors import pair_errors
from ros_rops.bench.paper.rendered import rendered_set
from ros_rops.core.config import Config
from ros_rops.core.search import Candidates
from ros_rops.core.settling import settled
from ros_rops.core.verdict import judge
from ros_rops.pipeline.prepare import prepare
from ros_rops.recordings.simulate_models import read_models
from scipy.spatial.transform import Rotation

FIRST, SECOND = 'blob_0', 'blob_75'


@pytest.fixture(scope='module')
def pair():
    model, = read_models(['procedural:blob'], size=0.2)
    views = rendered_set(model, views=4, step_deg=25.0, noise_mr=0.3, seed=0, pixels=220)
    return views, [prepare(views.views[name], Config()).surface for name in (FIRST, SECOND)]


def verdict_on(pair, axis, degrees):
    """Judge the right pose turned about the middle of the source's points."""
    views, (source, target) = pair
    T = views.reference(FIRST, SECOND)
    centre = T[:3, :3] @ views.views[FIRST].points.mean(axis=0) + T[:3, 3]
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler(axis, degrees, degrees=True).as_matrix()
    turn[:3, 3] = centre - turn[:3, :3] @ centre
    candidates = Candidates((turn @ T)[None], np.zeros(1), 1, 1)
    return candidates, judge(source, target, candidates, Config().verdict)


def errors(pair, verdict):
    views, _ = pair
    return pair_errors(
        verdict.T_target_source, views.reference(FIRST, SECOND),
        views.views[FIRST].points.mean(axis=0), views.dres)


@pytest.mark.parametrize(
    ('axis', 'degrees'), [('x', -30.0), ('y', -30.0), ('z', -30.0), ('z', -25.0), ('z', 30.0)])
def test_what_was_left_on_the_way_arrives(pair, axis, degrees):
    _, (source, target) = pair
    candidates, verdict = verdict_on(pair, axis, degrees)
    # Wrong, and believed or refused: the case that is to be mended.
    assert verdict.T_target_source is None or not errors(pair, verdict).correct
    found = errors(pair, settled(source, target, verdict, candidates, Config()))
    assert found.rotation_deg < 1.0 and found.translation_dres < 1.0


def test_what_has_arrived_is_left_as_it_is(pair):
    _, (source, target) = pair
    candidates, verdict = verdict_on(pair, 'z', 0.5)
    assert errors(pair, verdict).rotation_deg < 1.0
    assert settled(source, target, verdict, candidates, Config()) is verdict


def test_nothing_to_refine_is_left_as_it_is(pair):
    _, (source, target) = pair
    nothing = Candidates(np.empty((0, 4, 4)), np.empty(0), 0, 0)
    verdict = judge(source, target, nothing, Config().verdict)
    assert settled(source, target, verdict, nothing, Config()) is verdict
