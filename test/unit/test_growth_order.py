# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whom a newcomer tries first. Truth: the rule, by hand; plausibilities are written down."""

from types import SimpleNamespace

import numpy as np
import pytest
from ros_rops.core.config import Config
from ros_rops.core.shape_growing import Prospect, Shape
from ros_rops.pipeline import chances as module
from ros_rops.pipeline.growth import Growth


@pytest.mark.parametrize(('of_object', 'of_view', 'first'), [
    (0.21, 0.9, 'object'),   # likely: views that wait are not even asked
    (0.19, 0.9, 'view'),     # a weak object goes behind a better view
    (0.19, 0.15, 'object'),
    (0.15, 0.15, 'object'),
    (0.05, 0.15, 'view'),    # below `growth.plausible`
    (0.05, 0.05, None),
])
def test_a_likely_object_goes_first_and_a_weak_one_by_its_votes(
    monkeypatch, of_object, of_view, first,
):
    values = {'object': of_object, 'view': of_view}
    monkeypatch.setattr(
        module, 'prospect', lambda small, large, config, **_: Prospect(
            values[small if small != 'new' else large], np.empty((0, 4, 4))))
    monkeypatch.setattr(module, 'promise', lambda *_, **__: 1.0)
    growth = Growth(Config(), 1, {'screen': 0.0}, SimpleNamespace())
    shapes = [Shape('object', {'a': None, 'b': None}), Shape('view', {'c': None}),
              Shape('new', {'d': None})]
    keys = {shape.surface: growth._shapes.insert(shape) for shape in shapes}
    growth._shapes.object_ids[keys['object']] = 0
    chance = growth._best_of(keys['new'], 0.1)
    tried = None if chance is None else next(
        name for name, key in keys.items()
        if key in (chance.smaller, chance.larger) and name != 'new')
    assert tried == first
