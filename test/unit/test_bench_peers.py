# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The contest with other programs. Truth: analytic (contestants told what to answer, counts)."""

import importlib.util
from itertools import combinations
import os

import numpy as np
import pytest
from reference.bench_sets import random_pose, Script, strip_set
from ros_rops.bench.__main__ import main
from ros_rops.bench.contest import Answer, Contestant, errors_in, prepare_all, run_pairs
from ros_rops.bench.evaluation import evaluate_pairs
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.peers import descriptor, pairs, views
from ros_rops.bench.peers.apart import processors, run_apart
from ros_rops.bench.peers.case import EXPERIMENTS
from ros_rops.bench.peers.extras import missing
from ros_rops.bench.peers.open3d_views import start_poses
from ros_rops.bench.peers.pair_run import PairJob, PairRounds, run_peer
from ros_rops.bench.peers.roster import OURS, ROSTER
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.core.types import Status
from ros_rops.recordings.writers import write_dataset

PEER = 'KISS-Matcher + small_gicp'


def silent(text):
    pass


def records_of(dataset, degrees, scores=None):
    """Let a contestant answer with so many degrees of error, refuse where None."""
    table = dict.fromkeys(combinations(dataset.views, 2))
    table.update(degrees)
    script = Script(dataset, table)

    def register(source, target):
        answer = script.register(source, target)
        numbers = (scores or {}).get((source.name, target.name), {})
        return Answer(answer.status, answer.T_target_source, answer.reason, numbers)

    contestant = Contestant('script', lambda view: view, register)
    prepared = prepare_all(contestant, dataset.views, silent)
    return run_pairs(contestant, evaluate_pairs(dataset), prepared, errors_in(dataset), silent)


def rounds_of(*records, peak=100.0):
    return PairRounds(
        tuple(map(tuple, records)), tuple((0.5, 1.5, 2.5, 9.5) for _ in records), peak, 60.0)


def test_a_line_counts_what_was_right_wrong_and_missed():
    dataset = strip_set()  # 0, 2 and 5 overlap, 30 with none
    a, b, c, d = dataset.views
    records = records_of(dataset, {(a, b): 0.0, (a, c): 9.0, (a, d): 0.0})
    case = pairs.case_of(PEER, dataset, rounds_of(records, records), None)
    assert (case['correct'], case['pairs'], case['pairs_all']) == (1, 3, 6)
    assert (case['accepted'], case['right_accepted']) == (3, 2)
    assert case['correct_by_overlap'] == {'0.1-0.3': 0, '0.3-0.6': 0, '0.6-1.0': 1}
    assert case['missed'] == [f'{a} > {c}', f'{b} > {c}']
    assert case['correct_of_rounds'] == [1, 1]
    assert (case['seconds_view'], case['ratio'], case['repeats']) == (2.0, None, 2)


def test_the_best_threshold_lets_nothing_wrong_through():
    dataset = strip_set()
    a, b, c, d = dataset.views
    degrees = {(a, b): 0.0, (a, c): 0.0, (b, c): 0.0, (a, d): 40.0}
    # By fitness two right ones stand above the wrong one, by residual one, by inliers none.
    scores = {
        (a, b): {'fitness': 0.9, 'inlier_rmse': 0.5, 'inliers': 5},
        (a, c): {'fitness': 0.8, 'inlier_rmse': 0.4, 'inliers': 6},
        (b, c): {'fitness': 0.3, 'inlier_rmse': 0.1, 'inliers': 7},
        (a, d): {'fitness': 0.7, 'inlier_rmse': 0.2, 'inliers': 9}}
    found = pairs.best_threshold(records_of(dataset, degrees, scores))
    assert found == {'score': 'fitness', 'correct': 2}
    # A score as good as a wrong pair's is no threshold; without a wrong pair none is wanted.
    scores[a, b]['fitness'] = scores[a, c]['fitness'] = 0.7
    assert pairs.best_threshold(records_of(dataset, degrees, scores)) == {
        'score': 'inlier_rmse', 'correct': 1}
    assert pairs.best_threshold(records_of(dataset, {(a, b): 0.0}, scores)) is None


def test_ratios_are_taken_pair_by_pair():
    found = pairs.ratio([1.0, 2.0, 4.0], [2.0, 8.0, 4.0])
    assert found == {'median': 2.0, 'lower': 1.5, 'upper': 3.0, 'total': 2.0}


def test_seconds_are_medians_over_the_rounds():
    rounds = PairRounds(((), (), ()), ((1.0, 5.0), (3.0, 4.0), (2.0, 9.0)), 1.0)
    assert rounds.seconds_of_views() == [2.0, 5.0]


def line(by, correct, **changes):
    dataset = strip_set()
    return {
        **pairs.case_of(by, dataset, rounds_of(records_of(dataset, {})), None),
        'correct': correct, 'pairs': 10, 'correct_of_rounds': [correct], **changes}


@pytest.mark.parametrize(('mine', 'best', 'said'), [
    (8, 8, False), (7, 8, True), (8, 7, True), (9, 7, False)])
def test_what_falls_short_of_the_best_peer_is_said(mine, best, said):
    # Below 0.75 ours must be better by 0.2.
    notes = pairs.notes([line(OURS, mine), line(PEER, best), line('other', 1)])
    assert bool(notes) == said


def test_tables_show_what_was_stored_and_varying_rounds_are_said():
    ratio = {'median': 2.0, 'lower': 1.5, 'upper': 3.0, 'total': 2.5}
    cases = [
        line(OURS, 10), {'by': 'gone', 'missing': 'gone: not installed'},
        line(PEER, 9, ratio=ratio, correct_of_rounds=[9, 8], accepted=10, right_accepted=9,
             own_threshold={'score': 'inliers', 'correct': 4})]
    text = pairs.show(cases)
    assert f'| {PEER} | 9/10' in text and '1 of 10' in text and '4 by inliers' in text
    assert '1.50-3.00' in text
    assert pairs.notes(cases) == [
        'gone: not installed', f'set, {PEER}: correct [9, 8] in the rounds']


@pytest.fixture
def nothing_installed(monkeypatch):
    real = importlib.util.find_spec
    gone = ('open3d', 'kiss_matcher', 'small_gicp')
    monkeypatch.setattr(
        importlib.util, 'find_spec', lambda name, *rest: None if name in gone else real(name))


@pytest.mark.usefixtures('nothing_installed')
def test_who_is_not_installed_is_reported():
    assert missing('A', ('numpy',)) is None
    assert 'kiss-matcher and small-gicp' in missing('A', ('numpy', 'kiss_matcher', 'small_gicp'))
    laboratory = Laboratory((), (), Config())
    cases = pairs.run(laboratory)
    assert [case['by'] for case in cases] == [name for name in ROSTER if name != OURS]
    assert len(pairs.notes(cases)) == len(ROSTER) - 1
    assert pairs.show(cases)
    cases = views.run(laboratory)
    assert 'open3d not installed' in views.notes(cases)[0]
    assert views.show(cases)


def test_pcl_missing_is_reported_and_ours_still_measured(monkeypatch, one_view):
    monkeypatch.setattr(descriptor, 'pcl_missing', lambda: 'no PCL here')
    cases = descriptor.run(Laboratory((one_view,), (), Config()))
    assert descriptor.notes(cases)[0] == 'no PCL here'
    assert [case.get('threads') for case in cases] == [None, 1, 2]
    assert cases[1]['ours_ms'] > 0 and 'pcl_ms' not in cases[1]
    assert '| one/' in descriptor.show(cases)


@pytest.fixture
def one_view():
    """Return a set of one view: a wavy field, 45 points a side."""
    from ros_rops.bench.truth import ReferenceSet
    from ros_rops.core.types import RangeView

    x, y = np.meshgrid(np.arange(45.0), np.arange(45.0), indexing='ij')
    points = np.stack([x, y, 3 * np.sin(x / 5) * np.cos(y / 7)], axis=-1)
    return ReferenceSet(
        'one', 'mm', 'exact', {'view': RangeView('view', points.reshape(-1, 3), units='mm')},
        {'view': np.eye(4)}, 1.0)


def test_agreement_is_the_correlation_of_rows():
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(4, 30))
    other = 2 * rows + 1
    other[3] = rng.normal(size=30)
    found = descriptor.agreement_of(rows, other)
    assert found['correlation_median'] == pytest.approx(1.0)
    assert found['share_alike'] == 0.75


def case_of_views(by, residual, seconds, name='set'):
    return {
        'set': name, 'by': by, 'placed': 4, 'views': 4, 'wrong_placements': 0,
        'mean_rotation_deg': 0.1, 'max_rotation_deg': 0.2, 'mean_translation_dres': 0.1,
        'max_translation_dres': 0.2, 'residual_dres': residual, 'attempts': 6,
        'seconds': seconds, 'peak_rss_mib': 100.4, 'libraries_mib': 50.0}


@pytest.mark.parametrize(('residual', 'seconds', 'said'), [
    (0.97, 20.0, []), (0.98, 20.0, ['residual 0.980 of its, the aim of 0.97']),
    (1.01, 4.0, ['residual 1.010 of its, the must of 1', 'seconds 4.000 times faster, the must']),
    (0.9, 6.0, ['seconds 6.000 times faster, the aim of 20'])])
def test_must_and_aim_of_many_views_are_checked(residual, seconds, said):
    cases = [case_of_views(OURS, residual, 1.0), case_of_views(views.EXACT, 1.0, seconds)]
    notes = views.notes(cases)
    assert len(notes) == len(said)
    assert all(part in note for part, note in zip(said, notes, strict=True))
    assert f'| {seconds:.3f} ' in views.show(cases)


def test_open3d_starts_from_the_best_fitting_chain():
    rng = np.random.default_rng(6)
    world = [random_pose(rng) for _ in range(4)]
    # The pair 0-3 is wrong and fits badly; the chain 0-2-1-3 is right.
    fits = {
        (i, j): (fitness, np.linalg.inv(world[j]) @ world[i] if right else random_pose(rng))
        for i, j, fitness, right in (
            (0, 2, 0.9, True), (1, 2, 0.8, True), (1, 3, 0.7, True), (0, 3, 0.2, False))}
    for pose, truth in zip(start_poses(4, fits), world, strict=True):
        np.testing.assert_allclose(pose, np.linalg.inv(world[0]) @ truth, atol=1e-9)


def test_open3d_leaves_a_view_that_no_pair_reaches_where_it_is():
    fits = {(0, 1): (0.5, random_pose(np.random.default_rng(3)))}
    np.testing.assert_array_equal(start_poses(3, fits)[2], np.eye(4))
    assert len(start_poses(2, {})) == 2


@pytest.mark.skipif(not hasattr(os, 'sched_getaffinity'), reason='no affinity on this system')
def test_a_process_apart_runs_on_as_many_processors_as_asked_for():
    before = os.sched_getaffinity(0)
    count, libraries = run_apart(
        os.sched_getaffinity, 0, modules=('numpy',), threads=1)
    assert len(count) == 1
    assert libraries > 5
    assert os.sched_getaffinity(0) == before
    with processors(0):
        assert os.sched_getaffinity(0) == before


def test_ours_is_run_apart_and_its_records_come_back(one_view):
    from dataclasses import replace

    view = one_view.views['view']
    both = replace(
        one_view, views={'view': view, 'same': replace(view, name='same')},
        T_world_view={'view': np.eye(4), 'same': np.eye(4)})
    found = run_peer(ROSTER[OURS], PairJob(
        OURS, both, tuple(evaluate_pairs(both)), Config(), 1, 2))
    assert [len(one) for one in found.records] == [1, 1]
    assert found.records[0][0].status in tuple(Status)
    assert found.records[0][0].truth.overlap == 1.0
    assert found.peak_rss_mib > found.libraries_mib > 10
    assert len(found.seconds()) == 1 and found.seconds()[0] > found.seconds_of_pairs()[0] > 0


@pytest.mark.parametrize(('words', 'said'), [
    (['--mesh', 'x.ply'], '--mesh'), (['--repeats', '0'], '--repeats'),
    (['--threads', '-1'], '--threads')])
def test_what_it_cannot_do_is_refused(tmp_path, capsys, words, said):
    one = strip_set()
    write_dataset(tmp_path / 's', list(one.views.values()), one.T_world_view, units='m')
    assert main(['peers', str(tmp_path / 's'), *words]) == 2
    assert said in capsys.readouterr().err


def test_a_set_of_one_view_has_no_pairs_and_is_named(one_view):
    with pytest.raises(InputError, match='one: expected at least two views'):
        pairs.run(Laboratory((one_view,), (), Config()))


def test_every_experiment_has_its_place():
    assert [one.name for one in EXPERIMENTS] == [
        'peers_pairs', 'peers_views', 'peers_descriptor']
