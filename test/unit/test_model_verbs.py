# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops model`, `report` and `view`. Truth: what they promise; the files that they leave."""

import fcntl
import json
import os
from types import SimpleNamespace

import numpy as np
import pytest
from reference.model_runs import make_run
from ros_rops.cli import window
from ros_rops.cli.main import main
from ros_rops.cli.modelling import complete
from ros_rops.intake.run_file import RunFile
from ros_rops.pipeline.parameters import load_config
from ros_rops.recordings.files import read_bytes
from ros_rops.recordings.ply import parse_mesh
from ros_rops.reporting.rendering import render
from ros_rops.reporting.shown import read_shown, Shown


@pytest.fixture
def run(tmp_path, monkeypatch):
    for name in ('DISPLAY', 'WAYLAND_DISPLAY'):
        monkeypatch.delenv(name, raising=False)
    make_run(tmp_path / 'run')
    return tmp_path / 'run'


@pytest.fixture(scope='module')
def modelled(tmp_path_factory):
    folder = tmp_path_factory.mktemp('modelled') / 'run'
    make_run(folder)
    assert main(['model', str(folder), '--threads', '1']) == 0
    return folder


def test_model_makes_models_and_report_and_says_what(run, capsys):
    poses = (run / 'poses.json').read_bytes()
    assert main(['model', str(run)]) == 0
    said = capsys.readouterr()
    assert 'object 0: object_0.ply, object_0_surface.ply, object_0_residuals.ply' in said.out
    lines = said.err.splitlines()
    # Before it is used, with its unit.
    assert lines[0] == 'lengths in mm' and any('voxels of' in line for line in lines)
    assert (run / 'report.html').stat().st_size > 1000
    assert (run / 'poses.json').read_bytes() == poses


def test_model_takes_parameters_of_models_and_keeps_them(run):
    coarse = ['model', str(run), '--object', '0', '--voxel-mr', '2', '--format', 'ply,stl']
    assert main([*coarse, '--set', 'model.holes=filled']) == 0
    config = load_config(run / 'config.yaml')
    assert (config.model.voxel_mr, config.model.formats, config.model.holes) == (
        2.0, 'ply,stl', 'filled')
    first = parse_mesh(read_bytes(run / 'object_0_surface.ply'))[1]
    assert (run / 'object_0_surface.stl').exists() and not (run / 'object_1_surface.ply').exists()
    assert main(['model', str(run), '--voxel-mr', '1']) == 0
    assert len(parse_mesh(read_bytes(run / 'object_0_surface.ply'))[1]) > 2 * len(first)
    assert not (run / 'object_0_surface.stl').exists()


def test_model_writes_elsewhere_and_leaves_the_run_alone(run, tmp_path):
    before = {path.name: path.read_bytes() for path in run.iterdir()}
    out = tmp_path / 'deep' / 'models'
    assert main(['model', str(run), '--surface', 'none', '--out', str(out)]) == 0
    assert {path.name: path.read_bytes() for path in run.iterdir()} == before
    assert {path.name for path in out.iterdir()} == {
        'object_0.ply', 'object_0_residuals.ply', 'object_1.ply', 'object_1_residuals.ply',
        'quality.json'}


def test_model_of_a_run_without_a_journal_reads_its_inputs(tmp_path, capsys):
    make_run(tmp_path / 'run', journal=False)
    assert main(['model', str(tmp_path / 'run')]) == 0
    (tmp_path / 'run_in' / 'v1_0.ply').unlink()
    assert main(['model', str(tmp_path / 'run')]) == 2
    assert 'v1_0.ply: is gone since the run' in capsys.readouterr().err


@pytest.mark.parametrize(('words', 'message'), [
    (['--object', '7'], '--object: the run has no object 7; it has: 0, 1'),
    (['--set', 'rops.bins=6'], 'rops.bins: the poses stay as they are'),
    (['--set', 'model.voxel=1'], 'did you mean model.voxel_mr?'),
    (['--voxel-mr', '-1'], 'model.voxel_mr: -1.0 is below'),
    (['--format', 'ply,step'], "model.formats: 'step' is none of"),
    (['--out', 'run/poses.json'], 'poses.json: cannot be written')])
def test_mistakes_of_model_end_with_2_and_one_line(run, words, message, capsys, monkeypatch):
    monkeypatch.chdir(run.parent)
    before = {path.name: path.read_bytes() for path in run.iterdir()}
    assert main(['model', 'run', *words]) == 2
    error = capsys.readouterr().err
    assert error.startswith('rops model: ') and message in error and error.count('\n') == 1
    assert {path.name: path.read_bytes() for path in run.iterdir()} == before


@pytest.mark.parametrize('verb', ['model', 'report', 'view'])
def test_folders_that_are_no_whole_run_are_named(tmp_path, verb, capsys):
    def error(*words):
        assert main([verb, *map(str, words)]) == 2
        text = capsys.readouterr().err
        assert text.count('\n') == 1
        return text

    assert 'nowhere: is no run folder' in error(tmp_path / 'nowhere')
    assert f'{tmp_path}: is no run folder' in error(tmp_path)
    (tmp_path / 'run.json').write_text('{}')
    assert 'has no result yet; `rops resume' in error(tmp_path)
    (tmp_path / 'poses.json').write_text('[]')
    assert 'is not the poses.json of a run' in error(tmp_path)


@pytest.mark.parametrize('verb', ['model', 'report'])
def test_a_run_that_another_process_works_on_is_left_alone(run, verb, capsys):
    handle = os.open(run, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        assert main([verb, str(run)]) == 2
        assert 'another process is working on this run' in capsys.readouterr().err
        if verb == 'model':  # what is written elsewhere disturbs nobody
            assert main(['model', str(run), '--out', str(run.parent / 'out')]) == 0
    finally:
        os.close(handle)


def test_a_run_without_objects_has_nothing_to_model_or_view(run, capsys):
    document = json.loads((run / 'poses.json').read_text())
    (run / 'poses.json').write_text(json.dumps({**document, 'objects': []}))
    for verb in ('model', 'view'):
        assert main([verb, str(run)]) == 1
        assert 'the run has no object' in capsys.readouterr().out
    assert main(['report', str(run)]) == 0


def test_resume_makes_what_a_run_lacks_that_was_killed_after_its_poses(run, modelled, capsys):
    def files(folder):
        return {path.name: path.read_bytes() for path in folder.iterdir()
                if path.suffix == '.ply' or path.name in ('poses.json', 'quality.json')}

    (run / '.models').mkdir()
    (run / '.models' / 'object_0.ply').write_bytes(b'ply')
    assert main(['resume', str(run)]) == 0
    assert files(run) == files(modelled) and not (run / '.models').exists()
    assert (run / 'report.html').exists()
    # As if it had ended between the first object and the second.
    content = json.loads((run / 'quality.json').read_text())
    (run / 'quality.json').write_text(
        json.dumps({**content, 'objects': content['objects'][:1]}))
    (run / 'object_1_surface.ply').unlink()
    (run / 'report.html').unlink()
    assert main(['resume', str(run)]) == 0
    assert files(run) == files(modelled) and (run / 'report.html').exists()
    capsys.readouterr()
    assert main(['resume', str(run)]) == 0
    assert 'there is nothing to go on with' in capsys.readouterr().out


def test_resume_says_why_models_that_are_missing_cannot_be_made(tmp_path, capsys):
    make_run(tmp_path / 'run', journal=False)
    (tmp_path / 'run_in' / 'v1_0.ply').unlink()
    assert main(['resume', str(tmp_path / 'run')]) == 0
    assert 'v1_0.ply: is gone since the run' in capsys.readouterr().err
    assert (tmp_path / 'run' / 'report.html').exists()


def test_a_part_of_the_input_that_was_not_read_is_said(run, capsys):
    document = json.loads((run / 'poses.json').read_text())
    (run / 'poses.json').write_text(json.dumps({**document, 'complete': False}))
    assert main(['model', str(run), '--surface', 'none']) == 0
    assert 'a part of the input was not read' in capsys.readouterr().err


def test_nothing_made_ends_with_1(run, monkeypatch, capsys):
    def failing(*given, **more):
        raise MemoryError('no room')

    monkeypatch.setattr('ros_rops.reporting.models.build_model', failing)
    assert main(['model', str(run)]) == 1
    assert 'object 0: not made: no room (MemoryError)' in capsys.readouterr().err


@pytest.mark.parametrize(('error', 'message'), [
    (KeyboardInterrupt(), 'interrupted; the poses are written, and `rops model'),
    (OSError(28, 'No space left on device'), 'no models: ')])
def test_what_stops_the_models_of_a_run_costs_nothing_else(
        tmp_path, monkeypatch, capsys, error, message):
    def failing(*given, **more):
        raise error

    task = make_run(tmp_path / 'run')
    poses = (tmp_path / 'run' / 'poses.json').read_bytes()
    monkeypatch.setattr('ros_rops.cli.modelling.make_models', failing)
    complete(tmp_path / 'run', RunFile((), ()), task)
    assert message in capsys.readouterr().err
    assert (tmp_path / 'run' / 'report.html').exists()
    assert (tmp_path / 'run' / 'poses.json').read_bytes() == poses


def test_models_and_report_are_made_as_the_run_wants(tmp_path):
    task = make_run(tmp_path / 'run')
    before = set(tmp_path.glob('run/*'))
    complete(tmp_path / 'run', RunFile((), (), models=False, report=False), task)
    assert set(tmp_path.glob('run/*')) == before
    complete(tmp_path / 'run', RunFile((), (), report=False), task)
    assert (tmp_path / 'run' / 'quality.json').exists()
    assert not (tmp_path / 'run' / 'report.html').exists()


def test_report_prints_its_path(modelled, capsys):
    (modelled / 'report.html').unlink()
    assert main(['report', str(modelled)]) == 0
    assert capsys.readouterr().out.strip() == str(modelled / 'report.html')
    assert (modelled / 'report.html').exists()


@pytest.mark.parametrize('color', ['view', 'residual', 'rgb'])
def test_view_without_a_display_draws_a_picture(modelled, tmp_path, color, capsys, monkeypatch):
    for name in ('DISPLAY', 'WAYLAND_DISPLAY'):
        monkeypatch.delenv(name, raising=False)
    path = tmp_path / 'x.png'
    assert main(['view', str(modelled), '1', '--color', color, '--png', str(path)]) == 0
    assert path.read_bytes().startswith(b'\x89PNG') and f'drawn to {path}' in (
        capsys.readouterr().out)


def test_view_tries_a_window_first_where_there_is_a_display(modelled, monkeypatch, capsys):
    monkeypatch.setenv('DISPLAY', ':nowhere')
    seen = []
    monkeypatch.setattr(window, 'show', lambda shown, title: bool(seen.append(shown)) or True)
    assert main(['view', str(modelled)]) == 0
    assert seen[0].faces is not None and not list(modelled.glob('*.png'))
    monkeypatch.setattr(window, 'show', lambda shown, title: False)
    assert main(['view', str(modelled)]) == 0
    assert 'no window could be opened' in capsys.readouterr().err
    (modelled / 'object_0_rgb.png').unlink()


def test_a_window_of_matplotlib_is_none_without_a_display(modelled, monkeypatch):
    monkeypatch.setattr(window.importlib.util, 'find_spec', lambda name: None)
    monkeypatch.setenv('MPLBACKEND', 'agg')
    assert window.show(read_shown(modelled, 0, 'rgb'), 'x') is False


@pytest.mark.parametrize(('words', 'message'), [
    (['7'], 'OBJECT: the run has no object 7; it has: 0, 1'),
    (['--png', 'x.jpg'], '--png: x.jpg does not end in .png'),
    (['--png', 'no/x.png'], 'x.png: cannot be written')])
def test_mistakes_of_view_end_with_2_and_one_line(
        modelled, tmp_path, words, message, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(['view', str(modelled), *words]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count('\n') == 1


def test_view_shows_what_is_there(run, capsys, tmp_path):
    path = tmp_path / 'x.png'
    assert main(['view', str(run), '--png', str(path)]) == 2
    assert 'object_0.ply: is not there; `rops model' in capsys.readouterr().err
    make_run(run, plain=True)
    assert main(['view', str(run), '--png', str(path)]) == 0
    assert 'object 0, cloud' in capsys.readouterr().out
    assert main(['view', str(run), '--color', 'residual', '--png', str(path)]) == 2
    assert 'object_0_residuals.ply: is not there; `rops model' in capsys.readouterr().err
    (run / 'object_0.ply').write_bytes(b'ply\nformat')
    assert main(['view', str(run), '--png', str(path)]) == 2
    assert 'object_0.ply' in capsys.readouterr().err


def test_what_is_nearer_hides_what_is_behind():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    both = np.concatenate([corners, corners + np.array([0, 0, 1])])
    square = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    colors = np.repeat(np.array([[200, 0, 0], [0, 0, 200]], np.uint8), 4, axis=0)
    normals = np.tile([0.0, 0.0, 1.0], (8, 1))
    shown = Shown(both, normals, colors, np.concatenate([square, square + 4]), '')
    middle = np.s_[10:40, 10:40]
    front = render(shown, np.eye(3), 50)[middle]
    back = render(shown, np.diag([-1.0, 1.0, -1.0]), 50)[middle]
    assert (front == (0, 0, 200)).all() and (back == (200, 0, 0)).all()
    points = SimpleNamespace(points=both, normals=normals, colors=colors, faces=None)
    assert (render(points, np.eye(3), 50) != 255).any()
