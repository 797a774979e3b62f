# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Judging run folders. Truth: analytic (exact poses, written moved by known amounts)."""

import json

import numpy as np
import pytest
from reference.bench_sets import random_pose, strip_set, turned
from ros_rops.bench.evaluate import evaluate, evaluate_run, known_views
from ros_rops.bench.run_folder import match_names, read_run
from ros_rops.core.errors import InputError
from ros_rops.recordings.writers import write_dataset, write_poses


def write_run(folder, dataset, *, units='m', factor=1.0, moved=None, left_out=(), suffix='',
              centroids=False):
    """Write the poses.json that a run with exact poses (but for `moved`) would write."""
    frame = random_pose(np.random.default_rng(5))
    placed, views = [], []
    for name, T in dataset.T_world_view.items():
        here = name not in left_out
        view = {'name': name + suffix, 'status': 'placed' if here else 'pending'}
        if centroids:
            view['centroid'] = (factor * dataset.views[name].points.mean(axis=0)).tolist()
        views.append(view)
        if here:
            T = frame @ (moved or {}).get(name, T)
            T = np.vstack([np.hstack([T[:3, :3], T[:3, 3:] * factor]), T[3]])
            placed.append({'name': name + suffix, 'T_object_view': T.tolist()})
    content = {
        'units': units, 'mesh_resolution': dataset.dres * factor,
        'objects': [{'id': 1, 'views': placed}], 'views': views, 'attempts': 7}
    folder.mkdir(exist_ok=True)
    (folder / 'poses.json').write_text(json.dumps(content))
    return folder


@pytest.fixture
def dataset():
    return strip_set(starts=(0, 2, 4, 6))


def test_exact_poses_have_no_error_whatever_the_units(dataset, tmp_path):
    for units, factor in (('m', 1.0), ('mm', 1000.0)):
        run = read_run(write_run(tmp_path / units, dataset, units=units, factor=factor))
        result = evaluate(run, known_views([dataset]))
        numbers = result.numbers()
        assert (numbers['views'], numbers['placed'], numbers['attempts']) == (4, 4, 7)
        assert numbers['max_rotation_deg'] < 1e-6
        assert numbers['max_translation_dres'] < 1e-6
        assert numbers['translation_measured_at'] == 'centroid'
        # Strips of one plane lie on each other exactly.
        assert numbers['objects'][0]['residual_dres'] == pytest.approx(0.0, abs=1e-6)


def test_unreconciled_units_would_show(dataset, tmp_path):
    run = read_run(write_run(tmp_path / 'run', dataset, units='m', factor=1000.0))
    assert evaluate(run, known_views([dataset]), residuals=False).judgement.wrong_placements


def test_unknown_units_are_taken_as_the_reference_and_noted(dataset, tmp_path):
    run = read_run(write_run(tmp_path / 'run', dataset, units='unknown'))
    result = evaluate(run, known_views([dataset]), residuals=False)
    assert not result.judgement.wrong_placements
    assert 'unknown' in result.notes[0]


def test_a_wrong_view_and_one_left_out_are_told(dataset, tmp_path):
    T = dataset.T_world_view['view02']
    centroid = dataset.views['view02'].points.mean(axis=0)
    write_run(tmp_path / 'run', dataset, left_out=['view06'],
              moved={'view02': turned(T, 12.0, centroid)})
    numbers = evaluate(read_run(tmp_path / 'run'), known_views([dataset])).numbers()
    assert (numbers['placed'], numbers['wrong_placements']) == (3, 1)
    assert numbers['wrong_views'] == ['set/view02']
    assert numbers['errors']['set/view02']['rotation_deg'] == pytest.approx(12.0)
    assert numbers['max_rotation_deg'] == pytest.approx(12.0)


def on_disk(folder, dataset):
    write_dataset(
        folder, list(dataset.views.values()), dataset.T_world_view, units=dataset.units)
    return folder


def test_a_run_folder_against_a_dataset_folder(dataset, tmp_path):
    folder = on_disk(tmp_path / 'strips', dataset)
    run = write_run(tmp_path / 'run', dataset, suffix='.ply')
    numbers = evaluate_run(run, [folder]).numbers()
    assert (numbers['placed'], numbers['wrong_placements']) == (4, 0)
    assert numbers['max_translation_dres'] < 1e-3


@pytest.mark.parametrize('centroids', [True, False])
def test_a_run_against_a_file_of_exact_poses(dataset, tmp_path, centroids):
    truth = tmp_path / 'exact.json'
    write_poses(truth, dataset.T_world_view, units='m')
    run = write_run(
        tmp_path / 'run', dataset, units='mm', factor=1000.0, centroids=centroids,
        moved={'view02': turned(dataset.T_world_view['view02'], 1.0,
                                dataset.views['view02'].points.mean(axis=0))})
    numbers = evaluate_run(run, [truth]).numbers()
    assert numbers['translation_measured_at'] == ('centroid' if centroids else 'origin')
    assert any('origin' in note for note in numbers['notes']) is not centroids
    assert numbers['objects'][0]['residual_dres'] is None
    assert numbers['placed'] == 4
    # Of four views one is turned by 1 degree: the mean takes a quarter of it.
    assert numbers['max_rotation_deg'] == pytest.approx(0.75, abs=1e-3)


def test_two_objects_in_a_file_of_exact_poses(tmp_path):
    a, b = strip_set('a', starts=(0, 2, 4)), strip_set('b', starts=(50, 52), seed=9)
    poses = {**a.T_world_view, **b.T_world_view}
    objects = {**dict.fromkeys(a.views, 'cat'), **dict.fromkeys(b.views, 'dog')}
    write_poses(tmp_path / 'exact.json', poses, units='m', objects=objects)
    run_a = json.loads((write_run(tmp_path / 'run', a) / 'poses.json').read_text())
    run_b = json.loads((write_run(tmp_path / 'run', b) / 'poses.json').read_text())
    run_b['objects'][0]['id'] = 2
    for key in ('objects', 'views'):
        run_a[key] += run_b[key]
    (tmp_path / 'run' / 'poses.json').write_text(json.dumps(run_a))
    numbers = evaluate_run(tmp_path / 'run', [tmp_path / 'exact.json']).numbers()
    assert (numbers['views'], numbers['placed'], numbers['wrong_merges']) == (5, 5, 0)
    assert [one['label'] for one in numbers['objects']] == ['cat', 'dog']
    run_a['objects'] = [{'id': 1, 'views': [v for o in run_a['objects'] for v in o['views']]}]
    (tmp_path / 'run' / 'poses.json').write_text(json.dumps(run_a))
    merged = evaluate_run(tmp_path / 'run', [tmp_path / 'exact.json']).numbers()
    assert (merged['wrong_merges'], merged['splits']) == (1, 0)


def test_names_match_by_their_last_part_if_that_is_clear():
    truth = ['bunny/a.ply', 'bunny/b.ply', 'chef/b.ply']
    given = ['a.ply', 'x/bunny/views/b.ply', 'b.ply', 'chef/b.ply', 'c.ply']
    assert match_names(given, truth) == {
        'a.ply': 'bunny/a.ply', 'x/bunny/views/b.ply': 'bunny/b.ply', 'chef/b.ply': 'chef/b.ply'}


@pytest.mark.parametrize(('content', 'fault'), [
    ('', 'not the poses.json'), ('[]', 'not the poses.json'), ('{}', 'KeyError'),
    ('{"units": "m", "mesh_resolution": 1, "views": [], "objects": [{"id": 1, "views": '
     '[{"name": "a", "T_object_view": [[1]]}]}]}', 'expected a finite 4x4'),
])
def test_a_run_that_is_none_is_named(tmp_path, content, fault):
    (tmp_path / 'poses.json').write_text(content)
    with pytest.raises(InputError, match=fault) as caught:
        read_run(tmp_path)
    assert 'poses.json' in str(caught.value)


def test_a_missing_run_is_named(tmp_path):
    with pytest.raises(InputError, match='nowhere'):
        read_run(tmp_path / 'nowhere')


def test_a_run_of_other_views_is_refused(dataset, tmp_path):
    folder = on_disk(tmp_path / 'strips', dataset)
    run = write_run(tmp_path / 'run', strip_set(starts=(70, 80)))
    with pytest.raises(InputError, match='none of its views'):
        evaluate_run(run, [folder])


def test_a_view_placed_twice_is_refused(dataset, tmp_path):
    run = write_run(tmp_path / 'run', dataset)
    content = json.loads((run / 'poses.json').read_text())
    twin = dict(content['objects'][0]['views'][0], name='other/view00')
    content['objects'].append({'id': 2, 'views': [twin]})
    (run / 'poses.json').write_text(json.dumps(content))
    with pytest.raises(InputError, match='twice'):
        evaluate(read_run(run), known_views([dataset]))
