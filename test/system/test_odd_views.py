# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Odd views cost the others nothing. Truth: the demo's views, which fit; what the test adds."""

import json

from meta.tree import ROOT
import numpy as np
import pytest
from ros_rops.core.errors import ViewError
from ros_rops.core.types import RangeView, Status
from ros_rops.pipeline.session import Session
from ros_rops.recordings.sources import find_views

BAGS = ROOT / 'bags'


@pytest.fixture(scope='module')
def pair() -> list[RangeView]:
    """Return two overlapping views of the demo's second object, which fit by themselves."""
    names = ('@1700000005000000000', '@1700000002000000000')
    truth = json.loads((BAGS / 'demo_poses.json').read_text(encoding='utf-8'))['objects']
    views = [
        outcome.view for outcome in find_views([BAGS / 'demo.mcap'])[0].views()
        if outcome.view.name.endswith(names)]
    assert len({truth[view.name] for view in views}) == 1
    return views


def wall() -> RangeView:
    """Return a flat view, its points a tenth of a metre apart."""
    x, y = np.meshgrid(np.arange(-2.0, 2.0, 0.1), np.arange(-2.0, 2.0, 0.1))
    points = np.stack([x, y, np.full_like(x, 3.0)], axis=-1).reshape(-1, 3)
    return RangeView('wall', points, units='m')


def test_a_wall_that_comes_first_does_not_set_the_scale(pair):
    session = Session()
    assert session.add(wall()).status is Status.AMBIGUOUS
    words = [session.add(view).status for view in pair]
    assert words == [Status.PENDING, Status.PLACED]


def test_views_too_far_apart_to_be_one_shape_stay_apart(pair, monkeypatch):
    def grow(*args, **kwargs):
        raise ViewError('together they extend too far')

    monkeypatch.setattr('ros_rops.pipeline.growth.grow', grow)
    session = Session()
    words = [session.add(view) for view in pair]
    session.finish()
    assert words[1].status is Status.PENDING and 'extend too far' in words[1].reason
    assert [one.status for one in session.trace] == [Status.REFUSED]
    assert session.objects == ()


def test_a_refusal_does_not_repeat_the_name(pair):
    report = Session().add(RangeView('none', np.zeros((2, 3)), units='m'))
    assert report.status is Status.REFUSED and report.reason.startswith('2 points')
