# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Results compared. Truth: what was changed, by hand, from one file to the other."""

import json

import numpy as np
import pytest
from reference.results import MACHINE, pair, pairs_case, session_case, write
from ros_rops.bench.__main__ import main
from ros_rops.bench.compare import compare, worse
from ros_rops.bench.compare_cases import Measured
from ros_rops.bench.compare_verdicts import interval, Judge, State

PAIRS = [pair(number) for number in range(12)]
TWICE = {**MACHINE, 'reference_seconds': [0.02] * 5, 'reference_cpu_seconds': [0.02] * 3}


def changed(before, after, machine=MACHINE, **options):
    """Return what is not the same, as {(case's last word, what): verdict}, and the exit code."""
    lines = compare(
        Measured('A', MACHINE, before), Measured('B', machine, after),
        Judge(MACHINE, machine, **options))
    found = {
        (line.case.split()[0], line.what): line.verdict for line in lines
        if line.verdict.state is not State.SAME or line.verdict.changed}
    return found, worse(lines, strict=options.get('strict', False))


def lost(numbers, pairs=PAIRS):
    return [
        {**one, 'correct': False, 'status': 'refused', 'errors': None} if k in numbers else one
        for k, one in enumerate(pairs)]


def test_the_same_is_the_same():
    cases = [pairs_case(PAIRS), session_case()]
    assert changed(cases, cases) == ({}, False)


def test_one_lost_pair_is_shown_and_is_noise_unless_strict():
    before, after = [pairs_case(PAIRS)], [pairs_case(lost([3]))]
    found, bad = changed(before, after)
    verdict = found['pairwise', 'details correct']
    assert (verdict.state, verdict.a, verdict.b, bad) == (State.SAME, '12/12', '11/12', False)
    assert '1 lost: s3 - t3' in verdict.why
    found, bad = changed(before, after, strict=True)
    assert bad and found['pairwise', 'details correct'].state is State.WORSE
    assert changed(after, before, strict=True)[1] is False


def test_five_lost_pairs_are_beyond_noise_and_five_gained_ones_too():
    # By hand: one side of the exact test of 5 against 0 is 1/32, of 4 against 0 1/16.
    before = [pairs_case(PAIRS)]
    for count, state in ((4, State.SAME), (5, State.WORSE)):
        after = [pairs_case(lost(range(count)))]
        found, bad = changed(before, after)
        assert found['pairwise', 'details correct'].state is state
        assert bad == (state is State.WORSE)
        assert 0.5 ** count == pytest.approx(
            float(found['pairwise', 'details correct'].why.split('p = ')[1]), rel=0.05)
    found, bad = changed([pairs_case(lost(range(5)))], before)
    assert found['pairwise', 'details correct'].state is State.BETTER and not bad


def test_small_losses_on_every_set_add_up():
    before = [pairs_case(PAIRS, dataset=name) for name in 'abcdef']
    after = [pairs_case(lost([k]), dataset=name) for k, name in enumerate('abcdef')]
    lines = compare(
        Measured('A', MACHINE, before), Measured('B', MACHINE, after), Judge(MACHINE, MACHINE))
    bad = [line for line in lines if line.verdict.state is State.WORSE]
    assert [line.case for line in bad] == ['pairwise ros_rops default, together']
    assert (bad[0].verdict.a, bad[0].verdict.b) == ('72/72', '66/72')


def test_a_new_wrong_pair_is_worse_even_where_an_old_one_went():
    def wrong(number):
        return [{**one, 'correct': False} if k == number else one for k, one in enumerate(PAIRS)]

    found, bad = changed([pairs_case(wrong(1))], [pairs_case(wrong(2))])
    assert bad and found['pairwise', 'wrong_accepted'].state is State.WORSE
    assert 's2 - t2' in found['pairwise', 'wrong_accepted'].why
    found, bad = changed([pairs_case(wrong(1))], [pairs_case(PAIRS)])
    assert not bad and found['pairwise', 'wrong_accepted'].state is State.BETTER


@pytest.mark.parametrize(('name', 'value'), [
    ('wrong_merges', 1), ('splits', 1), ('placed', 9), ('attempts', 10), ('wrong_views', ['v0']),
    ('peak_rss_mib', 260.0), ('max_rotation_deg', 0.4)])
def test_what_a_session_can_lose(name, value):
    found, bad = changed([session_case()], [session_case(**{name: value})])
    assert bad and list(found) == [('multiview', name)]
    found, bad = changed([session_case(**{name: value})], [session_case()])
    assert not bad and found['multiview', name].state is State.BETTER


@pytest.mark.parametrize(('name', 'value'), [
    ('peak_rss_mib', 220.0), ('max_rotation_deg', 0.305), ('seconds', 3.5)])
def test_what_is_noise_in_a_session(name, value):
    assert changed([session_case()], [session_case(**{name: value})]) == ({}, False)


def test_work_within_the_range_of_the_orders_is_noise():
    def orders(*attempts):
        return [session_case(f'seed {k}', attempts=n) for k, n in enumerate(attempts)]

    assert changed(orders(41, 45, 43), orders(44, 45, 45)) == ({}, False)
    found, bad = changed(orders(41, 45, 43), orders(46, 46, 45))
    assert bad and found['multiview', 'attempts'].a == '41-45'


def slowed(factor, pairs=PAIRS):
    return [{**one, 'seconds': one['seconds'] * factor} for one in pairs]


def test_seconds_count_by_the_kernel_of_their_run():
    before = [pairs_case(PAIRS), session_case()]
    after = [pairs_case(slowed(2.0)), session_case(seconds=6.0)]
    found, bad = changed(before, after)
    assert bad and set(found) == {('pairwise', 'details seconds'), ('multiview', 'seconds')}
    assert 'x 2.00' in found['pairwise', 'details seconds'].why
    assert changed(before, after, TWICE) == ({}, False)
    # The same seconds where the kernel takes twice as long: it became faster.
    found, bad = changed(before, before, TWICE)
    assert not bad and found['pairwise', 'details seconds'].state is State.BETTER


def test_seconds_that_scatter_are_noise_and_a_limit_can_be_given():
    rng = np.random.default_rng(0)
    noisy = [
        {**one, 'seconds': one['seconds'] * scale}
        for one, scale in zip(PAIRS, np.exp(rng.normal(0.05, 0.4, 12)), strict=True)]
    assert changed([pairs_case(PAIRS)], [pairs_case(noisy)]) == ({}, False)
    after = [pairs_case(slowed(1.08))]
    assert not changed([pairs_case(PAIRS)], after)[1]
    assert changed([pairs_case(PAIRS)], after, slower=0.05)[1]


def test_another_machine_is_given_more_room():
    after = [session_case(seconds=3.0 * 1.35)]
    assert changed([session_case()], after)[1]
    assert not changed([session_case()], after, {**MACHINE, 'cpu': 'b'})[1]


def test_a_kernel_that_scatters_gives_more_room():
    shaky = {**MACHINE, 'reference_seconds': [0.007, 0.008, 0.01, 0.012, 0.013]}
    assert changed([session_case()], [session_case(seconds=4.0)])[1]
    assert not changed([session_case()], [session_case(seconds=4.0)], shaky)[1]


def test_seconds_beside_a_kernel_of_their_own_need_none_of_the_file():
    def timed(seconds, kernel):
        return [pairs_case([
            {**one, 'seconds': seconds, 'reference_seconds': kernel} for one in PAIRS])]

    assert not changed(timed(0.1, 0.01), timed(0.2, 0.02), {'cpu': 'a', 'cores': 2})[1]
    assert changed(timed(0.1, 0.01), timed(0.2, 0.01), {'cpu': 'a', 'cores': 2})[1]


def test_without_a_kernel_seconds_are_not_compared():
    found, bad = changed([session_case()], [session_case(seconds=30.0)], {'cpu': 'a'})
    assert not bad and found['multiview', 'seconds'].state is State.UNKNOWN
    assert found['multiview', 'seconds'].why == 'no reference_seconds in B'


def test_errors_of_pairs_count_beyond_noise():
    def off(factor):
        return [pairs_case([
            {**one, 'errors': {'rotation_deg': 0.2 * factor}} for one in PAIRS])]

    found, bad = changed(off(1.0), off(1.5))
    assert bad and found['pairwise', 'details errors rotation_deg'].state is State.WORSE
    assert changed(off(1.0), off(1.05)) == ({}, False)


def test_what_is_in_one_file_alone_is_said_and_is_worse_where_strict():
    both = [pairs_case(PAIRS), session_case()]
    found, bad = changed(both, both[:1])
    assert not bad and found['multiview', 'all'].state is State.ONLY_A
    assert changed(both, both[:1], strict=True)[1]
    found, bad = changed(both[:1], both, strict=True)
    assert not bad and found['multiview', 'all'].state is State.ONLY_B
    less = {key: value for key, value in session_case().items() if key != 'placed'}
    assert changed([session_case()], [less])[0]['multiview', 'placed'].state is State.ONLY_A


def test_parameters_nobody_has_a_meaning_for_tell_cases_apart():
    def levels(*correct):
        return [
            {'method': 'x', 'blur': 0.5 * k, 'correct': one} for k, one in enumerate(correct)]

    found, bad = changed(levels(9, 8, 7), levels(9, 8, 6))
    assert bad and len(found) == 1
    found, bad = changed(levels(9, 8, 7), levels(9, 8))  # a level less: nothing is confused
    assert not bad and [v.state for v in found.values()] == [State.ONLY_A]


def test_the_command_writes_and_returns_what_it_found(capsys, tmp_path):
    a = write(tmp_path / 'a.json', [pairs_case(PAIRS)])
    b = write(tmp_path / 'b.json', [pairs_case(slowed(2.0, lost([0])))])
    assert main(['compare', str(a), str(a)]) == 0
    assert 'worse 0, better 0' in capsys.readouterr().out
    assert main(['compare', str(a), str(b), '--json', str(tmp_path / 'c.json')]) == 1
    said = capsys.readouterr().out
    assert '| worse' in said and '1 lost: s0 - t0' in said
    lines = json.loads((tmp_path / 'c.json').read_text())['lines']
    assert {'worse', 'same'} <= {line['state'] for line in lines}
    assert main(['compare', str(a), str(b), '--slower', '2']) == 0
    assert main(['compare', str(a), str(b), '--slower', 'nan']) == 2
    capsys.readouterr()


def test_results_of_an_experiment_match_those_of_json(tmp_path):
    case = {'by': 'x', 'correct': 3}
    a = write(tmp_path / 'a.json', [case], experiment='table1', command='', seconds=1.0)
    b = write(tmp_path / 'b.json', [{'experiment': 'table1', **case}])
    assert main(['compare', str(a), str(b)]) == 0


@pytest.mark.parametrize('text', [
    '', '{', '[]', '{}', '{"cases": {}}', '{"cases": [1]}', '{"cases": []}', 'null', '\xff',
    '[' * 100_000, '{"machine": 1, "cases": [{"case": "else", "correct": 1}]}'])
def test_a_bad_file_gets_one_sentence(text, capsys, tmp_path):
    good, bad = write(tmp_path / 'good.json', [session_case()]), tmp_path / 'bad.json'
    bad.write_bytes(text.encode('latin-1'))
    for words in ((good, bad), (bad, good)):
        assert main(['compare', *map(str, words)]) == 2
        said = capsys.readouterr()
        assert 'bad.json' in said.err and said.err.count('\n') == 1 and not said.out


def test_a_folder_or_nothing_gets_one_sentence(capsys, tmp_path):
    for path in (tmp_path, tmp_path / 'none.json'):
        assert main(['compare', str(path), str(path)]) == 2
        said = capsys.readouterr().err
        assert f'{path}: cannot be read' in said and said.count('\n') == 1


def test_numbers_that_are_none_were_not_measured(tmp_path):
    case = {**session_case(), 'seconds': float('nan'), 'placed': None}
    a, b = write(tmp_path / 'a.json', [session_case()]), write(tmp_path / 'b.json', [case])
    assert main(['compare', str(a), str(b)]) == 0
    assert main(['compare', str(a), str(b), '--strict']) == 1
    odd = session_case(placed='ten', attempts=[9], objects={}, errors=[], wrong_views={'v': 1})
    assert main(['compare', str(a), str(write(tmp_path / 'odd.json', [odd]))]) in (0, 1)


def test_the_interval_of_a_median_holds_it_as_often_as_it_says():
    rng = np.random.default_rng(1)
    for count in (6, 15, 60):
        bounds = [interval(rng.normal(size=count)) for _ in range(400)]
        assert np.mean([low <= 0 <= high for low, _, high in bounds]) >= 0.95
    assert interval(np.array([1.0, 3.0])) == (1.0, 2.0, 3.0)
