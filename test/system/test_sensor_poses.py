# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Sensor poses from a recording's TF. Truth: the exact poses of a simulated hand-held capture."""

import json

import pytest
from reference.runs import BARE, result, unfinish
from ros_rops.cli.main import main


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp('sensor_poses') / 'hand.mcap'
    assert main([
        'simulate', 'procedural:bracket', '--out', str(path), '--capture', 'hand-held', '--views',
        '6', '--image', '160x120', '--distance', '0.35', '--size', '0.15', '--seed', '3',
        '--table']) == 0
    return path


def replayed(recording, out, frame):
    more = ('--set', f'prior.fixed_frame={frame}') if frame else ()
    assert main(['replay', str(recording), '--out', str(out), *BARE, *more]) == 0
    return json.loads((out / 'poses.json').read_text(encoding='utf-8'))


def test_they_are_found_journalled_and_used(recording, tmp_path, capsys):
    out = tmp_path / 'run'
    document = replayed(recording, out, 'world')
    assert 'sensor poses in world of 6 views' in capsys.readouterr().out
    assert document['station']['sensor_poses'] == 6
    assert main(['evaluate', str(out / 'poses.json'),
                 str(recording.with_name('hand_poses.json'))]) == 0
    assert '6 of 6 views placed, 0 in the wrong place' in capsys.readouterr().out
    before = result(out)
    unfinish(out)
    (out / 'poses.json').unlink()
    assert main(['resume', str(out)]) == 0
    assert result(out) == before


def test_where_tf_does_not_know_the_result_is_as_without(recording, tmp_path, capsys):
    document = replayed(recording, tmp_path / 'nowhere', 'nowhere')
    assert 'no sensor pose is used: TF does not tell' in capsys.readouterr().err
    without = replayed(recording, tmp_path / 'off', '')
    assert document['objects'] == without['objects']
    assert 'station' not in without or not without['station']
