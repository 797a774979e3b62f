# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The recordings in bags/. Truth: their commands, run again."""

from pathlib import Path
import shutil

import pytest
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
    ('bags: 3', 'no list'), ('{', 'no list'), ('bags: [{file: a}]', 'no list')])
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
