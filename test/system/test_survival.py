# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A run that is killed and gone on with. Truth: the run that was not, byte by byte."""

from dataclasses import replace
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
from reference.streams import frames, record, STILL
from ros_rops.cli.main import main
from ros_rops.intake import journal as journal_module
from ros_rops.intake.lock import locked
from ros_rops.intake.past import Past
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.writers import write_view

COMMAND = [sys.executable, '-m', 'ros_rops.cli.main']
# Beside the time of a run (0 to 1), when it is killed; the rest of the twenty is marked slow.
MOMENTS = np.random.default_rng(20261122).uniform(0.0, 1.1, 20)


@pytest.fixture(scope='module')
def recording(tmp_path_factory) -> Path:
    return record(tmp_path_factory.mktemp('stream') / 'stream.mcap', frames(4, names=('bracket',)))


def _words(recording: Path, out: Path, *more: str) -> list[str]:
    return ['replay', str(recording), '--out', str(out), '--no-picture', *STILL, *more]


def _start(*words: str) -> subprocess.Popen:
    # Ctrl-C must reach it as from a terminal, whatever the tests were started by.
    return subprocess.Popen(
        [*COMMAND, *words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))


def _result(out: Path) -> dict[str, bytes]:
    names = ['poses.json', 'frames.json', *(path.name for path in out.glob('object_*.ply'))]
    return {name: (out / name).read_bytes() for name in sorted(names)}


@pytest.fixture(scope='module')
def whole(recording, tmp_path_factory) -> SimpleNamespace:
    """Return the result of an uninterrupted run, and its seconds by the journal's beginning."""
    out = tmp_path_factory.mktemp('whole') / 'run'
    process = _start(*_words(recording, out, '--threads', '2'))
    _wait_for(out / 'journal.mcap', process)
    started = time.perf_counter()
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    result = _result(out)
    assert [len(item['views']) for item in json.loads(result['poses.json'])['objects']] == [4]
    return SimpleNamespace(result=result, seconds=time.perf_counter() - started, out=out)


def _wait_for(path: Path, process: subprocess.Popen) -> None:
    while not path.exists() and process.poll() is None:
        time.sleep(0.002)


def _kill_and_resume(recording, whole, out, moment, threads):
    process = _start(*_words(recording, out, '--threads', threads))
    _wait_for(out / 'journal.mcap', process)
    time.sleep(moment * whole.seconds)
    process.kill()
    process.communicate()
    assert main(['resume', str(out)]) == 0
    assert _result(out) == whole.result


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
    assert main(_words(recording, out)) == 0
    data = (out / 'journal.mcap').read_bytes()
    for share in (0.35, 0.7):
        _unfinish(out)
        (out / 'journal.mcap').write_bytes(data[:int(share * len(data))])
        assert main(['resume', str(out), '--threads', '1']) == 0
        assert _result(out) == whole.result
        data = (out / 'journal.mcap').read_bytes()
    assert 'are left out: the entry was not finished' in capsys.readouterr().err


def _unfinish(out: Path, state: str = 'running') -> None:
    content = json.loads((out / 'run.json').read_text(encoding='utf-8'))
    (out / 'run.json').write_text(json.dumps({**content, 'state': state}), encoding='utf-8')


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
    process = _start(*_words(recording, out))
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
    assert main(_words(recording, out)) == 2
    assert 'holds an unfinished run' in capsys.readouterr().err
    assert main(['resume', str(out)]) == 0
    assert _result(out) == whole.result


def test_two_at_once_is_one_too_many(whole, tmp_path, capsys):
    out = _copy(whole, tmp_path / 'run')
    _unfinish(out)
    with locked(out):
        assert main(['resume', str(out)]) == 2
        assert 'another process is working on this run' in capsys.readouterr().err
    assert main(['resume', str(out)]) == 0


def test_replayed_five_times_it_is_the_same_bytes(recording, whole, tmp_path):
    for threads in '12121':
        assert main(_words(
            recording, tmp_path / 'run', '--threads', threads, '--overwrite')) == 0
        assert _result(tmp_path / 'run') == whole.result


def test_registering_the_same_views_from_files_gives_the_same(whole, tmp_path):
    folder = tmp_path / 'views'
    folder.mkdir()
    names = []
    for outcome in find_views([whole.out / 'journal.mcap'])[0].views():
        view = outcome.view
        names.append(view.name)
        write_view(folder / f'{view.stamp_ns}.ply', replace(view, units='m'))
    out = tmp_path / 'run'
    assert main(['register', str(folder), '--out', str(out), '--no-picture', '--units', 'm']) == 0
    expected, found = json.loads(whole.result['poses.json']), json.loads(
        (out / 'poses.json').read_text(encoding='utf-8'))
    for one, other in zip(expected['objects'], found['objects'], strict=True):
        assert [view['T_object_view'] for view in one['views']] == [
            view['T_object_view'] for view in other['views']]
    # And from the journal, which is a recording of views, with their names too.
    assert main(['register', str(whole.out / 'journal.mcap'), '--out', str(out), '--no-picture',
                 '--overwrite']) == 0
    assert (out / 'poses.json').read_bytes() == whole.result['poses.json']


def test_the_words_on_frames_and_explain(whole, capsys):
    content = json.loads(whole.result['frames.json'])
    counts = content['counts']
    assert (counts['read'], counts['taken'], counts['skipped'], counts['bad']) == (12, 4, 8, 0)
    assert sum(counts['reasons']['skipped'].values()) == 8
    assert len(content['frames']) == 12 and all(item['reason'] for item in content['frames'])
    metrics = json.loads((whole.out / 'metrics.json').read_text(encoding='utf-8'))
    assert metrics['frames'] == counts and metrics['journal'] == 'whole'
    assert main(['explain', str(whole.out)]) == 0
    assert 'points@' in capsys.readouterr().out


def test_an_input_that_changed_is_said_and_the_journal_used(recording, whole, tmp_path, capsys):
    copy = tmp_path / 'copy.mcap'
    copy.write_bytes(recording.read_bytes())
    out = tmp_path / 'run'
    assert main(_words(copy, out)) == 0
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
    assert _result(out) == whole.result


def _cut_journal(out: Path, views: int) -> None:
    """Leave so many views in a journal, as if the run had been killed then."""
    past, count = Past(out / 'journal.mcap'), 0
    for entry in past:
        count += len(entry.views)
        if count == views:
            break
    os.truncate(out / 'journal.mcap', past.at)
    _unfinish(out)


def test_a_journal_that_is_gone_is_said_and_the_run_begins_anew(whole, tmp_path, capsys):
    out = _copy(whole, tmp_path / 'run')
    _unfinish(out)
    (out / 'journal.mcap').unlink()
    assert main(['resume', str(out)]) == 0
    assert 'is missing; the run begins anew' in capsys.readouterr().err
    assert _result(out) == whole.result


def test_a_damaged_journal_is_used_up_to_the_damage_and_kept(whole, tmp_path, capsys):
    out = _copy(whole, tmp_path / 'run')
    _unfinish(out)
    data = bytearray((out / 'journal.mcap').read_bytes())
    data[len(data) // 2] ^= 0xFF
    (out / 'journal.mcap').write_bytes(data)
    assert main(['resume', str(out)]) == 0
    assert 'damaged' in capsys.readouterr().err
    assert (out / 'journal.damaged.mcap').read_bytes() == data
    assert _result(out) == whole.result


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
    assert main(_words(recording, out)) == 0
    error = capsys.readouterr().err
    assert error.count('the journal broke off') == 1 and 'No space left on device' in error
    assert _result(out) == whole.result
    metrics = json.loads((out / 'metrics.json').read_text(encoding='utf-8'))
    assert 'No space left on device' in metrics['journal']
    monkeypatch.undo()
    _unfinish(out)
    assert main(['resume', str(out)]) == 0
    assert _result(out) == whole.result


def test_a_result_that_cannot_be_written_loses_no_view(recording, whole, tmp_path):
    """Truth: files beyond a size fail as on a full disk; the journal is below it."""
    out = tmp_path / 'run'
    words = _words(recording, out)
    limit = f'import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({400_000}, -1)); '
    code = limit + f'from ros_rops.cli.main import main; raise SystemExit(main({words!r}))'
    done = subprocess.run(
        [sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2 and 'object_0.ply: cannot be written' in done.stderr
    assert sum(len(entry.views) for entry in Past(out / 'journal.mcap')) == 4
    recording = recording.rename(tmp_path / 'away.mcap')  # the journal alone will do
    try:
        assert main(['resume', str(out)]) == 0
    finally:
        recording.rename(Path(words[1]))
    assert _result(out) == whole.result


def test_files_are_refused_by_replay(tmp_path, capsys):
    (tmp_path / 'a.xyz').write_text('0 0 1\n', encoding='utf-8')
    assert main(['replay', str(tmp_path / 'a.xyz'), '--out', str(tmp_path / 'run')]) == 2
    assert 'is no recording' in capsys.readouterr().err


def test_files_are_resumed_too_and_an_unreadable_one_keeps_its_word(whole, tmp_path):
    folder = tmp_path / 'in'
    folder.mkdir()
    for k, outcome in enumerate(find_views([whole.out / 'journal.mcap'])[0].views()):
        write_view(folder / f'view{k}.ply', outcome.view)
    (folder / 'view1_bad.ply').write_bytes(b'ply\nnonsense')
    out = tmp_path / 'run'
    assert main(['register', str(folder), '--out', str(out), '--no-picture']) == 0
    expected = _result(out)
    _cut_journal(out, 3)
    (folder / 'view1_bad.ply').unlink()  # it has its word already
    (folder / 'view0.ply').unlink()
    assert main(['resume', str(out)]) == 0
    assert _result(out) == expected
