# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Poses that fit by chance. Truth: what the views were rendered from.

Of many views of different objects some fit each other: what is believed at once must be plain.
"""

from dataclasses import replace

import pytest
from ros_rops.bench.scaling.shapes import captures_of
from ros_rops.core.config import Config
from ros_rops.core.efforts import plain, plain_score, unopposed
from ros_rops.core.pair_result import PairResult
from ros_rops.core.pairwise import register
from ros_rops.core.types import Status
from ros_rops.core.verdict import Verdict
from ros_rops.pipeline.prepare import prepare
from ros_rops.pipeline.words import opposed, outlier
from ros_rops.recordings.procedural import assembly, mesh_of
from ros_rops.recordings.synthetic import Model

CONFIG = Config()
PLAIN = {
    'score': 0.3, 'rival': 0.3, 'in_front': 0.02, 'unseen': 0.13, 'contradiction_most': 0.25,
    'residual_mr': 0.1}


@pytest.fixture(scope='module')
def captures():
    models = [Model(*mesh_of(assembly(seed), 0.0025), name=str(seed)) for seed in (10, 6)]
    return [captures_of(model, 4, pixels=200, seed=1) for model in models]


def surfaces(*captures):
    first = prepare(captures[0].view, CONFIG).surface
    return [first, *(prepare(capture.view, CONFIG, resolution=first.resolution).surface
                     for capture in captures[1:])]


def test_what_a_random_search_finds_of_strangers_is_not_plain(captures):
    source, target = surfaces(captures[0][3], captures[1][3])
    # Of two views alone it may be believed: that is why they are not while others are to come.
    thorough = register(source, target, CONFIG)
    assert thorough.status is not Status.PLACED or thorough.numbers['score'] < 0.3


def test_while_views_arrive_strangers_are_not_believed(captures):
    for one in captures[0]:
        for other in captures[1]:
            found = register(*surfaces(one, other), CONFIG, thorough=False)
            assert found.status is not Status.PLACED
            assert found.T_target_source is None


def test_what_is_plain_is_believed_at_once(captures):
    source, target = surfaces(*captures[0][:2])
    quick = register(source, target, CONFIG, thorough=False)
    assert quick.status is Status.PLACED
    assert quick.T_target_source.tobytes() == register(
        source, target, CONFIG).T_target_source.tobytes()


@pytest.mark.parametrize(('change', 'word'), [
    ({}, True),
    ({'score': 0.299}, False),
    ({'rival': 0.301}, False),
    ({'in_front': 0.021}, False),   # 3 x 0.021 + 0.5 x 0.13 = 0.128, of 0.25
    ({'unseen': 0.14}, False),
])
def test_plain_is_far_from_every_doubt(change, word):
    verdict = Verdict(Status.PLACED, None, '', PLAIN | change)
    assert plain_score(CONFIG) == pytest.approx(0.3)
    assert plain(verdict, CONFIG) is word
    assert not plain(replace(verdict, status=Status.AMBIGUOUS), CONFIG)


def result(**change):
    return PairResult('a', 'b', Status.PLACED, None, '', PLAIN | change)


def test_among_several_shapes_rays_must_hardly_contradict():
    assert opposed(result()) == ''
    assert unopposed(PLAIN)
    assert '0.13 of what matches' in opposed(result(unseen=0.14))


@pytest.mark.parametrize(('residual', 'past', 'word'), [
    (9.0, [], True),               # nothing is known
    (0.19, [0.02, 0.03], True),    # as creases are, 1.9 x 0.1
    (0.20, [0.02, 0.03], False),
    (0.37, [0.2, 0.1, 0.9], True),  # 1.9 x 0.2
    (0.39, [0.2, 0.1, 0.9], False),
])
def test_a_pose_fits_as_well_as_others_did(residual, past, word):
    assert (outlier(result(residual_mr=residual), past, 1.9) == '') is word
