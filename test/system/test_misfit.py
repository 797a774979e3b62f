# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
A view in the wrong place is found by the others, taken back and put where it belongs.

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


def test_a_misplaced_view_is_taken_back_and_finds_its_place(session: Session) -> None:
    model = session.objects[0]
    poses = {view.name: view.T_object_view for view in model.views}
    first, wrong = model.views[0].name, model.views[2].name
    centre = session.views[wrong].points.mean(axis=0)
    session._growth.move(model.id, {**poses, wrong: turned(poses[wrong], centre, 40.0)})
    session.finish()
    words = {report.name: report for report in session.reports}
    assert all(words[name].status is Status.PLACED for name in poses)
    after = {view.name: view.T_object_view for view in session.objects[0].views}
    assert set(after) == set(poses)
    before, now = (np.linalg.inv(p[first]) @ p[wrong] for p in (poses, after))
    turn = Rotation.from_matrix(before[:3, :3].T @ now[:3, :3]).magnitude()
    assert np.degrees(turn) < 1.0
    session.remove(wrong)
    assert wrong not in {report.name for report in session.reports}
