# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The live station with real views. Truth: `rops replay` of them, and a run without a break."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

from meta.tree import ROOT
import numpy as np
import pytest
from reference.live import (
    Heard, offer_all, recorded, run_with_commands, saved, station, STILL)
from reference.runs import BARE, result, unfinish
from ros_rops.cli.main import main
from ros_rops.intake.past import Past
from ros_rops.pipeline.session import Session
from ros_rops.recordings.mcap_files import create_mcap

# Of the whole run's time: when a station is killed.
MOMENTS = (0.25, 0.6, 0.95)
CHILD = """
import sys
from pathlib import Path
sys.path.insert(0, 'test')
from reference.live import Heard, recorded, run_with_commands, station, STILL
folder, recording = map(Path, sys.argv[1:])
heard = Heard()
with station(folder, heard, STILL) as made:
    print('ready', flush=True)
    run_with_commands(made, heard, recorded(recording))
"""


def _poses(folder):
    return json.loads((folder / 'poses.json').read_text(encoding='utf-8'))


def _matrices(document):
    return [
        (item['id'], [view['T_object_view'] for view in item['views']])
        for item in document['objects']]


@pytest.fixture(scope='module')
def live(recording, tmp_path_factory):
    """Return the folder of a station's run without a break, and its seconds."""
    folder, heard = tmp_path_factory.mktemp('live'), Heard()
    started = time.perf_counter()
    with station(folder, heard, STILL) as made:
        run_with_commands(made, heard, recorded(recording))
        seconds = time.perf_counter() - started
        made.finish()
        assert saved(made, heard).startswith('saved')
        assert made.state().errors == 0
    return folder / 'run_0001', seconds


def test_the_same_frames_give_the_poses_of_a_replay(recording, whole, tmp_path):
    heard = Heard()
    with station(tmp_path, heard, STILL) as made:
        offer_all(made, heard, recorded(recording))
        made.finish()
        saved(made, heard)
    found, expected = _poses(tmp_path / 'latest'), json.loads(whole.result['poses.json'])
    assert len(found['objects']) and _matrices(found) == _matrices(expected)
    assert [view['status'] for view in found['views']] == [
        view['status'] for view in expected['views']]
    update = heard.updates[-1]
    assert update.refined and update.units == 'm' and update.resolution > 0
    assert len(update.objects) == len(found['objects'])
    assert sum(handled.report.word.value == 'skipped' for handled in heard.words) == len(
        heard.words) - len(found['views'])


def test_views_with_facts_give_the_files_of_a_replay(whole, tmp_path):
    """Names, units and all that a message cannot say come with the facts."""
    heard = Heard()
    path = tmp_path / 'views.mcap'
    with create_mcap(path) as mcap:
        for entry in Past(whole.out / 'journal.mcap'):
            for view in entry.views:
                mcap.add_view(view)
    assert main(['replay', str(path), '--out', str(tmp_path / 'ref'), *BARE]) == 0
    with station(tmp_path / 'live', heard) as made:
        for raw in recorded(path):
            count = len(heard.words)
            made.offer(raw)
            heard.wait_words(count + 1)
        made.finish()
        saved(made, heard)
    assert result(tmp_path / 'live' / 'latest')['poses.json'] == (
        tmp_path / 'ref' / 'poses.json').read_bytes()


def _start(folder, recording):
    environment = {**os.environ, 'PYTHONPATH': str(ROOT)}
    for name in ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH'):
        environment.pop(name, None)
    return subprocess.Popen(
        [sys.executable, '-c', CHILD, str(folder), str(recording)], cwd=ROOT,
        stdout=subprocess.PIPE, text=True, env=environment)


@pytest.mark.parametrize('moment', MOMENTS)
def test_killed_at_any_moment_it_stands_where_it_stood(moment, recording, live, tmp_path):
    expected, seconds = live
    process = _start(tmp_path, recording)
    assert process.stdout.readline() == 'ready\n'
    time.sleep(moment * seconds)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    killed = tmp_path / 'run_0001'
    shutil.copytree(killed, tmp_path / 'copy')
    past, done = _done(killed)
    heard = Heard()
    with station(tmp_path, heard, STILL, resume=True) as made:
        heard.wait(lambda: heard.updates)
        assert list(heard.updates[-1].views) == past
        made.finish()
        saved(made, heard)
        assert made.state().folder == str(killed)
    assert main(['resume', str(tmp_path / 'copy')]) in (0, 1)
    assert result(tmp_path / 'copy') == result(killed)
    if done:
        assert result(killed) == result(expected)


def _done(folder):
    """Return the names of the views that a journal leaves, and whether it is of a whole run."""
    names, finished = [], False
    for entry in Past(folder / 'journal.mcap'):
        names += [view.name for view in entry.views]
        finished |= entry.command == 'finish'
        if entry.command == 'remove_last_view' and names:
            names.pop()
    return names, finished and len(names) == 3


def test_a_nodes_folder_is_resumed_by_the_command_byte_by_byte(live, tmp_path, capsys):
    folder, _ = live
    copy = tmp_path / 'copy'
    shutil.copytree(folder, copy)
    for name in result(copy):
        (copy / name).unlink()
    assert main(['resume', str(copy)]) == 0
    assert result(copy) == result(folder)
    assert 'left out' not in capsys.readouterr().err
    assert main(['resume', str(copy)]) == 0
    assert 'is finished' in capsys.readouterr().out
    unfinish(copy)
    (copy / 'journal.mcap').unlink()
    assert main(['resume', str(copy)]) == 2
    assert 'has no other input' in capsys.readouterr().err


def test_a_damaged_journal_is_used_up_to_the_damage_and_kept(live, tmp_path):
    folder, _ = live
    shutil.copytree(folder, tmp_path / 'run_0001')
    path = tmp_path / 'run_0001' / 'journal.mcap'
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    heard = Heard()
    with station(tmp_path, heard, STILL, resume=True) as made:
        heard.wait(lambda: heard.updates)
        assert 'damaged' in made.state().last_error and made.state().journal == 'whole'
    assert path.with_suffix('.damaged.mcap').read_bytes() == data
    assert 0 < len(heard.updates[-1].views) < 4


def test_a_full_disk_is_said_and_the_station_goes_on(recording, tmp_path, monkeypatch):
    """Truth: the number of views; the journal fails from the second on."""
    heard = Heard()
    messages = list(recorded(recording))
    with station(tmp_path, heard, STILL) as made:
        offer_all(made, heard, messages[:3])
        with monkeypatch.context() as patch:
            patch.setattr('ros_rops.intake.journal.os.fsync', _no_space)
            offer_all(made, heard, messages[3:6])
        offer_all(made, heard, messages[6:])
        state = made.state()
    assert 'No space left' in state.journal
    views = heard.updates[-1].views
    assert len(views) == state.words['taken'] == 4
    assert sum(len(entry.views) for entry in Past(tmp_path / 'latest' / 'journal.mcap')) < 4
    points = [len(view.points) for view in views.values()]
    assert np.all(np.array(points) > 500)


def test_a_view_that_breaks_the_engine_harms_no_other(recording, tmp_path, monkeypatch):
    """Truth: the poses of the views that came before it."""
    heard, add = Heard(), Session.add

    def failing(self, view):
        report = add(self, view)
        if len(self.views) == 3:
            raise RuntimeError('after it was placed')
        return report

    with station(tmp_path, heard, STILL) as made:
        monkeypatch.setattr(Session, 'add', failing)
        offer_all(made, heard, recorded(recording))
        state = made.state()
    assert state.errors == 1 and state.statuses['refused'] == 1
    before, after = heard.updates[1], heard.updates[-1]
    poses = {
        view.name: view.T_object_view for model in after.objects for view in model.views}
    assert len(before.objects) == 1 and len(poses) == 3
    for view in before.objects[0].views:
        assert np.allclose(poses[view.name], view.T_object_view, atol=1e-12)


def _no_space(handle):
    raise OSError(28, os.strerror(28))
