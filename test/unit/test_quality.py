# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
How far a registration may be trusted.

Truth: rendered views in exact places, of which some are put wrong by a known motion.
"""

from dataclasses import replace
import json

import numpy as np
import pytest
from reference.posed import around, capture_from, posed, wronged
from ros_rops.core.config import Config
from ros_rops.core.errors import ParameterError
from ros_rops.core.types import SensorModel
from ros_rops.modelling.posed import resolution_of
from ros_rops.modelling.quality import assess
from ros_rops.modelling.residuals import weighted_median
from ros_rops.modelling.standing import judge as judge_views
from ros_rops.recordings.procedural import mesh_of
from ros_rops.recordings.synthetic import Model
from scipy.spatial.transform import Rotation


def judge(views, **options):
    resolution, threads = resolution_of(views), options.get('threads', 0)
    standing = judge_views(views, Config(), resolution=resolution, threads=threads)
    return assess(views, standing, None, Config(), resolution=resolution, **options)


def of_sensor(views, sensor):
    """Return the views with another idea of where their rays come from."""
    return tuple(
        replace(one, view=replace(one.view, sensor=sensor), weights=one.weights)
        for one in views)


@pytest.fixture(scope='module')
def right():
    return judge(around('blob'))


def test_right_views_are_confirmed(right):
    assert right.worst_views == ()
    for one in right.views:
        alone, confirmed, contradicted = one.shares
        assert confirmed > 0.7 and contradicted < 0.06
        assert abs(alone + confirmed + contradicted - 1.0) < 1e-9
        assert not any('contradicted' in flag for flag in one.flags)


def test_the_scale_is_that_of_the_noise(right):
    # 0.3 mesh resolutions along the ray in both views; less across a surface seen at an angle,
    # and where a triangle averages three points.
    assert 0.4 < right.noise / (np.sqrt(2) * 0.3 * right.resolution) < 1.0
    medians = [one.residual['median'] for one in right.views]
    assert max(medians) < right.noise


@pytest.mark.parametrize('wrong', [
    {'shift_mr': 2.0}, {'shift_mr': 20.0}, {'degrees': 5.0}, {'degrees': 30.0}])
@pytest.mark.parametrize('name', ['blob', 'bracket'])
def test_a_wrong_view_stands_out_alone(name, wrong):
    views = wronged(around(name), 4, **wrong, seed=2)
    found = judge(views)
    assert found.worst_views == (views[4].name,)
    worst = found.views[4]
    assert worst.shares[2] == max(one.shares[2] for one in found.views)
    assert worst.residual['median'] == max(one.residual['median'] for one in found.views)
    assert any('contradicted' in flag or 'would move it' in flag for flag in worst.flags)
    assert views[4].name in found.summary


def test_a_shift_is_measured():
    views = wronged(around('blob'), 4, shift_mr=2.0)
    flags = ' '.join(judge(views).views[4].flags)
    asked = float(flags.partition('(')[2].split(' mesh')[0])
    assert 1.6 < asked < 2.3


def test_two_wrong_views_are_both_found():
    views = wronged(wronged(around('blob'), 2, degrees=8.0), 7, shift_mr=6.0, seed=4)
    assert set(judge(views).worst_views) == {views[2].name, views[7].name}


def test_of_two_views_it_is_not_told_which_is_wrong():
    views = around('blob', count=9)
    nearest = min(
        range(1, 9), key=lambda k: np.linalg.norm(
            views[k].T_object_view[:3, 3] - views[0].T_object_view[:3, 3]))
    pair = (views[0], views[nearest])
    assert judge(pair).worst_views == ()
    found = judge(wronged(pair, 1, shift_mr=4.0))
    assert set(found.worst_views) == {one.name for one in pair}
    assert all('cannot be told' in ' '.join(one.flags) for one in found.views)


def vase(points):
    radius, height = np.hypot(points[..., 0], points[..., 1]), points[..., 2]
    return np.maximum(radius - (0.045 + 0.012 * np.sin(60 * height)), np.abs(height) - 0.07)


@pytest.fixture(scope='module')
def round_views():
    thing = Model(*mesh_of(vase, cell=0.003), name='vase')
    return posed([
        capture_from(thing, (np.cos(angle), np.sin(angle), 0.3), f'v{k}')
        for k, angle in enumerate(np.radians(np.arange(0, 360, 60)))])


def about_z(view, degrees, up=0.0):
    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec([0, 0, np.radians(degrees)]).as_matrix()
    motion[2, 3] = up
    return replace(view, T_object_view=motion @ view.T_object_view)


def test_turned_about_its_axis_a_round_body_is_said_not_to_be_held(round_views):
    """No measurement of shape can tell that a view of it is wrong; that it may be is said."""
    found = judge((*round_views[:3], about_z(round_views[3], 15.0), *round_views[4:]))
    assert found.worst_views == ()
    for one in found.views:
        assert one.least_constrained.kind == 'rotation' and not one.least_constrained.held
        assert abs(one.least_constrained.direction[2]) > 0.999
        assert any('turns about (0.00, 0.00, 1.00)' in flag for flag in one.flags)
    assert '6 views are hardly held' in found.summary


def test_slid_along_its_axis_a_round_body_is_found(round_views):
    up = 4.0 * resolution_of(round_views)
    found = judge((*round_views[:3], about_z(round_views[3], 0.0, up), *round_views[4:]))
    assert found.worst_views == ('v3',)
    # The others' maps do not hear it.
    assert max(one.shares[2] for one in found.views if one.name != 'v3') < 0.06


def test_residuals_have_the_sign_of_the_offset():
    """Points in front of the others' surface are positive: outside of the object."""
    views = list(around('blob'))
    middle = np.mean([one.points.mean(axis=0) for one in views], axis=0)
    out = views[3].points.mean(axis=0) - middle
    out /= np.linalg.norm(out)
    for way in (1.0, -1.0):
        moved = np.eye(4)
        moved[:3, 3] = way * 2.0 * resolution_of(views) * out
        shifted = [*views]
        shifted[3] = replace(views[3], T_object_view=moved @ views[3].T_object_view)
        residual = judge(shifted).residuals[3].residual
        assert way * np.nanmedian(residual) > 0.5 * resolution_of(views)


def test_unknown_sensors_are_judged_by_nearest_surfaces():
    views = of_sensor(around('blob', 9, 110), SensorModel('unknown'))
    assert judge(views).worst_views == ()
    wrong = of_sensor(wronged(around('blob', 9, 110), 4, shift_mr=3.0), SensorModel('unknown'))
    assert judge(wrong).worst_views == (wrong[4].name,)


def test_one_view_has_nobody_to_speak_of_it():
    found = judge(around('blob')[:1])
    one, = found.views
    assert one.residual is None and one.shares == (1.0, 0.0, 0.0)
    assert one.least_constrained is None and one.flags == ()
    assert found.edges == () and found.loops is None
    assert found.coverage.unseen_share > 0.4
    assert found.summary.startswith('1 view, no other to compare it with')


def test_views_that_do_not_overlap_say_so():
    views = around('blob')
    first = views[0].T_object_view[:3, 2]
    opposite = min(views, key=lambda one: one.T_object_view[:3, 2] @ first)
    found = judge((views[0], opposite))
    assert found.loops is None
    for one in found.views:
        assert 'no other view knows' in ' '.join(one.flags)
        assert one.least_constrained is None


def test_the_document_is_json_and_complete(right):
    document = json.loads(json.dumps(right.document(), allow_nan=False))
    assert {'mesh_resolution', 'views', 'worst_views', 'edges', 'loops', 'coverage', 'summary'} \
        <= set(document)
    for one in document['views']:
        assert set(one['residual']) == {'mean', 'median', 'p90', 'rms'}
        assert one['least_constrained']['kind'] in ('translation', 'rotation', 'screw')
    assert {one['source'] for one in document['edges']} <= {v['name'] for v in document['views']}


def test_threads_do_not_change_a_bit(right):
    for threads in (1, 3):
        other = judge(around('blob'), threads=threads)
        assert json.dumps(other.document()) == json.dumps(right.document())
        for a, b in zip(other.residuals, right.residuals, strict=True):
            assert a.residual.tobytes() == b.residual.tobytes()
            assert a.state.tobytes() == b.state.tobytes()


def test_weighted_median_against_sorting_repeated_values():
    rng = np.random.default_rng(0)
    values = rng.normal(size=(6, 50)).astype(np.float32)
    weights = rng.integers(1, 5, (6, 50)).astype(np.float32)
    values[rng.random((6, 50)) < 0.3] = np.nan
    values[:, 7] = np.nan
    found = weighted_median(values, weights)
    for k in range(50):
        known = np.isfinite(values[:, k])
        many = np.sort(np.repeat(values[known, k], weights[known, k].astype(int)))
        if len(many):
            assert found[k] == many[(len(many) - 1) // 2]
        else:
            assert np.isnan(found[k])


def test_no_view_is_a_callers_mistake():
    with pytest.raises(ParameterError, match='views'):
        judge_views((), Config(), resolution=1.0)


@pytest.mark.parametrize('resolution', [0.0, -1.0, np.nan])
def test_a_resolution_that_is_no_length_is_a_callers_mistake(resolution):
    with pytest.raises(ParameterError, match='resolution'):
        judge_views(around('blob')[:1], Config(), resolution=resolution)
