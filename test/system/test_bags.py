# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The recordings in bags/. Truth: their commands, run again."""

import json
from pathlib import Path
import shutil

import pytest
from reference.runs import BARE
from ros_rops.cli.check_bags import LIST, read_list
from ros_rops.cli.main import main
from ros_rops.core.errors import InputError

BAGS = Path(__file__).resolve().parents[2] / 'bags'


def test_every_file_is_listed_and_small():
    bags = read_list(BAGS / LIST)
    listed = {name for bag in bags for name in bag.sha256}
    assert {path.name for path in BAGS.iterdir()} == listed | {LIST, 'README.md'}
    assert sum(path.stat().st_size for path in BAGS.iterdir()) < 6_000_000


def test_commands_make_the_recordings_again(capsys):
    assert main(['check-bags', str(BAGS)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(read_list(BAGS / LIST))
    assert all('made again' in line for line in lines)


def copy_of(folder: Path, name: str) -> Path:
    """Return a folder with one recording of the list."""
    for path in BAGS.glob(f'{name}*'):
        shutil.copy(path, folder)
    lines = (BAGS / LIST).read_text().split('- file: ')
    entry, = [one for one in lines[1:] if one.startswith(f'{name}.mcap')]
    (folder / LIST).write_text(f'bags:\n- file: {entry}')
    return folder


def test_what_is_wrong_is_said(tmp_path, capsys):
    folder = copy_of(tmp_path, 'handheld')
    text = (folder / LIST).read_text()
    assert main(['check-bags', str(folder), '--hashes-only']) == 0
    (folder / LIST).write_text(text.replace('--seed 3', '--seed 4'))
    assert main(['check-bags', str(folder)]) == 1
    assert 'WRONG: handheld_poses.json' in capsys.readouterr().out
    data = bytearray((folder / 'handheld.mcap').read_bytes())
    data[5000] ^= 1
    (folder / 'handheld.mcap').write_bytes(data)
    assert main(['check-bags', str(folder)]) == 1
    assert 'hash of handheld.mcap' in capsys.readouterr().out
    (folder / 'handheld.mcap').unlink()
    assert main(['check-bags', str(folder)]) == 1
    assert 'cannot be read' in capsys.readouterr().out


@pytest.mark.parametrize(('text', 'said'), [
    ('bags: 3', 'no list'), ('{', 'is no YAML .(?!.*object at)'),
    ('bags: [{file: a}]', 'no list')])
def test_bad_lists_are_refused(tmp_path, text, said):
    (tmp_path / LIST).write_text(text)
    with pytest.raises(InputError, match=said):
        read_list(tmp_path / LIST)
    assert main(['check-bags', str(tmp_path)]) == 2
    assert main(['check-bags', str(tmp_path / 'none')]) == 2


def test_only_our_commands_are_run(tmp_path, capsys):
    folder = copy_of(tmp_path, 'handheld')
    text = (folder / LIST).read_text()
    (folder / LIST).write_text(text.replace('rops simulate', 'rm simulate'))
    assert main(['check-bags', str(folder)]) == 2
    assert 'no rops simulate' in capsys.readouterr().err


def numbers_of(tmp_path: Path, name: str, *options: str) -> dict:
    """Replay a recording, judge the run by its poses, return the numbers."""
    run, numbers = tmp_path / 'run', tmp_path / 'numbers.json'
    assert main(['replay', str(BAGS / f'{name}.mcap'), '--out', str(run), *BARE,
                 *options]) == 0
    main(['evaluate', str(run), str(BAGS / f'{name}_poses.json'), '--json', str(numbers)])
    return json.loads(numbers.read_text())


@pytest.mark.slow
def test_two_objects_on_a_table_come_apart(tmp_path):
    found = numbers_of(tmp_path, 'table')
    assert found['wrong_placements'] == found['wrong_merges'] == found['splits'] == 0
    assert found['placed'] >= 20  # of 24 at most; each hides the other once in a turn
    assert found['mean_rotation_deg'] < 0.3
    assert found['mean_translation_dres'] < 0.5
    assert {one['label'] for one in found['objects']} == {'blob', 'bracket'}


def test_one_frame_a_stop_is_taken_of_a_turning_table(tmp_path):
    found = numbers_of(tmp_path, 'turning', '--set', 'selection.method=still')
    assert found['views'] == 56
    run = json.loads((tmp_path / 'run' / 'poses.json').read_text())
    stops = [(int(view['name'].rpartition('@')[2]) - 1_700_000_000_000_000_000) // 10**9
             for view in run['views']]
    assert stops == [0, 1, 2, 3, 4, 5]  # a stop and the turn after it take a second


def test_the_turning_object_is_not_folded(tmp_path):
    found = numbers_of(tmp_path, 'turning', '--set', 'selection.method=still')
    assert found['wrong_placements'] == 0


def test_a_wrong_step_is_not_believed(tmp_path):
    found = numbers_of(
        tmp_path, 'turning', '--set', 'selection.method=still', '--set', 'prior.step_deg=10')
    assert found['placed'] >= 4 and found['wrong_placements'] == 0  # the table turns by 30
    station = json.loads((tmp_path / 'run' / 'poses.json').read_text())['station']
    assert 'not_believed' in station
