# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The scaling case. Truth: analytic series; a session of rendered views with exact poses."""

import json
import math

import numpy as np
import pytest
from ros_rops.bench.__main__ import main
from ros_rops.bench.scaling.law import fit_law
from ros_rops.bench.scaling.objects import objects_experiment, share
from ros_rops.bench.scaling.sessions import measure, session_job
from ros_rops.bench.scaling.shapes import captures_of, distinct_models, RADIUS_M
from ros_rops.bench.scaling.views import notes_on, views_experiment
from ros_rops.bench.stored import stored_sections
from ros_rops.core.config import Config
from ros_rops.recordings.synthetic import Model

SIZES = (10, 20, 50, 100, 200)


@pytest.mark.parametrize('exponent', [0.0, 1.0, 1.2, 2.0])
def test_an_exact_power_law_is_found(exponent):
    law = fit_law(SIZES, [0.3 * size**exponent for size in SIZES])
    assert law.exponent == pytest.approx(exponent, abs=1e-9)
    assert law.error == pytest.approx(0.0, abs=1e-9)
    assert law.factor == pytest.approx(0.3)


def test_the_standard_error_is_that_of_the_scatter():
    rng = np.random.default_rng(1)
    errors, misses = [], []
    for _ in range(400):
        law = fit_law(SIZES, [
            2.0 * size**1.1 * math.exp(rng.normal(0.0, 0.1)) for size in SIZES])
        errors.append(law.error**2)
        misses.append(law.exponent - 1.1)
    spread = np.log(SIZES) - np.log(SIZES).mean()
    true = 0.1 / math.sqrt(spread @ spread)
    assert abs(np.mean(misses)) < 4 * true / 20
    assert math.sqrt(np.mean(errors)) == pytest.approx(true, rel=0.15)
    assert np.std(misses) == pytest.approx(true, rel=0.15)


def test_what_is_unknown_does_not_count():
    assert fit_law((1, 2, 4), (1.0, None, 16.0)).exponent == pytest.approx(2.0)
    assert math.isnan(fit_law((1, 2), (1.0, 2.0)).error)
    assert str(fit_law((1, 2), (1.0, 2.0))) == '1.00'
    assert fit_law((3, 3), (1.0, 2.0)) is None
    assert fit_law((1, 2), (0.0, 2.0)) is None


def test_views_are_shared_out_and_neighbours():
    assert [share(80, 3, k) for k in range(3)] == [27, 27, 26]
    given = Model(np.eye(4)[:, :3] * 7 + 3, np.zeros((1, 3), int), units='mm')
    model, = distinct_models([given], 1)
    assert model.units == 'm'
    assert model.radius == pytest.approx(RADIUS_M)
    assert np.abs(model.middle).max() < 1e-12


@pytest.fixture(scope='module')
def few():
    """Measure a session of eight rendered views in this process."""
    model, = distinct_models([], 1)
    captures = captures_of(model, 8, pixels=150, seed=0)

    class Settings:
        seed, config, threads = 0, Config(), 2

    return captures, measure(session_job(captures, Settings))


def test_registrations_of_one_object_are_few(few):
    _, case = few
    assert (case['views'], case['placed'], case['wrong_placements']) == (8, 8, 0)
    assert case['splits'] == 0
    assert case['attempts'] <= 1.3 * 8
    assert sum(case['attempts_by_word'].values()) == case['attempts']


def test_a_few_of_an_object_lie_together(few):
    captures, _ = few
    directions = np.array([one.T_world_view[:3, 2] for one in captures])
    assert (directions @ directions[0]).min() > -0.9
    assert (np.sort(directions @ directions.T, axis=1)[:, -2] > 0.4).all()


def case_of(size, seconds, **changes):
    return {
        'views': size, 'objects': 1, 'points_per_view': 9000.0, 'seconds': seconds,
        'seconds_add': seconds, 'seconds_finish': 0.0, 'cpu_seconds': seconds,
        'peak_rss_mib': 100.0, 'session_mib': float(size), 'attempts': size - 1, 'placed': size,
        'wrong_placements': 0, 'wrong_merges': 0, 'splits': 0, **changes}


def test_exponents_are_shown_and_what_falls_short_is_said(tmp_path):
    good = [case_of(size, 0.2 * size**1.1) for size in SIZES]
    bad = [case_of(size, 0.2 * size**1.5, attempts=2 * size, placed=size - 1) for size in SIZES]
    one = views_experiment()
    assert '1.10' in one.show(good) and '| must ' in one.show(good)
    assert notes_on(good) == [
        'registrations: at most 0.99 N (must 1.3 N), above N + 2 in 0 of 5 runs']
    said = ' '.join(notes_on(bad))
    assert 'not reached' in said and '1.50' in said and '9 of 10 placed' in said
    for name in ('a.svg', 'b.svg'):
        one.plot(good, tmp_path / name)
    assert (tmp_path / 'a.svg').read_bytes() == (tmp_path / 'b.svg').read_bytes()
    assert 'exponent' in objects_experiment().show(good)


def test_the_case_runs_and_its_result_can_be_shown_again(tmp_path, capsys):
    words = ['scaling', '--views', '2', '4', '--only', 'scaling_views', '--pixels', '100', '--out',
             str(tmp_path), '--threads', '1', '--quiet']
    assert main(words) == 0
    shown = capsys.readouterr().out
    content = json.loads((tmp_path / 'scaling_views.json').read_text())
    assert [case['views'] for case in content['cases']] == [2, 4]
    assert content['command'].endswith('--views 2 4 --pixels 100 --threads 1')
    assert stored_sections(tmp_path)['scaling_views'] in shown
    assert (tmp_path / 'scaling_views.svg').stat().st_size > 1000


@pytest.mark.parametrize('words', [
    ['--views', '1'], ['--objects', '0'], ['--total', '10'], ['--pixels', '3']])
def test_senseless_sizes_are_refused(words, capsys):
    assert main(['scaling', *words]) == 2
    assert words[0] in capsys.readouterr().err
