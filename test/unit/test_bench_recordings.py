# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The bench of recordings. Truth: what was asked, and hand-made times."""

import json

import pytest
from ros_rops.bench.__main__ import main
from ros_rops.bench.recording_data import stops
from ros_rops.bench.recordings import timed_decodes
from ros_rops.bench.timing import Limit, Timing, timing_table


@pytest.mark.parametrize(('seconds', 'reached'), [
    ((0.001, 0.002, 0.9), 'aim'), ((0.005,), 'must'), ((0.1, 0.2), 'neither')])
def test_median_against_limits(seconds, reached):
    assert Timing('x', 'y', seconds, Limit(10.0, 4.0)).reached == reached


def test_without_limits_nothing_is_reached():
    timing = Timing('x', 'y', (0.001, 0.003))
    assert timing.reached is None
    assert timing.median_ms == pytest.approx(2.0)
    assert '| 2.0 ' in timing_table([timing])


def test_each_run_is_of_a_decoded_frame():
    memory = stops(3, 'depth', 1)
    seen = []
    seconds = timed_decodes(memory, 5, seen.append)
    assert len(seconds) == 5
    names = [frame.name for frame in memory.frames()]
    assert len(names) == 4
    # Each pass decodes all; its first is not timed.
    assert [frame.name for frame in seen] == names * 2
    assert all(frame.points.shape == (480, 640, 3) for frame in seen)


def test_command_writes_its_table_and_numbers(tmp_path, capsys):
    path = tmp_path / 'r.json'
    words = ['recordings', '--runs', '1', '--stops', '1', '--no-huge', '--json', str(path)]
    assert main(words) == 0
    cases = json.loads(path.read_text(encoding='utf-8'))['cases']
    assert [case['what'] for case in cases] == [
        'PointCloud2 to a view', 'frame to segmented views', 'still and new',
        'depth image to a view', 'frame to segmented views', 'still and new']
    assert all(case['median_ms'] > 0 and case['must_ms'] > case['aim_ms'] for case in cases)
    assert 'PointCloud2 to a view' in capsys.readouterr().out


@pytest.mark.parametrize('words', [
    ['--runs', '0'], ['--stops', '0'], ['no/such.mcap', '--no-huge', '--runs', '1']])
def test_mistakes_of_the_caller(words, capsys):
    assert main(['recordings', *words]) == 2
    assert capsys.readouterr().err
