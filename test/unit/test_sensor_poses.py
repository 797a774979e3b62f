# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Sensor poses as a prior. Truth: captures rendered from known poses, and what is said wrong."""

from dataclasses import replace

import numpy as np
import pytest
from reference.captures import arc, error
from ros_rops.core.config import Config, PriorConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.se3 import rigid
from ros_rops.core.station import Known, poses_around
from ros_rops.core.types import Status
from ros_rops.intake.sensor_poses import with_sensor_poses
from ros_rops.pipeline.prepare import prepare
from ros_rops.pipeline.session import Session
from ros_rops.pipeline.units import in_units
from ros_rops.recordings.frames import frame_view, read_frames
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.view_facts import decode_facts, encode_facts, ViewFacts
from scipy.spatial.transform import Rotation

USED = replace(Config(), prior=PriorConfig(fixed_frame='hall'))
COUNT = 4


def motion(turn, shift):
    return rigid(Rotation.from_rotvec(turn).as_matrix(), np.asarray(shift, float))


# The hall's frame lies anywhere: only the poses of views to each other count.
HALL = motion([0.4, -1.0, 2.0], [3.0, -5.0, 1.0])


def said(poses, units='m'):
    """Return captures of which the sensor poses are said to be `poses` (None: not known)."""
    return [replace(capture.view, units=units, T_fixed_sensor=pose)
            for capture, pose in zip(arc('blob', COUNT), poses, strict=True)]


def right():
    return [HALL @ capture.T_world_view for capture in arc('blob', COUNT)]


def session_of(views, config=USED):
    session = Session(config, threads=2)
    for view in views:
        session.add(view)
    session.finish()
    return session


def worst(session):
    """Return the largest error, in deg, of the placed views of all objects."""
    captures = {capture.view.name: capture for capture in arc('blob', COUNT)}
    return max(
        (error(np.linalg.inv(one.T_object_view) @ other.T_object_view,
               captures[one.name], captures[other.name])[0]
         for shape in session.objects for one in shape.views for other in shape.views),
        default=0.0)


def poses_of(session):
    return [(view.name, view.T_object_view.tobytes())
            for shape in session.objects for view in shape.views]


@pytest.fixture(scope='module')
def off():
    return session_of(said([None] * COUNT), Config())


@pytest.fixture(scope='module')
def sides():
    return [prepare(view, USED, threads=2).surface for view in said(right())[:2]]


def test_right_poses_help_to_place(off):
    session = session_of(said(right()))
    assert [report.status for report in session.reports] == [Status.PLACED] * COUNT
    assert len(session.objects) == 1 and worst(session) < 0.5
    assert session.attempts <= off.attempts
    assert session.station['sensor_poses'] == COUNT
    assert 'not_believed' not in session.station


def test_poses_that_are_a_little_off_do_not_show_in_the_result():
    random = np.random.default_rng(2)
    shaken = [pose @ motion(random.normal(0, 0.04, 3), random.normal(0, 0.01, 3))
              for pose in right()]
    session = session_of(said(shaken))
    assert len(session.objects[0].views) == COUNT and worst(session) < 0.5


def test_wrong_poses_make_no_wrong_result(off):
    turned = [pose @ motion(Rotation.random(random_state=k).as_rotvec(), [0.1 * k, 0, 0])
              for k, pose in enumerate(right())]
    stood_still = [HALL] * COUNT  # a turntable that TF does not know of
    for poses in (turned, stood_still, [np.linalg.inv(pose) for pose in right()]):
        session = session_of(said(poses))
        assert worst(session) < 1.0
        assert 'not_believed' in session.station
        placed = sum(report.status is Status.PLACED for report in session.reports)
        assert placed == sum(report.status is Status.PLACED for report in off.reports)


def test_one_wrong_pose_is_objected_to():
    poses = right()
    poses[2] = poses[2] @ motion([0.0, 0.6, 0.0], [0.0, 0.0, 0.0])
    session = session_of(said(poses))
    statuses = [report.status for report in session.reports]
    assert statuses.count(Status.PLACED) == COUNT - 1 and worst(session) < 0.5
    assert statuses[2] is not Status.PLACED


@pytest.mark.parametrize(('config', 'poses'), [
    (USED, [None] * COUNT), (Config(), [np.eye(4)] * COUNT)])
def test_without_poses_or_unasked_all_is_as_ever(off, config, poses):
    assert poses_of(session_of(said(poses), config)) == poses_of(off)


def test_views_without_a_pose_find_their_place_among_others():
    poses = right()
    poses[1] = poses[2] = None
    session = session_of(said(poses))
    assert [report.status for report in session.reports] == [Status.PLACED] * COUNT
    assert worst(session) < 0.5 and session.station['sensor_poses'] == 2


def test_units_that_are_not_known_say_nothing_of_distances(off):
    views = said(right(), 'unknown')
    session = session_of(views)
    assert session.station['sensor_poses'] == 0
    assert poses_of(session) == poses_of(off)


@pytest.mark.parametrize('units', ['m', 'mm'])
def test_tolerances_are_in_degrees_and_metres(sides, units):
    """The blob is 0.2 m long; a turn is about the middle of the view."""
    metre = {'m': 1.0, 'mm': 1000.0}[units]
    source, target = (
        prepare(in_units(view, units), USED, threads=2).surface for view in said(right())[:2])
    known = Known(USED.prior, metre=metre)
    truth, middle = known.predicted(source, target), source.evidence.centre
    assert known.objection(truth, source, target) == ''

    def objection(degrees, metres):
        turn = Rotation.from_rotvec([0.0, np.radians(degrees), 0.0]).as_matrix()
        shift = np.array([metres * metre, 0.0, 0.0])
        return known.objection(
            truth @ rigid(turn, middle - turn @ middle + shift), source, target)

    assert objection(9.9, 0.0) == '' == objection(0.0, 0.049)
    assert objection(10.1, 0.0) == 'the pose contradicts the sensor poses in TF by 10.1 deg'
    assert objection(0.0, 0.051) == 'the pose contradicts the sensor poses in TF by 51.0 mm'
    assert Known(PriorConfig(), metre=metre).predicted(source, target) is None


def test_poses_tried_lie_around_the_one_said(sides):
    source, target = sides
    known = Known(USED.prior, metre=1.0)
    starts = known.starts(source, target, 2000, np.random.default_rng(0))
    np.testing.assert_allclose(starts[0], known.predicted(source, target), atol=1e-12)
    assert known.admits(starts, source, target, slack=1.0).all() and len(starts) == 500
    middle = np.array([1.0, 2.0, 3.0])
    poses = poses_around(np.eye(4), middle, 0.2, 0.5, 1000, np.random.default_rng(1))
    turns = Rotation.from_matrix(poses[:, :3, :3]).magnitude()
    moved = np.linalg.norm(poses[:, :3, :3] @ middle + poses[:, :3, 3] - middle, axis=1)
    assert turns[0] == moved[0] == 0.0
    assert 0.19 < turns.max() <= 0.2 and 0.49 < moved.max() <= 0.5


def test_a_shape_knows_where_it_stands_by_any_of_its_views():
    poses = right()
    poses[0] = None
    session = session_of(said(poses)[:2])
    [shape] = session._growth.objects().values()
    grown = session._growth._shapes.of(next(iter(session._growth._shapes.object_ids)))
    first = arc('blob', COUNT)[0 if shape.first == 'blob_0' else 1]
    found = grown.surface.T_fixed_surface
    turn = Rotation.from_matrix(found[:3, :3].T @ (HALL @ first.T_world_view)[:3, :3])
    assert np.degrees(turn.magnitude()) < 0.5


@pytest.mark.parametrize('bad', [
    np.eye(3), np.full((4, 4), np.nan), np.diag([1.0, 1.0, -1.0, 1.0]), 2.0 * np.eye(4),
    np.eye(4)[[0, 1, 3, 2]]])
def test_what_is_no_pose_is_refused(bad):
    view = arc('blob', COUNT)[0].view
    with pytest.raises(ShapeError, match='T_fixed_sensor'):
        replace(view, T_fixed_sensor=bad)
    facts = encode_facts(replace(ViewFacts('/a', 'view', 'a'), T_fixed_sensor=np.asarray(bad)))
    with pytest.raises(Exception, match='cannot be read'):
        decode_facts(facts)


def test_a_recording_keeps_it_bit_by_bit(tmp_path):
    views = said(right())
    path = tmp_path / 'a.mcap'
    with create_mcap(path) as mcap:
        for k, view in enumerate(views):
            mcap.add_view(view, topic='/points', log_time_ns=k)
    for view, frame in zip(views, read_frames(path), strict=True):
        back = frame_view(frame).view
        assert back.T_fixed_sensor.tobytes() == view.T_fixed_sensor.tobytes()
        assert not back.T_fixed_sensor.flags.writeable


def test_units_go_with_the_points():
    view = said(right())[1]
    scaled = in_units(view, 'mm').T_fixed_sensor
    np.testing.assert_allclose(scaled[:3, 3], 1000.0 * view.T_fixed_sensor[:3, 3])
    np.testing.assert_array_equal(scaled[:3, :3], view.T_fixed_sensor[:3, :3])


def test_what_tf_tells_goes_into_the_views():
    asked = []

    def lookup(target, source, stamp_ns):
        asked.append((target, source, stamp_ns))
        return HALL if stamp_ns == 7 else None

    view = replace(arc('blob', COUNT)[0].view, units='mm', stamp_ns=7, frame_id='eye')
    (found, kept), notes = with_sensor_poses(
        [view, replace(view, T_fixed_sensor=np.eye(4))], 'hall', lookup)
    np.testing.assert_allclose(found.T_fixed_sensor[:3, 3], 1000.0 * HALL[:3, 3])
    np.testing.assert_array_equal(kept.T_fixed_sensor, np.eye(4))
    assert notes == () and asked == [('hall', 'eye', 7)]
    for other, why in (
        (replace(view, stamp_ns=8), "TF does not tell where 'eye' was in 'hall'"),
        (replace(view, stamp_ns=None), 'no stamp'), (replace(view, units='unknown'), 'units'),
    ):
        [same], [note] = with_sensor_poses([other], 'hall', lookup)
        assert same.T_fixed_sensor is None and why in note
    assert with_sensor_poses([view], 'hall', None)[0][0].T_fixed_sensor is None
    assert with_sensor_poses([view], '', lookup) == ((view,), ())
