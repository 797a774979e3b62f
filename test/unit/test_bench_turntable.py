# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The turntable case. Truth: spheres, on which all points lie under the exact poses."""

import numpy as np
import pytest
from ros_rops.bench.turntable import make_job
from ros_rops.core.config import Config
from ros_rops.recordings.procedural import mesh_of
from ros_rops.recordings.station import Plan
from ros_rops.recordings.synthetic import Model


@pytest.mark.parametrize('noise', ['none', 'd435'])
def test_views_come_back_from_the_recording_with_their_truth(noise):
    ball = mesh_of(lambda p: np.linalg.norm(p, axis=-1) - 0.08, cell=0.004)
    models = [Model(ball[0] * size, ball[1], name=name, units='m')
              for name, size in (('large', 1.0), ('small', 0.5))]
    job = make_job(models, noise, Plan(views=3), (80, 60), Config(), seed=4, threads=1)
    assert set(job.datasets) == {'large', 'small'}
    assert {view.name for view in job.views} == job.known.keys()
    assert len(job.views) == 6
    for view in job.views:
        truth = job.known[view.name]
        radius = {'large': 0.08, 'small': 0.04}[truth.label]
        T = truth.T_world_view
        world = view.points @ T[:3, :3].T + T[:3, 3]
        off = np.linalg.norm(world, axis=1) - radius
        assert len(off) > 100
        assert np.median(np.abs(off)) < (2e-3 if noise == 'd435' else 1e-4)
        # 80 pixels across 56 degrees, 2.8 radii of the large ball away.
        assert 0.0025 < truth.dres < 0.0045
