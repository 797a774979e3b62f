# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Models of a station's saved runs. Truth: the models that are made in this process."""

from contextlib import contextmanager
import json
import os
import threading
import time

import pytest
from reference.live import cloud, Heard, offer_all, PATIENCE, PLAIN, small, station
from reference.model_runs import make_run
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.intake.lock import locked
from ros_rops.live import modeller as module
from ros_rops.live.board import Board
from ros_rops.live.modeller import Job, Modeller
from ros_rops.pipeline.parameters import load_config
from ros_rops.reporting.models import make_models

ENDLESS = 'import sys, time; sys.stdin.buffer.read(100); time.sleep(600)'
"""A process that never comes to its end by itself."""


@contextmanager
def modelling():
    board = Board()
    made = Modeller(board)
    thread = threading.Thread(target=made.run)
    thread.start()
    try:
        yield made, board
    finally:
        made.close()
        thread.join(PATIENCE)
        assert not thread.is_alive()


def _job(folder, task, *, models=True, report=True):
    return Job(folder, task, models, report, 0, os.open(folder, os.O_RDONLY), f'saved to {folder}')


def _wait(condition):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, 'it never came'
        time.sleep(0.01)


def _models(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()
            if path.name.startswith('object_') or path.name == 'quality.json'}


@pytest.fixture
def run(tmp_path):
    return tmp_path / 'run', make_run(tmp_path / 'run')


@pytest.fixture
def endless(monkeypatch):
    """Let the process be one that never ends."""
    real = module.subprocess.Popen
    monkeypatch.setattr(
        module.subprocess, 'Popen',
        lambda words, **more: real([words[0], '-c', ENDLESS], **more))


def test_models_are_those_of_this_process(run, tmp_path):
    folder, task = run
    with modelling() as (made, board):
        made.put(_job(folder, task))
        _wait(lambda: board.last_save)
        assert board.last_save.startswith(f'saved to {folder}; models and report written in ')
        assert board.last_save.endswith(f' s: {folder}/report.html')
        assert board.errors == 0
    make_run(tmp_path / 'here')
    make_models(tmp_path / 'here', task)
    assert _models(folder) == _models(tmp_path / 'here')
    assert (folder / 'report.html').exists() and not (folder / '.models').exists()


def test_the_newest_save_of_a_run_wins(run, endless, monkeypatch):
    folder, task = run
    with modelling() as (made, board):
        made.put(_job(folder, task))
        _wait(lambda: made._process is not None)
        made.put(_job(folder, task, report=False))
        (folder / '.models').mkdir()
        began = time.monotonic()
        made.withdraw(folder)
        # Nobody writes to the folder any more, and nothing half written lies in it.
        assert time.monotonic() - began < 10.0 and not (folder / '.models').exists()
        assert made._current is None and not made._waiting and board.last_save == ''
        monkeypatch.undo()
        made.put(_job(folder, task, report=False))
        _wait(lambda: board.last_save)
        assert '; models written in ' in board.last_save and not (folder / 'report.html').exists()


def test_it_ends_soon_while_models_are_made(run, endless, tmp_path):
    folder, task = run
    with modelling() as (made, board):
        made.put(_job(folder, task))
        _wait(lambda: made._process is not None)
        process, began = made._process, time.monotonic()
    assert time.monotonic() - began < 10.0 and process.poll() is not None
    assert board.last_save == (
        f'saved to {folder}; the models are not made (the station ends): '
        f'`rops model {folder}` makes them')
    assert board.errors == 0 and (folder / 'poses.json').exists()


def test_a_process_that_is_killed_is_said_and_the_next_is_made(run, endless, monkeypatch):
    folder, task = run
    with modelling() as (made, board):
        made.put(_job(folder, task))
        _wait(lambda: made._process is not None)
        made._process.kill()
        _wait(lambda: board.last_save)
        assert board.errors == 1 and 'the process ended with -9' in board.last_error
        assert '`rops model' in board.last_save
        monkeypatch.undo()
        made.put(_job(folder, task, models=False))
        _wait(lambda: '; report written in ' in board.last_save)
        assert board.errors == 1


def test_too_many_that_wait_are_given_up(run, endless):
    folder, task = run
    with modelling() as (made, board):
        made.put(_job(folder, task))
        _wait(lambda: made._process is not None)
        for _ in range(module.MOST_WAITING):
            made.put(_job(folder, task))
        assert board.last_save == ''
        made.put(_job(folder, task))
        assert 'too many runs wait' in board.last_save


def test_what_cannot_be_made_is_told(run):
    folder, task = run
    task.views.pop('v0_0.ply')
    with modelling() as (made, board):
        made.put(_job(folder, task, report=False))
        _wait(lambda: board.last_save)
        assert '; models: not all is as it should be, after ' in board.last_save
        assert board.errors == 1 and ': object 0: not made: ' in board.last_error


def test_a_folder_is_held_until_its_models_are_made(run, endless):
    folder, task = run
    with modelling() as (made, _):
        with locked(folder) as handle:
            job = _job(folder, task)
            os.close(job.hold)
            made.put(Job(folder, task, True, True, 0, os.dup(handle), 'saved'))
        _wait(lambda: made._process is not None)
        with pytest.raises(InputError, match='another process'), locked(folder):
            pass
        made.withdraw(folder)
        with locked(folder):
            pass


def test_a_station_that_saves_has_models_made(tmp_path):
    heard = Heard()
    wanted = {'output__models': True, 'output__report': True}
    with station(tmp_path, heard, PLAIN, **wanted) as made:
        offer_all(made, heard, [small(0), small(1)])
        made.reconfigure(Config.from_flat({**PLAIN, 'model.voxel_mr': 2.5}))
        assert made.save().success
        _wait(lambda: 'models and report written' in made.state().last_save)
        assert made.state().modelling == '' and made.state().errors == 0
        folder = tmp_path / 'run_0001'
        assert json.loads((folder / 'quality.json').read_text())['objects'] == []
        made.reset()
        offer_all(made, heard, [cloud([[0, 0, 1]], 1)])
    assert (folder / 'report.html').exists()
    assert load_config(folder / 'config.yaml').model.voxel_mr == 2.5
    content = json.loads((tmp_path / 'run_0002' / 'run.json').read_text())
    assert content['models'] is True and content['report'] is True
