# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
A view in the wrong place is found by the others and taken back.

Truth: the wrong pose is put there by the test; the exact poses of the demo recording.
"""

from pathlib import Path

import numpy as np
import pytest
from ros_rops.core.types import Status
from ros_rops.pipeline.session import Session
from ros_rops.recordings import find_views
from scipy.spatial.transform import Rotation

DEMO = Path(__file__).resolve().parents[2] / 'bags' / 'demo.mcap'


@pytest.fixture(scope='module')
def session() -> Session:
    session = Session()
    for source in find_views([DEMO]):
        for noted in source.views():
            session.add(noted.view)
    return session


def turned(pose: np.ndarray, centre: np.ndarray, degrees: float) -> np.ndarray:
    """Turn a posed view about its own centre."""
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler('z', degrees, degrees=True).as_matrix()
    pivot = pose[:3, :3] @ centre + pose[:3, 3]
    turn[:3, 3] = pivot - turn[:3, :3] @ pivot
    return turn @ pose


def test_a_misplaced_view_is_taken_back_and_the_others_stay(session: Session) -> None:
    model = session.objects[0]
    poses = {view.name: view.T_object_view for view in model.views}
    wrong = model.views[2].name
    centre = session.views[wrong].points.mean(axis=0)
    session._growth.move(model.id, {**poses, wrong: turned(poses[wrong], centre, 40.0)})
    session.finish()
    words = {report.name: report for report in session.reports}
    assert words[wrong].status is Status.PENDING
    assert 'taken back' in words[wrong].reason
    assert all(words[name].status is Status.PLACED for name in poses if name != wrong)
    session.remove(wrong)
    assert wrong not in {report.name for report in session.reports}
