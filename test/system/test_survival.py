# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A run that is killed and gone on with. Truth: the run that was not, byte by byte."""

import errno
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

from meta.tree import ROOT
import numpy as np
import pytest
from reference.runs import BARE, result, start, unfinish, wait_for, words
from ros_rops.cli.main import main
from ros_rops.intake import journal as journal_module
from ros_rops.intake.lock import locked
from ros_rops.intake.past import Past
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.writers import write_view

# When a run is killed: 1 is its end. All but four of the twenty are marked slow.
MOMENTS = np.random.default_rng(20261122).uniform(0.0, 1.1, 20)


def _kill_and_resume(recording, whole, out, moment, threads):
    process = start(*words(recording, out, '--threads', threads))
    wait_for(out / 'journal.mcap', process)
    time.sleep(moment * whole.seconds)
    process.kill()
    process.communicate()
    assert main(['resume', str(out)]) == 0
    assert result(out) == whole.result


@pytest.mark.parametrize('number', range(4))
def test_killed_at_a_random_moment(number, recording, whole, tmp_path):
    _kill_and_resume(recording, whole, tmp_path / 'run', MOMENTS[number], '2')


@pytest.mark.slow
@pytest.mark.parametrize('number', range(4, 20))
def test_killed_at_more_random_moments(number, recording, whole, tmp_path):
    _kill_and_resume(recording, whole, tmp_path / 'run', MOMENTS[number], '1')


def test_cut_at_any_byte_and_resumed_by_a_resumed_run(recording, whole, tmp_path, capsys):
    """What a crash of the machine may leave; twice in a row."""
    out = tmp_path / 'run'
    assert main(words(recording, out)) == 0
    data = (out / 'journal.mcap').read_bytes()
    for share in (0.35, 0.7):
        unfinish(out)
        (out / 'journal.mcap').write_bytes(data[:int(share * len(data))])
        assert main(['resume', str(out), '--threads', '1']) == 0
        assert result(out) == whole.result
        data = (out / 'journal.mcap').read_bytes()
    assert 'are left out: the entry was not finished' in capsys.readouterr().err


def _copy(whole, out: Path) -> Path:
    """Return a finished run in a folder of its own."""
    out.mkdir()
    for path in whole.out.iterdir():
        (out / path.name).write_bytes(path.read_bytes())
    return out


def test_a_finished_run_is_left_as_it_is(whole, tmp_path, capsys):
    out = _copy(whole, tmp_path / 'run')
    before = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    assert main(['resume', str(out)]) == 0
    assert 'is finished' in capsys.readouterr().out
    assert before == {path.name: path.stat().st_mtime_ns for path in out.iterdir()}


def test_ctrl_c_leaves_a_result_and_a_run_to_go_on_with(recording, whole, tmp_path, capsys):
    out = tmp_path / 'run'
    process = start(*words(recording, out))
    lines = []
    for line in process.stderr:
        lines.append(line)
        if ': pending' in line:
            process.send_signal(signal.SIGINT)
            break
    _, errors = process.communicate(timeout=120)
    assert 'interrupted' in errors, lines
    poses = json.loads((out / 'poses.json').read_text(encoding='utf-8'))
    assert poses['complete'] is False and 0 < len(poses['views']) < 4
    assert 'complete' not in json.loads(whole.result['poses.json'])
    assert main(words(recording, out)) == 2
    assert 'holds an unfinished run' in capsys.readouterr().err
    assert main(['resume', str(out)]) == 0
    assert result(out) == whole.result


def test_two_at_once_is_one_too_many(whole, tmp_path, capsys):
    out = _copy(whole, tmp_path / 'run')
    unfinish(out)
    with locked(out):
        assert main(['resume', str(out)]) == 2
        assert 'another process is working on this run' in capsys.readouterr().err
    assert main(['resume', str(out)]) == 0


def test_an_input_that_changed_is_said_and_the_journal_used(recording, whole, tmp_path, capsys):
    copy = tmp_path / 'copy.mcap'
    copy.write_bytes(recording.read_bytes())
    out = tmp_path / 'run'
    assert main(words(copy, out)) == 0
    _cut_journal(out, 2)
    copy.write_bytes(recording.read_bytes() + b'more')
    assert main(['resume', str(out)]) == 0
    assert 'copy.mcap: has changed' in capsys.readouterr().err
    poses = json.loads((out / 'poses.json').read_text(encoding='utf-8'))
    assert len(poses['views']) == 2 and poses['complete'] is False
    copy.unlink()
    assert main(['resume', str(out)]) == 0
    assert 'copy.mcap: is gone' in capsys.readouterr().err
    copy.write_bytes(recording.read_bytes())
    assert main(['resume', str(out)]) == 0
    assert result(out) == whole.result


def _cut_journal(out: Path, views: int) -> None:
    """Leave so many views in a journal, as if the run had been killed then."""
    past, count = Past(out / 'journal.mcap'), 0
    for entry in past:
        count += len(entry.views)
        if count == views:
            break
    os.truncate(out / 'journal.mcap', past.at)
    unfinish(out)


def test_a_journal_that_is_gone_is_said_and_the_run_begins_anew(whole, tmp_path, capsys):
    out = _copy(whole, tmp_path / 'run')
    unfinish(out)
    (out / 'journal.mcap').unlink()
    assert main(['resume', str(out)]) == 0
    assert 'is missing; the run begins anew' in capsys.readouterr().err
    assert result(out) == whole.result


def test_a_damaged_journal_is_used_up_to_the_damage_and_kept(whole, tmp_path, capsys):
    out = _copy(whole, tmp_path / 'run')
    unfinish(out)
    data = bytearray((out / 'journal.mcap').read_bytes())
    data[len(data) // 2] ^= 0xFF
    (out / 'journal.mcap').write_bytes(data)
    assert main(['resume', str(out)]) == 0
    assert 'damaged' in capsys.readouterr().err
    assert (out / 'journal.damaged.mcap').read_bytes() == data
    assert result(out) == whole.result


@pytest.mark.parametrize(('make', 'message'), [
    (lambda out: None, 'cannot be opened'),
    (lambda out: out.mkdir(), 'run.json: cannot be read'),
    (lambda out: (out.mkdir(), (out / 'run.json').write_text('{')), 'is not JSON'),
    (lambda out: (out.mkdir(), (out / 'run.json').write_text('{}')), 'is not the run.json'),
    (lambda out: (out.mkdir(), (out / 'run.json').write_text('[1]')), 'is not the run.json'),
], ids=['none', 'empty', 'no json', 'no run', 'a list'])
def test_a_folder_that_holds_no_run_is_named(make, message, tmp_path, capsys):
    make(tmp_path / 'run')
    assert main(['resume', str(tmp_path / 'run')]) == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1 and message in error


@pytest.mark.parametrize('times', [0, 3, 5], ids=['at once', 'in the middle', 'at the end'])
def test_a_disk_that_fills_up_stops_nothing(
    times, recording, whole, tmp_path, capsys, monkeypatch
):
    left = [times]

    def fsync(handle):
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(journal_module, 'os', SimpleNamespace(fsync=fsync))
    out = tmp_path / 'run'
    assert main(words(recording, out)) == 0
    error = capsys.readouterr().err
    assert error.count('the journal broke off') == 1 and 'No space left on device' in error
    assert result(out) == whole.result
    metrics = json.loads((out / 'metrics.json').read_text(encoding='utf-8'))
    assert 'No space left on device' in metrics['journal']
    monkeypatch.undo()
    unfinish(out)
    assert main(['resume', str(out)]) == 0
    assert result(out) == whole.result


def test_a_result_that_cannot_be_written_loses_no_view(recording, whole, tmp_path):
    """Truth: files beyond a size fail as on a full disk; the journal is below it."""
    out = tmp_path / 'run'
    command = words(recording, out)
    limit = 'import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (400_000, -1)); '
    code = limit + f'from ros_rops.cli.main import main; raise SystemExit(main({command!r}))'
    done = subprocess.run(
        [sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2 and 'object_0.ply: cannot be written' in done.stderr
    assert sum(len(entry.views) for entry in Past(out / 'journal.mcap')) == 4
    recording = recording.rename(tmp_path / 'away.mcap')  # the journal alone will do
    try:
        assert main(['resume', str(out)]) == 0
    finally:
        recording.rename(Path(command[1]))
    assert result(out) == whole.result


def test_files_are_resumed_too_and_an_unreadable_one_keeps_its_word(whole, tmp_path):
    folder = tmp_path / 'in'
    folder.mkdir()
    for k, outcome in enumerate(find_views([whole.out / 'journal.mcap'])[0].views()):
        write_view(folder / f'view{k}.ply', outcome.view)
    (folder / 'view1_bad.ply').write_bytes(b'ply\nnonsense')
    out = tmp_path / 'run'
    assert main(['register', str(folder), '--out', str(out), *BARE]) == 0
    expected = result(out)
    _cut_journal(out, 3)
    (folder / 'view1_bad.ply').unlink()  # it has its word already
    (folder / 'view0.ply').unlink()
    assert main(['resume', str(out)]) == 0
    assert result(out) == expected
