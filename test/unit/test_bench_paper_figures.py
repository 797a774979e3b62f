# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Figures and tables of the paper's experiments. Truth: counted by hand; config/paper.yaml."""

from types import SimpleNamespace

from meta.tree import ROOT
import pytest
from ros_rops.bench.errors import PairErrors
from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.paper import fig4, fig5, fig9, table1, times
from ros_rops.bench.paper.engine_pairs import correct_errors, EnginePair, EngineRun, pair_case
from ros_rops.bench.paper.fig5 import by_overlap
from ros_rops.bench.paper.histograms import bars, below
from ros_rops.bench.paper.table1 import features_of, Score, within
from ros_rops.bench.paper.times import stage_seconds
from ros_rops.core.config import Config
from ros_rops.core.types import Status
from ros_rops.pipeline.attempt import Attempt
from ros_rops.pipeline.parameters import load_config

# Overlap, degrees, dres.
PAIRS = [
    [0.10, None, None], [0.199, 0.1, 0.2], [0.2, 0.3, 4.9], [0.3, 0.2, 5.0], [0.55, 5.0, 0.1],
    [0.9, 1.0, 1.0], [1.0, 0.25, 0.24]]
CASE = {'set': 'one', 'views': 4, 'pairs': PAIRS, 'pairs_all': 9, 'accepted': 6, 'wrong': 2}


def cells(text, row):
    """Return the cells of the first table row that begins with `row`."""
    line = next(line for line in text.splitlines() if line.startswith(f'| {row}'))
    return [cell.strip() for cell in line.strip('|').split('|')]


def test_bins_hold_their_lower_end():
    right, wrong = by_overlap(CASE)
    assert right == [1, 1, 0, 0, 0, 0, 0, 0, 2]
    assert wrong == [1, 0, 1, 0, 1, 0, 0, 0, 0]
    assert bars([0.0, 0.249, 0.25, 4.999, 5.0, 7.0]) == [2, 1, *[0] * 16, 0, 1]
    assert below([0.25, 0.24, 1.0, 1.99]) == [1, 2, 2, 4]


def test_errors_are_those_of_correct_pairs():
    assert correct_errors(CASE) == [(0.1, 0.2), (0.3, 4.9), (1.0, 1.0), (0.25, 0.24)]


def test_tables_say_what_was_counted():
    shown = cells(fig5.EXPERIMENT.show([CASE]), 'one')
    assert shown == ['one', '1/2', '1/1', '0/1', '-', '0/1', '-', '-', '-', '2/2', '4/7', '2 of 9']
    shown = cells(fig4.EXPERIMENT.show([CASE, {**CASE, 'set': 'two'}]), 'together')
    # Degrees 0.1, 0.3, 1.0, 0.25 and dres 0.2, 4.9, 1.0, 0.24, twice each.
    assert shown == [
        'together', '8', '0.412', '2', '6', '6', '8', '1.585', '4', '4', '4', '6']
    found = fig9.EXPERIMENT.show([CASE])
    assert cells(found, 'one') == ['one', '4', '7', '6', '2']


@pytest.mark.parametrize('experiment', [fig5.EXPERIMENT, fig9.EXPERIMENT])
def test_a_plot_has_the_same_bytes_for_the_same_numbers(experiment, tmp_path):
    for name in ('a', 'b'):
        experiment.plot([CASE, {**CASE, 'set': 'two'}, {**CASE, 'set': 'three'}],
                        tmp_path / 'new' / f'{name}.svg')
    first, second = ((tmp_path / 'new' / f'{name}.svg').read_bytes() for name in 'ab')
    assert first == second and b'<svg' in first and b'two' in first


def test_a_missing_mesh_is_said():
    cases = fig9.EXPERIMENT.run(Laboratory((), (), Config()))
    assert fig9.EXPERIMENT.notes(cases) == ['no mesh to render views from (--mesh)']
    assert '--mesh' not in fig9.EXPERIMENT.show(cases)


@pytest.mark.parametrize('experiment', [
    table1.EXPERIMENT, fig4.EXPERIMENT, fig5.EXPERIMENT, times.EXPERIMENT],
    ids=lambda one: one.name)
def test_no_data_set_is_said_and_stops_nothing(experiment, tmp_path):
    cases = experiment.run(Laboratory((), (), Config()))
    assert cases == [] and isinstance(experiment.show(cases), str)
    assert experiment.notes(cases) == ['no data set with real views was given']
    if experiment.plot is not None:
        experiment.plot(cases, tmp_path / 'empty.svg')


def pair(overlap, error, accepted=True):
    status = Status.PLACED if accepted else Status.REFUSED
    attempt = Attempt('a', 'b', status, '', {}, {'match': 0.1, 'quick': 0.2})
    return EnginePair(PairTruth('a', 'b', overlap, None), attempt, error)


def test_a_run_counts_wrong_pairs_of_all():
    run = EngineRun((
        pair(0.5, PairErrors(1.0, 1.0, 0.0)), pair(0.05, PairErrors(90.0, 9.0, 0.0)),
        pair(0.0, None, accepted=True), pair(0.4, None, accepted=False)), (0.1,))
    case = pair_case(SimpleNamespace(name='s', dres=1.0, views={}), run)
    assert (case['pairs_all'], case['accepted'], case['wrong']) == (4, 3, 2)
    assert case['pairs'] == [[0.5, 1.0, 1.0], [0.4, None, None]]
    assert stage_seconds(run) == {'match': [0.1] * 4, 'quick': [0.2] * 4}
    assert run.pairs[0].seconds == pytest.approx(0.3)


def test_thresholds_are_of_translation_with_five_degrees():
    assert within(PairErrors(4.9, 14.9, 0.0), 15) and not within(PairErrors(4.9, 15.0, 0.0), 15)
    assert not within(PairErrors(5.0, 0.1, 0.0), 15)
    score = Score()
    score.add(1.0, PairErrors(1.0, 3.5, 0.0), PairErrors(1.0, 0.5, 0.0))
    score.add(3.0, None, None)
    case = score.case('s', 'paper', 'CCV')
    assert case['coarse'] == [0, 0, 0, 1, 1, 1, 1, 1] and case['fine'] == [1] * 8
    assert (case['pairs'], case['none'], case['seconds_median']) == (2, 1, 2.0)
    shown = table1.EXPERIMENT.show([case])
    assert cells(shown, 'CCV')[:2] == ['CCV', '0.0 (39.2)']
    assert cells(shown, 'CCV')[4] == '50.0 (65.9)'
    assert cells(shown.split('Each set')[1], 'CCV') == ['CCV', "paper's", '1 / 1 of 2']


def test_times_show_the_paper_beside():
    case = {
        'set': 's', 'views': 10, 'pairs': 45, 'prepare': 0.1, 'pair': 0.2,
        'stages': {
            'match': {'pairs': 45, 'median': 0.02}, 'thorough': {'pairs': 9, 'median': 1.0}},
        'session': {'seconds': 3.0, 'runs': 1, 'placed': 10, 'attempts': 9,
                    'stages': {'prepare': 1.0, 'ccv': 0.0}}}
    text = times.EXPERIMENT.show([case])
    assert cells(text, 's') == ['s', '45', '0.100', '0.020', '1.000 (in 9)', '0.200']
    assert cells(text.split('whole set')[1], 's ') == ['s', '10/10', '9', '3.0', '0.30', '1.00']
    assert cells(text, 'Chef (paper)')[3:5] == ['1309', '60']


def test_features_alone_are_exchanged():
    stated = load_config(ROOT / 'config' / 'paper.yaml').to_flat()
    assert features_of(Config(), 'paper').to_flat() == stated
    own, default = features_of(Config(), 'ours').to_flat(), Config().to_flat()
    differ = {name for name in stated if own[name] != stated[name]}
    assert differ and all(name.startswith(('keypoints.', 'lrf.', 'rops.')) for name in differ)
    assert {own[name] == default[name] for name in differ} == {True}


def test_what_is_kept_is_made_once():
    laboratory, made = Laboratory((), (), Config()), []
    for _ in range(2):
        assert laboratory.once('key', lambda: made.append(1) or 'kept') == 'kept'
    assert made == [1]
