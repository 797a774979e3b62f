# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The pairwise case. Truth: analytic (an engine that is told how wrong to be)."""

import argparse
from itertools import combinations
import json

import pytest
from reference.bench_sets import Script, strip_set
from ros_rops.bench import settings
from ros_rops.bench.contest import Contestant, cross_pairs, errors_in, prepare_all, run_pairs
from ros_rops.bench.evaluation import evaluate_pairs
from ros_rops.bench.machine import machine_facts, peak_rss_mib
from ros_rops.bench.pairwise import pairwise_table, run_cross, run_set
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError

KEYS = {
    'dataset', 'pairs', 'recall', 'precision', 'recall_by_overlap', 'rotation_deg',
    'translation_dres', 'seconds_per_pair', 'seconds_prepare'}


def silent(text):
    pass


def answers(dataset, **given):
    """Refuse all pairs but those given as `view00_view02=degrees`."""
    table = dict.fromkeys(combinations(dataset.views, 2))
    table.update({tuple(pair.split('_')): deg for pair, deg in given.items()})
    return table


def run(dataset, table):
    return run_set(dataset, Script(dataset, table).contestant(), evaluate_pairs(dataset), silent)


def test_overlaps_of_the_strips_are_as_laid_out():
    # Strips at 0, 2, 5, 30, ten long, radius 2.2: shifted by 2 all see each other, by 3 nine of
    # ten, by 5 seven of ten.
    shared = {(p.name_i, p.name_j): p.overlap for p in evaluate_pairs(strip_set())}
    assert shared['view00', 'view02'] == 1.0
    assert shared['view02', 'view05'] == pytest.approx(0.9)
    assert shared['view00', 'view05'] == pytest.approx(0.7)
    assert shared['view00', 'view30'] == 0.0


def test_recall_and_precision_are_counted_over_their_own_pairs():
    dataset = strip_set()
    # Right; wrong; refused; wrong where there is no overlap; the rest refused.
    table = answers(dataset, view00_view02=1.0, view00_view05=7.0, view00_view30=20.0)
    case, records = run(dataset, table)
    assert (case['pairs'], case['pairs_all'], case['accepted']) == (3, 6, 3)
    assert case['recall'] == pytest.approx(1 / 3)
    assert case['precision'] == pytest.approx(1 / 3)
    assert case['wrong_accepted'] == [['view00', 'view05'], ['view00', 'view30']]
    assert case['missed'] == [['view00', 'view05'], ['view02', 'view05']]
    assert case['rotation_deg'] == pytest.approx(1.0)
    assert case['translation_dres'] == pytest.approx(0.0, abs=1e-9)
    assert len(records) == 6


def test_an_accepted_right_pair_without_overlap_counts_for_precision_only():
    dataset = strip_set()
    case, _ = run(dataset, answers(dataset, view00_view30=0.0))
    assert (case['recall'], case['precision']) == (0.0, 1.0)


def test_scores_by_overlap_bin():
    dataset = strip_set(starts=(0, 6, 9))  # 0-6: 6 of 10; 6-9: 9 of 10; 0-9: 3 of 10
    case, _ = run(dataset, answers(dataset, view00_view06=0.0, view00_view09=90.0))
    assert case['pairs_by_overlap'] == {'0.1-0.3': 0, '0.3-0.6': 1, '0.6-1.0': 2}
    assert case['recall_by_overlap'] == {'0.1-0.3': None, '0.3-0.6': 0.0, '0.6-1.0': 0.5}
    assert case['precision_by_overlap'] == {'0.1-0.3': None, '0.3-0.6': 0.0, '0.6-1.0': 1.0}


def test_nothing_accepted_has_no_precision_and_no_errors():
    dataset = strip_set()
    case, _ = run(dataset, answers(dataset))
    assert (case['recall'], case['precision'], case['rotation_deg']) == (0.0, None, None)


def test_keys_of_the_issue():
    dataset = strip_set()
    case, _ = run(dataset, answers(dataset, view00_view02=1.0))
    assert set(case) >= KEYS
    assert set(case['recall_by_overlap']) == {'0.1-0.3', '0.3-0.6', '0.6-1.0'}
    assert case['dataset'] == 'set'
    assert case['seconds_per_pair'] >= 0
    assert len(case['details']) == 6


def test_the_table_shows_counts():
    dataset = strip_set()
    case, _ = run(dataset, answers(dataset, view00_view02=1.0))
    text = pairwise_table([{**case, 'mode': 'default', 'seed': 3}])
    heads, _, row = (
        [cell.strip() for cell in line.strip('|').split('|')] for line in text.splitlines())
    shown = dict(zip(heads, row, strict=True))
    assert (shown['correct'], shown['0.6-1.0'], shown['wrong']) == ('1/3', '1/3', '0')
    assert shown['deg'] == '1.000'


def test_cross_pairs_keep_units_apart_and_count_every_acceptance_as_wrong():
    a, b = strip_set('a', starts=(0, 1)), strip_set('b', starts=(0, 1, 2))
    c = strip_set('c', 'mm')
    assert [name for name, _, _ in cross_pairs([a, b, c])] == ['a x b']
    views = cross_pairs([a, b])[0][1]
    assert set(views) == {f'a/{n}' for n in a.views} | {f'b/{n}' for n in b.views}
    accept_all = Contestant('yes', lambda view: view, lambda i, j: Script(
        strip_set(starts=(0, 1, 2)), {(i.name, j.name): 0.0}).register(i, j))
    case, = run_cross([a, b, c], accept_all, silent)
    assert (case['pairs'], case['pairs_all'], case['accepted']) == (0, 6, 6)
    assert (case['recall'], case['precision'], len(case['wrong_accepted'])) == (None, 0.0, 6)


def test_seconds_of_a_pair_count_the_preparation_of_both_views():
    dataset = strip_set()
    script = Script(dataset, answers(dataset)).contestant()
    pairs = evaluate_pairs(dataset)
    prepared = prepare_all(script, dataset.views, silent)
    records = run_pairs(script, pairs, prepared, errors_in(dataset), silent)
    name_i, name_j = records[0].truth.name_i, records[0].truth.name_j
    before = prepared.seconds[name_i] + prepared.seconds[name_j]
    assert records[0].seconds_with_prepare == pytest.approx(before + records[0].seconds)


def test_json_holds_machine_and_cases_and_no_nan(tmp_path, capsys):
    args = argparse.Namespace(json=str(tmp_path / 'b.json'), quiet=True)
    settings.report(args, [{'a': float('nan'), 'b': [1.5, (2, 'x')]}], 'table\n')
    content = json.loads((tmp_path / 'b.json').read_text())
    assert content['cases'] == [{'a': None, 'b': [1.5, [2, 'x']]}]
    assert set(content['machine']) >= {'cpu', 'cores', 'python', 'numpy', 'ros_rops'}
    assert capsys.readouterr().out.startswith('table\n')


def test_json_that_cannot_be_written_is_named(tmp_path):
    args = argparse.Namespace(json=str(tmp_path / 'no' / 'b.json'), quiet=True)
    with pytest.raises(InputError, match='b.json: cannot be written'):
        settings.report(args, [], '')


def test_machine_facts_are_of_this_machine():
    facts = machine_facts()
    assert facts['cores'] >= 1
    assert facts['cpu']
    assert 5 < peak_rss_mib() < 1e6


@pytest.mark.parametrize(('text', 'value'), [
    ('rops.radius_mr=12.5', 12.5), ('rops.bins=7', 7), ('lrf.method=toldi', 'toldi')])
def test_one_parameter_is_changed(text, value):
    name, found = settings.parse_change(text)
    assert found == value
    assert settings.derive(Config(), {name: found}).to_flat()[name] == value


@pytest.mark.parametrize('text', [
    'rops.radius_mr', 'no.such=1', 'rops.bins=x', 'rops.bins=1.5', '=1', ''])
def test_a_bad_change_is_named(text):
    with pytest.raises(ParameterError, match=text.partition('=')[0] or 'PARAMETER=VALUE'):
        settings.parse_change(text)
