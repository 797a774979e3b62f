# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Models of a run folder. Truth: balls of known size; what was written before; invariance."""

from dataclasses import replace
import errno
import json

import numpy as np
import pytest
from reference.model_runs import BALLS, make_run, TURNS
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.intake.reread import views_of_run
from ros_rops.modelling import model as model_module
from ros_rops.modelling.model import build_model
from ros_rops.recordings.files import read_bytes
from ros_rops.recordings.ply import parse_mesh, parse_vertices
from ros_rops.reporting.models import make_models

MADE = {f'object_{k}{part}.ply' for k in TURNS for part in ('', '_surface', '_residuals')}


@pytest.fixture(scope='module')
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp('runs') / 'whole'
    task = make_run(folder)
    before = (folder / 'poses.json').read_bytes()
    said = []
    made = make_models(folder, task, say=said.append)
    return folder, task, made, said, before


def _quality(folder):
    return json.loads((folder / 'quality.json').read_text(encoding='utf-8'))


def _bytes(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()
            if path.name.startswith('object_') or path.name == 'quality.json'}


def test_every_object_has_its_files_and_the_poses_stay(whole):
    folder, _, made, said, before = whole
    assert made.notes == () and {name for names in made.objects.values() for name in names} == MADE
    assert (folder / 'poses.json').read_bytes() == before
    # Voxel and memory before they are used.
    assert any('MB' in text and 'object 0' in text for text in said)
    metrics = json.loads((folder / 'metrics.json').read_text())
    assert set(metrics['model_seconds']) == {'mesh', 'cloud', 'surface', 'quality', 'write', 'all'}
    assert metrics['model_peak_rss_mib'] > 0 and not (folder / '.models').exists()


def test_the_surface_lies_on_the_balls_in_the_units_of_the_run(whole):
    vertices, faces = parse_mesh(read_bytes(whole[0] / 'object_0_surface.ply'))
    away = np.min([np.abs(np.linalg.norm(vertices - middle, axis=1) - radius)
                   for middle, radius in BALLS], axis=0)
    # Half a voxel, of about 3 mm.
    assert np.percentile(away, 90) < 1.5 and len(faces) > 500


def test_cloud_and_residuals_have_their_fields(whole):
    cloud = parse_vertices(read_bytes(whole[0] / 'object_0.ply'))
    assert set(cloud) == {'x', 'y', 'z', 'nx', 'ny', 'nz', 'red', 'green', 'blue', 'view_id',
                          'directions', 'weight'}
    assert cloud['x'].dtype == np.float64 and set(cloud['view_id']) <= set(range(6))
    found = parse_vertices(read_bytes(whole[0] / 'object_0_residuals.ply'))
    assert set(found['view_id']) == set(range(6)) and set(found['state']) <= {0, 1, 2}
    assert np.isnan(found['residual'][found['state'] == 0]).all()
    assert np.nanmedian(np.abs(found['residual'])) < 0.5
    alone = np.stack([found[c] for c in ('red', 'green', 'blue')], axis=1)[found['state'] == 0]
    assert len(set(map(tuple, alone))) <= 1


def test_quality_has_every_key_for_every_object(whole):
    document = _quality(whole[0])
    assert document['units'] == 'mm' and [one['id'] for one in document['objects']] == [0, 1]
    for one in document['objects']:
        assert set(one) >= {'id', 'mesh_resolution', 'views', 'worst_views', 'edges', 'loops',
                            'coverage', 'surface', 'cloud', 'summary', 'notes', 'left_out'}
        assert [view['name'] for view in one['views']] == [
            f'v{one["id"]}_{degrees}.ply' for degrees in TURNS[one['id']]]
        assert one['surface'] and one['cloud'] and one['notes'] == []


@pytest.mark.parametrize('journal', [True, False])
def test_the_same_comes_of_the_folder_alone(whole, tmp_path, journal):
    task = make_run(tmp_path / 'again', journal=journal)
    names = [view['name'] for shape in task.document['objects'] for view in shape['views']]
    views = views_of_run(tmp_path / 'again', names, 'mm')
    for name, view in views.items():
        assert np.array_equal(view.points, task.views[name].points), name
        assert view.sensor == task.views[name].sensor or not journal
    if journal:
        make_models(tmp_path / 'again', replace(task, views=views, threads=2))
        assert _bytes(tmp_path / 'again') == _bytes(whole[0])


def test_one_object_made_again_leaves_the_others(whole, tmp_path):
    task = make_run(tmp_path / 'run')
    make_models(tmp_path / 'run', task, only=[1])
    assert set(_bytes(tmp_path / 'run')) == {
        'quality.json', *(name for name in MADE if name.startswith('object_1'))}
    make_models(tmp_path / 'run', task, only=[0])
    assert _bytes(tmp_path / 'run') == _bytes(whole[0])


def test_fewer_formats_take_out_the_files_of_others(tmp_path):
    task = make_run(tmp_path / 'run')
    for formats, suffixes in (('stl, obj', {'.stl', '.obj'}), ('glb', {'.glb'})):
        config = Config.from_flat({'model.formats': formats})
        make_models(tmp_path / 'run', replace(task, config=config), only=[1])
        assert {path.suffix for path in (tmp_path / 'run').glob('*_surface.*')} == suffixes
    with pytest.raises(ParameterError, match=r"model.formats: 'dae' is none of"):
        Config.from_flat({'model.formats': 'ply,dae'})


def test_no_surface_is_made_where_none_is_wanted(tmp_path):
    task = make_run(tmp_path / 'run', values={'model.surface': 'none'})
    assert make_models(tmp_path / 'run', task).notes == ()
    assert not list((tmp_path / 'run').glob('*_surface.*'))
    assert all(one['surface'] is None and one['cloud'] for one in _quality(tmp_path / 'run')[
        'objects'])


@pytest.mark.parametrize('part', ['assemble_cloud', 'judge', 'assess', '_surface'])
def test_a_part_that_fails_costs_no_other(tmp_path, monkeypatch, part):
    def failing(*given, **more):
        raise MemoryError('no room')

    task = make_run(tmp_path / 'run')
    monkeypatch.setattr(model_module, part, failing)
    made = make_models(tmp_path / 'run', task)
    missing = {'assemble_cloud': '', '_surface': '_surface'}.get(part, '_residuals')
    expected = {name for name in MADE if name not in (f'object_{k}{missing}.ply' for k in TURNS)}
    assert {name for names in made.objects.values() for name in names} == expected
    name = {'assemble_cloud': 'cloud', '_surface': 'surface'}.get(part, 'quality')
    assert made.notes == tuple(f'object {k}: no {name}: no room (MemoryError)' for k in TURNS)
    for one in _quality(tmp_path / 'run')['objects']:
        assert one['notes'] == [f'no {name}: no room (MemoryError)']
        assert len(one['views']) == len(TURNS[one['id']])
        assert set(one['views'][0]) >= {'residual', 'confirmed', 'least_constrained', 'flags'}


def test_an_object_that_fails_costs_no_other(tmp_path, monkeypatch):
    task = make_run(tmp_path / 'run')
    left = {name: view for name, view in task.views.items() if not name.startswith('v0')}
    made = make_models(tmp_path / 'run', replace(task, views=left))
    assert set(made.objects) == {1} and made.notes[0].startswith('object 0: not made: ')
    broken, sound = _quality(tmp_path / 'run')['objects']
    assert broken['id'] == 0 and broken['views'] == [] and sound['notes'] == []


def test_a_disk_that_is_full_is_told_and_earlier_files_stay(tmp_path, monkeypatch):
    def full(path, surface, **more):
        raise OSError(errno.ENOSPC, 'No space left on device', str(path))

    task = make_run(tmp_path / 'run', plain=True)
    before = (tmp_path / 'run' / 'object_0.ply').read_bytes()
    monkeypatch.setattr('ros_rops.reporting.model_files.write_surface', full)
    made = make_models(tmp_path / 'run', task)
    assert made.objects == {} and made.notes == tuple(
        f'object {k}: not written: object_{k}_surface.ply: No space left on device'
        for k in TURNS)
    # Nothing of a model that is not whole; what is known of it is in quality.json all the same.
    assert (tmp_path / 'run' / 'object_0.ply').read_bytes() == before
    assert _quality(tmp_path / 'run')['objects'][0]['summary']


def test_views_without_a_mesh_make_no_model(tmp_path):
    model = build_model(3, (), Config())
    assert model.notes == ('no view of it can be meshed',) and model.surface is None
    task = make_run(tmp_path / 'run')
    bare = {name: replace(view, points=view.points[:2], grid=None, colors=None)
            for name, view in task.views.items()}
    made = make_models(tmp_path / 'run', replace(task, views=bare))
    assert made.objects == {0: (), 1: ()} and len(made.notes) == 2


def test_what_is_stopped_leaves_nothing_half_written(tmp_path):
    task = make_run(tmp_path / 'run')
    before = {path.name for path in (tmp_path / 'run').iterdir()}

    def stop(text):
        if text.endswith('writing its files'):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_models(tmp_path / 'run', task, say=stop)
    assert {path.name for path in (tmp_path / 'run').iterdir()} == before


def test_new_poses_take_out_what_was_made_of_earlier_ones(whole, tmp_path):
    folder = tmp_path / 'run'
    make_models(folder, make_run(folder), only=[1])
    (folder / 'report.html').write_text('old')
    (folder / 'object_1_view.png').write_bytes(b'old')
    make_run(folder)
    assert {path.name for path in folder.iterdir()} == {
        'config.yaml', 'journal.mcap', 'metrics.json', 'poses.json', 'run.json', 'trace.json'}


def test_views_that_cannot_be_read_again_are_named(tmp_path):
    make_run(tmp_path / 'a')
    with pytest.raises(InputError, match=r"journal\.mcap lacks the view 'none'"):
        views_of_run(tmp_path / 'a', ['v0_0.ply', 'none'], 'mm')
    (tmp_path / 'a' / 'journal.mcap').unlink()
    with pytest.raises(InputError, match=r'journal\.mcap lacks the view'):
        views_of_run(tmp_path / 'a', ['v0_0.ply'], 'mm')
    make_run(tmp_path / 'b', journal=False)
    path = tmp_path / 'b_in' / 'v0_0.ply'
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match='has changed since the run'):
        views_of_run(tmp_path / 'b', ['v1_0.ply'], 'mm')
    path.unlink()
    with pytest.raises(InputError, match='is gone since the run'):
        views_of_run(tmp_path / 'b', ['v1_0.ply'], 'mm')
