# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Sets made worse, and Fig. 6 and 8. Truth: statistics, an analytic surface, counts by hand."""

from dataclasses import replace
import json

import numpy as np
import pytest
from reference.surfaces import bumps, height_view
from ros_rops.bench.contest import Answer, Contestant
from ros_rops.bench.disturbed import decimated, noisy
from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.paper import fig6, fig8, robustness
from ros_rops.bench.rivals.descriptor import Descriptor
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.core.errors import ParameterError, ViewError
from ros_rops.core.types import RangeView, Status

NOISE, FEWER = fig6.EXPERIMENT, fig8.EXPERIMENT
BINS = ('0.1-0.3', '0.3-0.6', '0.6-1.0')


def twins(shape=(45, 48)):
    """Return a set of two equal views."""
    view = height_view(bumps, shape, jitter=0.2)
    views = {name: replace(view, name=name) for name in ('a', 'b')}
    return ReferenceSet('twins', 'm', 'exact', views, dict.fromkeys(views, np.eye(4)), 1.3)


def test_noise_is_gaussian_of_so_many_dres_on_every_coordinate():
    clean = twins()
    worse = noisy(clean, 0.5, seed=4)
    for name, view in worse.views.items():
        error = view.points - clean.views[name].points
        # Of 2160 samples a coordinate: the estimate is off by 1.5 percent.
        np.testing.assert_allclose(error.std(axis=0), 0.5 * 1.3, rtol=0.08)
        assert np.abs(error.mean(axis=0)).max() < 0.08
        assert np.abs(np.corrcoef(error.T) - np.eye(3)).max() < 0.08
        assert view.grid is clean.views[name].grid and view.sensor == clean.views[name].sensor
    assert worse.T_world_view is clean.T_world_view and worse.dres == 1.3
    assert not np.array_equal(worse.views['a'].points, worse.views['b'].points)


def test_stronger_noise_is_the_same_noise_scaled():
    clean = twins()
    points = clean.views['a'].points
    weak, strong, other = (
        noisy(clean, sigma, seed).views['a'].points - points
        for sigma, seed in ((0.25, 1), (1.0, 1), (0.25, 2)))
    np.testing.assert_allclose(strong, 4 * weak, atol=1e-12)
    assert not np.allclose(weak, other)
    assert noisy(clean, 0.0, 1) is clean
    for wrong in (-0.1, float('nan'), float('inf')):
        with pytest.raises(ParameterError, match='sigma_dres'):
            noisy(clean, wrong, 0)


def test_decimation_leaves_its_share_of_the_vertices_on_the_surface():
    pytest.importorskip('open3d', reason='no open3d here')
    clean = twins()
    parts = (1, 2, 4, 8, 16)
    for part, worse in zip(parts, decimated(clean, parts), strict=True):
        assert worse.dres == clean.dres and worse.T_world_view is clean.T_world_view
        if part == 1:
            assert worse is clean
            continue
        view = worse.views['a']
        assert view.grid is None and view.sensor == clean.views['a'].sensor
        assert 0.9 * 2160 / part <= len(view.points) <= 2160 / part
        x, y, z = view.points.T
        # Bent by at most 0.35, chords of sqrt(part) are 0.35 * part / 8 off; half of that.
        assert np.abs(z - bumps(x, y)).mean() < 0.022 * part
        assert x.min() > -0.5 and x.max() < 47.5 and y.min() > -0.5 and y.max() < 44.5


@pytest.mark.parametrize('parts', [(2, 1), (0, 1), (1, 1)])
def test_parts_rise_from_one(parts):
    with pytest.raises(ParameterError, match='parts'):
        list(decimated(twins(), parts))


def test_a_view_that_cannot_be_prepared_refuses_its_pairs():
    def prepare(view):
        if view.name == 'bad':
            raise ViewError('nothing in it')
        return view.name

    one = robustness.forgiving(Contestant(
        'x', prepare, lambda source, target: Answer(Status.PLACED, np.eye(4))))
    good, bad = (one.prepare(RangeView(name, np.zeros((1, 3)))) for name in ('good', 'bad'))
    assert one.register(good, good).status is Status.PLACED
    for source, target in ((good, bad), (bad, good)):
        answer = one.register(source, target)
        assert answer.status is Status.REFUSED and answer.T_target_source is None


def test_samples_are_the_same_for_all_levels():
    truths = [PairTruth('i', str(k), 0.01 * (k % 100), np.eye(4)) for k in range(200)]
    found = robustness.tried(truths, 3)
    assert [pair.evaluated for pair in found] == [True] * 180 + [False] * 20
    assert robustness.tried(truths[:10], 3) == truths[:10]
    bins = robustness.compared_pairs(truths, 3)
    assert len(bins) == 36 and found == robustness.tried(truths, 3)
    assert bins == robustness.compared_pairs(truths, 3) != robustness.compared_pairs(truths, 4)


def test_a_run_measures_every_level_once(monkeypatch):
    place = Descriptor(
        'place', 'nobody',
        lambda mesh, indices, lrfs, unit, threads: mesh.vertices[indices].astype(np.float32))
    absent = Descriptor('absent', 'nobody', None, lambda: 'libnothing is not installed')
    monkeypatch.setattr(robustness, 'rival_descriptors', lambda radius: (absent, place))

    def empty(one):  # The second level leaves views in which there is no mesh.
        return replace(one, views={
            name: replace(view, points=view.points[:2], grid=None)
            for name, view in one.views.items()})

    few = replace(
        fig6.NOISE, labels={0.0: '0', 1.0: '1'}, compared=(0.0,),
        worsened=lambda one, seed: iter((one, empty(one))))
    laboratory = Laboratory((twins(),), (), Config(), threads=1)
    cases = robustness.robustness_cases(laboratory, few)
    json.dumps(cases)
    assert cases[0] == {'by': 'absent', 'missing': 'libnothing is not installed'}
    assert [(case['level'], case['by']) for case in cases[1:]] == [
        (0.0, 'engine'), (0.0, 'RoPS'), (0.0, 'place'), (1.0, 'engine')]
    assert [case['correct'] for case in cases[1:]] == [1, 1, cases[3]['correct'], 0]
    assert cases[1]['correct_by_overlap'] == dict(zip(BINS, (0, 0, 1), strict=True))
    assert (cases[1]['unprepared'], cases[4]['unprepared']) == (0, 2)
    assert cases[4]['keypoints'] is None and cases[4]['mr_dres'] is None
    assert cases[1]['mr_dres'] == pytest.approx(1.3 / 1.3, rel=0.15)
    monkeypatch.setattr(robustness, 'prepare_all', None)
    alone = replace(few, labels={1.0: '1'}, compared=(1.0,), worsened=lambda one, seed: [one])
    again = robustness.robustness_cases(laboratory, alone)
    assert again[1:] == [{**case, 'level': 1.0} for case in cases[1:4]]


def test_without_open3d_it_is_said(monkeypatch, tmp_path):
    monkeypatch.setattr('importlib.util.find_spec', lambda name: None)
    lab = Laboratory((twins(),), (), Config())
    few = replace(fig8.VERTICES, worsened=None)
    cases = robustness.robustness_cases(lab, few)
    assert len(cases) == 1 and list(cases[0]) == ['missing'] and 'open3d' in cases[0]['missing']
    assert FEWER.notes(cases) == [cases[0]['missing']]
    assert 'Not measured' in FEWER.show(cases)
    FEWER.plot(cases, tmp_path / 'empty.svg')


@pytest.mark.parametrize('experiment', [NOISE, FEWER], ids=lambda one: one.name)
def test_no_data_set_is_said_and_stops_nothing(experiment, tmp_path):
    pytest.importorskip('open3d', reason='no open3d here')
    cases = experiment.run(Laboratory((), (), Config()))
    assert cases == [] and isinstance(experiment.show(cases), str)
    assert experiment.notes(cases) == ['no data set with real views was given']
    experiment.plot(cases, tmp_path / 'empty.svg')


def line(dataset, level, correct, by='engine', **more):
    counts = dict(zip(BINS, (0, 10, 10), strict=True))
    return {
        'level': level, 'set': dataset, 'by': by, 'correct': correct, 'pairs': 20,
        'pairs_by_overlap': counts, 'correct_by_overlap': {**counts, '0.3-0.6': correct - 10},
        'rotation_deg': 0.1 * correct, 'translation_dres': None, 'sampled': 5, 'wrong': [],
        'wrong_sampled': [], 'prepared': 3, 'unprepared': 1, 'keypoints': 100.4, 'mr_dres': 1.5,
        **more}


def made_up(levels, compared):
    """Return lines of two sets: x keeps all, y loses 2 a level from its 20; descriptors of y."""
    cases = [line('x', level, 18) for level in levels]
    cases += [line('y', level, 20 - 2 * k) for k, level in enumerate(levels)]
    cases += [line('y', level, 18 - k, 'RoPS') for k, level in enumerate(compared)]
    return cases + [line('y', level, 17, 'SHOT') for level in compared]


def cells(text, row):
    """Return the cells of the first table row that begins with `row`."""
    found = next(one for one in text.splitlines() if one.startswith(f'| {row} '))
    return [cell.strip() for cell in found.strip('|').split('|')]


def test_tables_say_what_was_counted():
    cases = made_up((0.0, 0.25, 0.5, 0.75, 1.0), (0.0, 0.5, 1.0))
    cases[9] |= {'wrong': [['a', 'b']], 'wrong_sampled': [['c', 'd']]}
    first, together, alone = (NOISE.show(cases)).split('\n\n')[0:5:2]
    assert cells(first, 'y') == [
        'y', '20/20', '18/20 (0.90)', '16/20 (0.80)', '14/20 (0.70)', '12/20 (0.60)']
    assert cells(first, 'together')[1:3] == ['38/40', '36/40 (0.95)']
    assert cells(first, 'must keep') == ['must keep', '-', '-', '0.95', '-', '0.75']
    # Degrees: (18 * 1.8 + 12 * 1.2) / 30.
    assert cells(together, '1.0') == [
        '1.0', '0/0', '10/20', '20/20', '1 of 40', '1 of 10', '1.560', '-', '100', '1.500',
        '2 of 8']
    assert cells(alone, 'SHOT') == [
        'SHOT', '17/20', '17/20 (1.00)', '17/20 (1.00)', '0 of 60']
    assert cells(alone, 'RoPS')[3] == '16/20 (0.89)'
    assert NOISE.notes(cases) == [
        'y: keeps 0.800 at 0.5, at least 0.95 was asked.',
        'together: keeps 0.895 at 0.5, at least 0.95 was asked.',
        'y: keeps 0.600 at 1.0, at least 0.75 was asked.',
        'engine, y, 1.0: 2 wrong accepted: a - b, c - d.',
        'Features alone, 1.0: SHOT has 1 more than RoPS.']


def test_a_missing_rival_is_named_beside_what_was_measured():
    cases = [{'by': 'USC', 'missing': 'no PCL'}, line('x', 1.0, 18), line('x', 8.0, 17)]
    assert FEWER.notes(cases) == ['USC: no PCL']
    shown = cells(FEWER.show(cases), 'x')
    assert shown == ['x', '18/20', '-', '-', '17/20 (0.94)', '-', '-']


def test_a_plot_has_the_same_bytes_for_the_same_numbers(tmp_path):
    cases = made_up((1.0, 2.0, 4.0, 8.0, 16.0), (1.0, 8.0, 16.0))
    for name in ('a', 'b'):
        FEWER.plot(cases, tmp_path / 'new' / f'{name}.svg')
    first, second = ((tmp_path / 'new' / f'{name}.svg').read_bytes() for name in 'ab')
    assert first == second and b'SHOT' in first and b'1/16' in first
