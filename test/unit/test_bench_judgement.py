# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Judging shapes. Truth: analytic (poses moved by known amounts, labels exchanged by hand)."""

import numpy as np
import pytest
from reference.bench_sets import random_pose, turned
from ros_rops.bench.judgement import judge, Placement, ViewTruth

RNG = np.random.default_rng(11)


def truth_of(label, count):
    return {
        f'{label}/{k}': ViewTruth(label, random_pose(RNG), RNG.normal(size=3) * 5, dres=0.1)
        for k in range(count)
    }


def placed(truth, shape, T_object_world=None):
    T = random_pose(RNG) if T_object_world is None else T_object_world
    return {name: Placement(shape, T @ view.T_world_view) for name, view in truth.items()}


def test_a_common_frame_is_free():
    truth = truth_of('a', 6)
    result = judge(placed(truth, 's'), truth)
    assert (result.views, result.placed) == (6, 6)
    assert result.overall.max_rotation_deg < 1e-6
    assert result.overall.max_translation_dres < 1e-6
    assert (result.wrong_placements, result.wrong_merges, result.splits) == ((), 0, 0)


def test_the_result_does_not_depend_on_the_frame_or_the_order():
    truth = truth_of('a', 7)
    exact = placed(truth, 's', np.eye(4))
    noisy = {n: Placement('s', turned(p.T_object_view, RNG.normal(), RNG.normal(size=3)))
             for n, p in exact.items()}
    first = judge(noisy, truth)
    frame = random_pose(RNG)
    moved = {n: Placement('s', frame @ p.T_object_view) for n, p in reversed(noisy.items())}
    second = judge(moved, dict(reversed(truth.items())))
    assert first.overall.mean_rotation_deg > 0.1
    for name in ('mean_rotation_deg', 'max_rotation_deg', 'mean_translation_dres'):
        assert getattr(first.overall, name) == pytest.approx(getattr(second.overall, name))


def test_two_views_share_a_known_error():
    # Turned apart by 2 degrees about the centroid of one: the best frame leaves 1 degree each.
    truth = truth_of('a', 2)
    names = list(truth)
    poses = placed(truth, 's')
    view = truth[names[1]]
    poses[names[1]] = Placement('s', turned(poses[names[1]].T_object_view, 2.0, view.centroid))
    result = judge(poses, truth)
    assert result.errors[names[0]].rotation_deg == pytest.approx(1.0, abs=1e-6)
    assert result.errors[names[1]].rotation_deg == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize('deg', [6.0, 40.0, 90.0, 180.0])
def test_one_wrong_view_does_not_drag_the_right_ones_along(deg):
    truth = truth_of('a', 4)
    poses = placed(truth, 's')
    wrong = 'a/2'
    poses[wrong] = Placement(
        's', turned(poses[wrong].T_object_view, deg, truth[wrong].centroid))
    result = judge(poses, truth)
    assert result.wrong_placements == (wrong,)
    assert result.errors[wrong].rotation_deg == pytest.approx(deg, abs=1e-5)
    assert result.errors['a/0'].rotation_deg < 1e-6
    assert result.overall.max_rotation_deg == pytest.approx(deg, abs=1e-5)
    assert result.overall.mean_rotation_deg == pytest.approx(deg / 4, abs=1e-5)


def test_a_shifted_view_is_wrong_from_5_dres():
    truth = truth_of('a', 5)
    for shift, wrong in ((0.45, ()), (0.7, ('a/1',))):  # 4.5 and 7 dres, the mean takes a fifth
        poses = placed(truth, 's', np.eye(4))
        moved = poses['a/1'].T_object_view.copy()
        moved[0, 3] += shift
        poses['a/1'] = Placement('s', moved)
        assert judge(poses, truth).wrong_placements == wrong


def test_merged_objects_are_counted_and_each_aligned_by_itself():
    a, b = truth_of('a', 3), truth_of('b', 4)
    result = judge({**placed(a, 's'), **placed(b, 's')}, {**a, **b})
    assert (result.wrong_merges, result.splits) == (1, 0)
    assert result.wrong_placements == ()


def test_split_objects_are_counted():
    truth = truth_of('a', 6)
    first = dict(list(truth.items())[:3])
    rest = dict(list(truth.items())[3:])
    result = judge({**placed(first, 's'), **placed(rest, 't')}, truth)
    assert (result.wrong_merges, result.splits) == (0, 1)


def test_exchanged_views_are_merges_and_splits():
    a, b = truth_of('a', 3), truth_of('b', 3)
    poses = {**placed(a, 's'), **placed(b, 't')}
    poses['a/0'], poses['b/0'] = poses['b/0'], poses['a/0']
    result = judge(poses, {**a, **b})
    assert (result.wrong_merges, result.splits) == (2, 2)


def test_views_not_placed_and_views_unknown():
    truth = truth_of('a', 5)
    poses = placed(dict(list(truth.items())[:3]), 's')
    poses['stranger'] = Placement('s', np.eye(4))
    result = judge(poses, truth)
    assert (result.views, result.placed, result.unknown) == (5, 3, ('stranger',))
    assert result.wrong_merges == 0


def test_nothing_placed_gives_no_numbers():
    result = judge({}, truth_of('a', 2))
    assert (result.placed, result.overall.mean_rotation_deg) == (0, None)
    assert result.objects[0].views == 2
