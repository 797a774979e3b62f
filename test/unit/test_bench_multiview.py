# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The multiview and synthetic cases. Truth: analytic (a session that knows the poses)."""

import numpy as np
import pytest
from reference.bench_sets import Oracle, strip_set
from ros_rops.bench.multiview import (
    make_jobs, multiview_table, named_views, run_apart, run_job, shuffled)
from ros_rops.bench.synthetic import make_job
from ros_rops.core.config import Config
from ros_rops.recordings.synthetic import Model

KEYS = {
    'datasets', 'order', 'views', 'placed', 'wrong_placements', 'wrong_merges', 'splits',
    'mean_rotation_deg', 'max_rotation_deg', 'mean_translation_dres', 'max_translation_dres',
    'attempts', 'seconds', 'peak_rss_mib'}


def jobs_of(*sets, orders=0):
    return make_jobs(sets, Config(), orders=orders, seed=4, threads=1)


def test_two_sets_in_different_units_are_judged_in_their_own():
    job, = jobs_of(strip_set('a', 'm', (0, 2, 4)), strip_set('b', 'mm', (0, 3), seed=8))
    case = run_job(job, Oracle)
    assert set(case) >= KEYS
    assert (case['views'], case['placed'], case['attempts']) == (5, 5, 12)
    assert (case['wrong_placements'], case['wrong_merges'], case['splits']) == (0, 0, 0)
    assert case['max_rotation_deg'] < 1e-6
    assert case['max_translation_dres'] < 1e-6
    assert [one['label'] for one in case['objects']] == ['a', 'b']
    assert case['seconds'] >= 0
    assert case['peak_rss_mib'] > 5


def test_a_merging_session_is_caught():
    job, = jobs_of(strip_set('a', starts=(0, 2)), strip_set('b', starts=(0, 3), seed=8))
    case = run_job(job, lambda given: Oracle(given, merge=True))
    assert (case['wrong_merges'], case['splits']) == (1, 0)


def test_orders_are_random_complete_and_repeatable():
    sets = (strip_set('a', starts=range(0, 20, 2)), strip_set('b', starts=(0, 3)))
    names = [view.name for view in named_views(sets)]
    assert len(set(names)) == 12
    jobs = jobs_of(*sets, orders=3)
    orders = [tuple(view.name for view in job.views) for job in jobs]
    assert [job.order for job in jobs] == ['seed 4', 'seed 5', 'seed 6']
    assert len(set(orders)) == 3
    assert all(sorted(order) == sorted(names) and list(order) != names for order in orders)
    assert orders == [tuple(v.name for v in job.views) for job in jobs_of(*sets, orders=3)]
    given, = jobs_of(*sets)
    assert [view.name for view in given.views] == names


def test_a_process_of_its_own_finds_the_same():
    job, = jobs_of(strip_set('a', starts=(0, 2, 4)))
    here, there = run_job(job, Oracle), run_apart(job, Oracle)
    for name in ('placed', 'mean_rotation_deg', 'max_translation_dres', 'sequence'):
        assert here[name] == there[name]
    # What this process holds does not count there.
    ballast = np.ones(40_000_000)
    assert run_apart(job, Oracle)['peak_rss_mib'] < there['peak_rss_mib'] + 100
    assert ballast.nbytes > 300 * 2**20


def test_the_table_names_every_case():
    job, = jobs_of(strip_set('a', starts=(0, 2)))
    text = multiview_table([run_job(job, Oracle)])
    cells = [cell.strip() for cell in text.splitlines()[2].strip('|').split('|')]
    assert cells[:5] == ['a', 'ros_rops', 'given', '2/2', '0']


def sphere():
    from scipy.spatial import ConvexHull

    rng = np.random.default_rng(1)
    points = rng.normal(size=(400, 3))
    points *= 0.1 / np.linalg.norm(points, axis=1, keepdims=True)
    return Model(points, ConvexHull(points).simplices.astype(np.int32), name='ball')


@pytest.mark.parametrize('noise', [0.0, 0.5])
def test_rendered_views_come_with_their_exact_poses(noise):
    job = make_job(sphere(), noise, Config(), views=3, pixels=40, seed=2, threads=1)
    assert sorted(view.name for view in job.views) == sorted(job.known)
    for view in job.views:
        known = job.known[view.name]
        world = view.points @ known.T_world_view[:3, :3].T + known.T_world_view[:3, 3]
        off = np.abs(np.linalg.norm(world, axis=1) - 0.1)
        # The hull of 400 points of the sphere lies within 5 mm of it.
        assert np.median(off) < 0.005 + noise * known.dres
        assert known.points is view.points
    case = run_job(job, Oracle)
    assert (case['case'], case['placed']) == ('synthetic', 3)
    assert case['max_translation_dres'] < 1e-6


def test_noise_does_not_lengthen_the_measure_of_errors():
    clean, noisy = (
        make_job(sphere(), noise, Config(), views=2, pixels=40, seed=2, threads=1)
        for noise in (0.0, 0.5))
    assert {k.dres for k in clean.known.values()} == {k.dres for k in noisy.known.values()}


def test_shuffling_keeps_every_view():
    views = named_views([strip_set(starts=range(0, 12, 2))])
    assert sorted(v.name for v in shuffled(views, 1)) == sorted(v.name for v in views)
