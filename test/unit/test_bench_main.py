# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The command line of the bench. Truth: what was asked for on it."""

import json

import pytest
from reference.bench_sets import strip_set
from ros_rops.bench.__main__ import main
from ros_rops.bench.cases import CASES
from ros_rops.recordings.writers import write_dataset


@pytest.mark.parametrize('case', CASES)
def test_every_case_has_help(case, capsys):
    with pytest.raises(SystemExit) as caught:
        main([case, '--help'])
    assert caught.value.code == 0
    said = capsys.readouterr().out
    # What measures can write its numbers; `document` only shows what was measured.
    assert ('--json' in said) != (case == 'document')


def test_a_missing_folder_is_the_callers_mistake(capsys, tmp_path):
    assert main(['descriptor', str(tmp_path / 'nowhere')]) == 2
    assert 'nowhere' in capsys.readouterr().err


def test_a_folder_without_poses_cannot_be_judged(capsys, tmp_path):
    one = strip_set()
    write_dataset(tmp_path / 's', list(one.views.values()), one.T_world_view, units='m')
    (tmp_path / 's' / 'reference_poses.json').unlink()
    assert main(['descriptor', str(tmp_path / 's')]) == 2
    assert 'reference_poses.json: missing' in capsys.readouterr().err


def test_two_sets_of_one_name_are_refused(capsys, tmp_path):
    one = strip_set()
    for parent in ('a', 'b'):
        write_dataset(
            tmp_path / parent / 's', list(one.views.values()), one.T_world_view, units='m')
    assert main(['descriptor', str(tmp_path / 'a/s'), str(tmp_path / 'b/s')]) == 2
    assert "named 's'" in capsys.readouterr().err


def test_the_descriptor_case_writes_its_json(capsys, tmp_path):
    one = strip_set()
    folder = tmp_path / 's'
    write_dataset(folder, list(one.views.values()), one.T_world_view, units='m')
    file = tmp_path / 'out.json'
    assert main(['descriptor', str(folder), '--json', str(file), '--threads', '1']) == 0
    case, = json.loads(file.read_text())['cases']
    assert (case['case'], case['dataset']) == ('descriptor', 's')
    assert set(case['by_overlap']) == {'0.1-0.3', '0.3-0.6', '0.6-1.0'}
    assert '| s ' in capsys.readouterr().out
