# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Views that stand wrong are in no model. Truth: rendered views, some put wrong by a known motion.

What a body is made of its right views alone is the truth for cloud and surface.
"""

from dataclasses import replace

import numpy as np
import pytest
from reference.captures import model
from reference.posed import around, capture_from, posed, wronged
from ros_rops.core.config import Config
from ros_rops.modelling.model import build_model
from ros_rops.modelling.posed import resolution_of
from ros_rops.modelling.standing import judge


def left_out(views):
    return set(judge(views, Config(), resolution=resolution_of(views), threads=2).left_out)


def built(views, **values):
    given = {f'model.{name}': value for name, value in values.items()}
    return build_model(0, views, Config.from_flat(given), threads=2)


def ring(degrees):
    """Return views of a body from places on a circle about it; far ones have nothing in common."""
    return posed([
        capture_from(model('blob'), (np.cos(angle), np.sin(angle), 0.2), f'v{k}')
        for k, angle in enumerate(np.radians(degrees))])


def test_cloud_and_surface_are_those_of_the_right_views():
    views = wronged(around('blob'), 4, shift_mr=3.0, seed=2)
    found, truth = built(views), built([*views[:4], *views[5:]])
    note, = found.notes
    assert note.startswith(f'{views[4].name} is left out of cloud and surface')
    assert truth.notes == () and views[4].number not in found.cloud.view_ids
    assert found.cloud.facts['views'] == 8
    np.testing.assert_array_equal(found.cloud.points, truth.cloud.points)
    np.testing.assert_array_equal(found.surface.vertices, truth.surface.vertices)
    # Its map shows what is wrong with it all the same.
    document = found.quality.document()
    assert document['left_out'] == [views[4].name]
    assert [one['left_out'] for one in document['views']] == [k == 4 for k in range(9)]
    assert document['views'][4]['flags']
    assert len(found.quality.residuals[4].points) and np.any(found.quality.residuals[4].state == 2)


@pytest.mark.parametrize('name', ['blob', 'bracket'])
def test_three_of_ten_are_left_out_and_no_other(name):
    views = around(name, 10, 110)
    assert left_out(views) == set()
    for seed, (k, wrong) in enumerate(
            ((1, {'degrees': 5.0}), (5, {'shift_mr': 20.0}), (8, {'degrees': 30.0}))):
        views = wronged(views, k, **wrong, seed=seed)
    assert left_out(views) == {1, 5, 8}


def test_of_two_that_contradict_each_other_both_stay():
    pair = wronged(ring((0, 40)), 1, shift_mr=4.0)
    found = built(pair, surface='none')
    assert found.notes == (
        'v0, v1: they do not fit, and it cannot be told which views are wrong; all of them stay '
        'in cloud and surface',)
    assert found.cloud.facts['views'] == 2 and found.quality.left_out == ()
    assert set(found.quality.worst_views) == {'v0', 'v1'}
    for one in found.quality.views:
        assert 'both stay in cloud and surface' in ' '.join(one.flags) and not one.left_out


def test_where_all_that_know_a_view_are_in_question_it_stays():
    """Both ends of a chain of three know its middle only, and either of them may be wrong."""
    middle = wronged(ring((0, 100, 200)), 1, shift_mr=4.0)
    standing = judge(middle, Config(), resolution=resolution_of(middle))
    out = set(standing.left_out)
    assert {one.index for one in standing.misfits} >= {1} and out <= {1}


def test_two_halves_that_contradict_each_other_stay_both():
    views = around('blob', 10, 110)
    motion = np.eye(4)
    motion[:3, 3] = 6.0 * resolution_of(views)
    torn = [
        replace(one, T_object_view=motion @ one.T_object_view) if k % 2 else one
        for k, one in enumerate(views)]
    standing = judge(torn, Config(), resolution=resolution_of(views))
    assert len(standing.misfits) >= 5 and standing.left_out == ()
    assert 'it cannot be told which views are wrong' in built(torn, surface='none').notes[0]
