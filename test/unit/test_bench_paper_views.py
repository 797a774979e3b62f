# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's experiments on many views. Truth: cases written by hand, and counting."""

import numpy as np
import pytest
from reference.bench_sets import Oracle, strip_set
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.multiview import run_job
from ros_rops.bench.paper import fig11, table3, table4, table5, table6
from ros_rops.bench.paper.many_views import (
    alike, job_of, kept, most_registrations, OURS, RIVALS)
from ros_rops.core.config import Config
from ros_rops.recordings.synthetic import Model


def cells(text, first):
    """Return the cells of the row that begins so."""
    row = next(line for line in text.splitlines() if line.startswith(f'| {first}'))
    return [cell.strip() for cell in row.strip('|').split('|')]


def case_of(name='s', by=OURS.name, order=1, views=10, attempts=9, **changes):
    errors = {'mean_rotation_deg': 0.5, 'mean_translation_dres': 0.25}
    one = {
        'views': views, 'placed': views, 'wrong_placements': 0, 'wrong_merges': 0, 'splits': 0,
        **errors, 'objects': [
            {'label': name, 'views': views, 'placed': views, **errors, 'residual_dres': 0.2}]}
    coarse = {**one, 'mean_rotation_deg': 0.75}
    return {
        **one, 'set': name, 'by': by, 'order': order, 'poses': 'exact', 'attempts': attempts,
        'seconds': 3.0, 'peak_rss_mib': 200.4, 'shapes': {'0': views}, 'coarse': coarse, **changes}


def laboratory(*sets):
    return Laboratory(tuple(sets), (), Config(), threads=1, seed=3)


def test_jobs_are_the_first_views_of_an_order():
    lab, one = laboratory(), strip_set(starts=range(0, 20, 2))
    whole, part = job_of(lab, [one], 5), job_of(lab, [one], 5, 4)
    assert [v.name for v in part.views] == [v.name for v in whole.views][:4]
    assert sorted(part.known) == sorted(v.name for v in part.views)
    assert [v.name for v in job_of(lab, [one]).views] != [v.name for v in whole.views]


def test_what_is_kept_says_what_it_was():
    job = job_of(laboratory(), [strip_set(starts=(0, 2, 4))])
    case = kept(run_job(job, Oracle), set='a', by='me')
    assert (case['set'], case['by'], case['placed'], case['attempts']) == ('a', 'me', 3, 12)
    assert case['objects'][0]['residual_dres'] is not None
    assert not {'errors', 'sequence'} & set(case)


def test_the_worst_ratio_is_told():
    said = most_registrations([case_of(), case_of('t', views=4, attempts=6)])
    assert 'at most 1.50 N (t, 6 for 4 views' in said
    assert 'must 1.3 N: 1 above; aim N + 2: none above' in said


def test_table3_has_coarse_before_fine():
    text = table3.EXPERIMENT.show([case_of()])
    row = cells(text, 's (exact)')
    assert row[:8] == [
        's (exact)', '100% (10/10)', '0, 0, 0', '0.750', '0.250', '0.200', '0.500', '0.250']
    assert cells(text, 'T-Rex')[3:5] == ['0.597', '2.005']


def test_table4_averages_over_sets_and_spans_orders():
    cases = [
        case_of('a'), case_of('a', order=2, attempts=12), case_of('b', mean_rotation_deg=1.0),
        case_of('a', by=RIVALS[1].name, attempts=45)]
    text = table4.EXPERIMENT.show(cases)
    assert cells(text, 'shape growing (order 1)')[1:4] == ['100% (20/20)', '0, 0, 0', '0.750']
    assert cells(text, 'shape growing (order 1)')[-2:] == ['0.465', '0.485']
    assert cells(text, 'spanning tree')[-2:] == ['0.280', '0.254']
    assert '9-12' in cells(text, 'a ')
    assert any('the strategy alone differs' in note for note in table4.EXPERIMENT.notes(cases))


@pytest.mark.parametrize(('views', 'expected'), [
    (10, [4, 6, 8, 10]), (15, [4, 8, 12, 15]), (24, [4, 8, 12, 16, 20, 24]), (3, [3])])
def test_subsets_end_with_all_views(views, expected):
    assert fig11.sizes(views) == expected


def test_fig11_is_drawn_the_same_every_time(tmp_path):
    cases = [case_of(views=n, attempts=n - 1) for n in (4, 10)] + [
        case_of(views=n, attempts=n * (n - 1) // 2, by=rival.name)
        for n in (4, 10) for rival in RIVALS] + [{'missing': 'nothing'}]
    for name in 'ab':
        fig11.EXPERIMENT.plot(cases, tmp_path / f'{name}.svg')
    assert (tmp_path / 'a.svg').read_bytes() == (tmp_path / 'b.svg').read_bytes()
    assert cells(fig11.EXPERIMENT.show(cases), 's ')[:5] == ['s', '4', '3', '6', '6']
    assert fig11.EXPERIMENT.notes(cases)[-1] == 'nothing'


def test_table5_shows_each_object_of_a_mixture():
    case = case_of(mixture='real', objects=case_of('a')['objects'])
    case['coarse']['objects'][0]['mean_rotation_deg'] = 0.75
    text = table5.EXPERIMENT.show([case, {'missing': 'x'}])
    assert cells(text, 'a (real)')[1:4] == ['100% (10/10)', '0.750', '0.250']
    assert cells(text, 'real')[1:6] == ['1', '1', '100% (10/10)', '0, 0, 0', '9']
    assert table5.EXPERIMENT.notes([{'missing': 'x'}]) == ['x']


def test_too_few_objects_are_not_mixed():
    found = table5.EXPERIMENT.run(laboratory(strip_set()))
    assert ['missing' in case for case in found] == [True, True]


def test_meshes_are_made_alike():
    vertices = np.array([[0, 0, 0], [30, 0, 0], [0, 40, 0]], float)
    model = alike(Model(vertices, np.array([[0, 1, 2]]), name='m', units='mm'))
    assert (model.units, model.name) == ('m', 'm')
    assert model.radius == pytest.approx(0.1)
    np.testing.assert_allclose(model.middle, 0, atol=1e-12)


def test_table6_says_which_meshes_are_missing():
    found = table6.EXPERIMENT.run(laboratory(strip_set('bunny'), strip_set('other')))
    said = table6.EXPERIMENT.notes(found)
    assert said[0] == 'bunny: no reference mesh (bun_zipper, by --mesh)'
    assert said[1] == 'other: no reference mesh exists'
    assert 'armadillo' in said[2]
    assert cells(table6.EXPERIMENT.show(found), 'bunny')[8:10] == ['1.429', '99.880']


def test_table6_shows_a_model():
    score = {'accuracy': 0.2, 'completeness': 0.995, 'completeness_seen': 1.0, 'median': 0.05}
    text = table6.EXPERIMENT.show([{
        'set': 'chef', 'given': 10, 'views': 10, 'error': None, 'score': score,
        'score_icp': {'accuracy': 0.1}, 'floor': 0.3, 'seconds_warm': 4.0, 'peak_rss_mib': 300.2}])
    assert cells(text, 'chef') == [
        'chef', '10/10', '0.200', '0.100', '0.300', '99.500', '100.000', '0.050', '0.623',
        '100.000', '4.000', '300']
