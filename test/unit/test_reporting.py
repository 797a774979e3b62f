# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The run folder. Truth: what the session said, put together here by hand."""

from concurrent.futures import ThreadPoolExecutor
import errno
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.core.types import RangeView, Status
from ros_rops.pipeline.parameters import load_config
from ros_rops.recordings.reader import read_view
from ros_rops.reporting.clouds import assemble
from ros_rops.reporting.explain import explain
from ros_rops.reporting.picture import principal_frame
from ros_rops.reporting.poses import plain
from ros_rops.reporting.run import Refusal, Run
from ros_rops.reporting.run_folder import point_latest, prepare_folder, write_run
from ros_rops.reporting.table import result_table

SHIFT = np.array([
    [0.0, -1.0, 0.0, 0.1], [1.0, 0.0, 0.0, 0.2], [0.0, 0.0, 1.0, 1 / 3], [0.0, 0.0, 0.0, 1.0]])


def _view(name: str, colors: bool = False) -> RangeView:
    x, y = np.meshgrid(np.arange(8.0), np.arange(6.0))
    points = np.stack([x, y, 0.1 * x * y], axis=-1).reshape(-1, 3)
    return RangeView(
        name, points, np.arange(48).reshape(6, 8),
        colors=np.full((48, 3), 7, np.uint8) if colors else None)


@pytest.fixture
def run():
    views = {name: _view(name, name == 'b.ply') for name in ('a.ply', 'b.ply', 'c.ply')}
    placed = [
        SimpleNamespace(name='a.ply', T_object_view=np.eye(4), numbers={}),
        SimpleNamespace(name='b.ply', T_object_view=SHIFT, numbers={})]
    word = {'overlap': np.float64(0.4), 'score': 0.25, 'gap': np.inf, 'matches': np.int64(3)}
    reports = [
        SimpleNamespace(name='a.ply', status=Status.PLACED, object_id=0, reason='', numbers=word),
        SimpleNamespace(name='b.ply', status=Status.PLACED, object_id=0, reason='', numbers=word),
        SimpleNamespace(name='c.ply', status=Status.PENDING, object_id=None,
                        reason='fits nothing yet', numbers={})]
    trace = [
        SimpleNamespace(
            source='b.ply', target='a.ply', source_views=('b.ply',), target_views=('a.ply',),
            status=Status.PLACED, reason='',
            numbers={'matches': 30, 'refined': 5, 'score': 0.25}, seconds={'match': 0.01}),
        SimpleNamespace(
            source='c.ply', target='b.ply', source_views=('c.ply',),
            target_views=('b.ply', 'a.ply'), status=Status.REFUSED, reason='no group',
            numbers={'matches': 20.0, 'ccv_groups': 0.0, 'rival': 0.0}, seconds={'match': 0.01}),
        SimpleNamespace(
            source='c.ply', target='b.ply', source_views=('c.ply',), target_views=('b.ply',),
            status=Status.REFUSED, reason='score 0.01 < 0.04',
            numbers={'matches': 20.0, 'refined': 4.0, 'score': 0.01, 'in_front': 0.0}, seconds={})]
    session = SimpleNamespace(
        reports=reports, objects=[SimpleNamespace(id=0, views=placed)], views=views, units='mm',
        mesh_resolution=np.float64(1.25), attempts=3, stage_seconds={'match': 0.02}, trace=trace,
        station={})
    return Run(
        session, Config.from_flat({'rops.bins': 6}), ('a.ply', 'bad.ply', 'b.ply', 'c.ply'),
        {'bad.ply': Refusal('bad.ply', 'bad.ply: truncated')}, {'seconds': 1.5})


@pytest.fixture
def folder(run, tmp_path):
    prepare_folder(tmp_path / 'runs' / 'one')
    write_run(tmp_path / 'runs' / 'one', run)
    return tmp_path / 'runs' / 'one'


def test_poses_json_has_every_view_in_order(folder):
    poses = json.loads((folder / 'poses.json').read_text(encoding='utf-8'))
    assert (poses['units'], poses['mesh_resolution'], poses['attempts']) == ('mm', 1.25, 3)
    assert [view['name'] for view in poses['views']] == ['a.ply', 'bad.ply', 'b.ply', 'c.ply']
    assert [view['status'] for view in poses['views']] == [
        'placed', 'refused', 'placed', 'pending']
    assert [view['object'] for view in poses['views']] == [0, None, 0, None]
    assert poses['views'][1]['reason'] == 'bad.ply: truncated'
    assert poses['views'][0]['score'] == 0.25 and poses['views'][0]['gap'] is None
    assert poses['objects'][0]['id'] == 0
    # To the last bit.
    assert np.array_equal(poses['objects'][0]['views'][1]['T_object_view'], SHIFT)


def test_same_run_gives_the_same_bytes(folder, run):
    prepare_folder(folder.parent / 'two')
    write_run(folder.parent / 'two', run)
    for name in ('poses.json', 'object_0.ply', 'config.yaml'):
        assert (folder / name).read_bytes() == (folder.parent / 'two' / name).read_bytes()


def test_object_file_holds_all_its_views_in_the_objects_frame(folder, run):
    cloud = read_view(folder / 'object_0.ply', units='mm')
    views = run.session.views
    moved = views['b.ply'].points @ SHIFT[:3, :3].T + SHIFT[:3, 3]
    np.testing.assert_array_equal(cloud.points, np.concatenate([views['a.ply'].points, moved]))
    assert set(map(tuple, cloud.colors)) == {(180, 180, 180), (7, 7, 7)}
    header = (folder / 'object_0.ply').read_bytes().partition(b'end_header')[0]
    assert b'property float nx' in header and b'property int view_id' in header


def test_assembled_normals_turn_with_the_view_and_ids_count_in_the_run(run):
    cloud = assemble(run.session.objects[0], run.session.views, run.config, run.order)
    np.testing.assert_allclose(
        cloud.normals[48:], cloud.normals[:48] @ SHIFT[:3, :3].T, atol=1e-15)
    assert list(np.unique(cloud.view_ids)) == [0, 2]


def test_config_metrics_and_latest(folder):
    assert load_config(folder / 'config.yaml') == Config.from_flat({'rops.bins': 6})
    metrics = json.loads((folder / 'metrics.json').read_text(encoding='utf-8'))
    assert metrics['views'] == {'placed': 2, 'pending': 1, 'ambiguous': 0, 'refused': 1}
    assert (metrics['stage_seconds'], metrics['seconds']) == ({'match': 0.02}, 1.5)
    assert (folder.parent / 'latest').resolve() == folder.resolve()
    assert (folder / 'picture.png').read_bytes().startswith(b'\x89PNG')


def test_what_an_earlier_run_left_is_taken_out(folder, run):
    (folder / 'object_7.ply').write_text('old', encoding='utf-8')
    (folder / 'mine.txt').write_text('kept', encoding='utf-8')
    prepare_folder(folder)
    write_run(folder, run)
    assert not (folder / 'object_7.ply').exists() and (folder / 'mine.txt').exists()


def test_a_file_named_latest_is_left_alone(run, tmp_path):
    (tmp_path / 'latest').write_text('mine', encoding='utf-8')
    prepare_folder(tmp_path / 'one')
    write_run(tmp_path / 'one', run, picture=False)
    assert (tmp_path / 'latest').read_text(encoding='utf-8') == 'mine'


def test_a_run_without_objects_is_written_too(run, tmp_path):
    run.session.objects.clear()
    prepare_folder(tmp_path / 'none')
    write_run(tmp_path / 'none', run)
    assert json.loads((tmp_path / 'none' / 'poses.json').read_text())['objects'] == []


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / 'file').write_text('', encoding='utf-8')
    with pytest.raises(InputError, match=r'file.*cannot be written'):
        prepare_folder(tmp_path / 'file' / 'run')


def test_table_names_every_view_and_sums_up(folder):
    table = result_table(json.loads((folder / 'poses.json').read_text(encoding='utf-8')))
    lines = table.splitlines()
    assert lines[0].split() == ['view', 'status', 'object', 'overlap', 'score', 'reason']
    assert lines[1].split() == ['a.ply', 'placed', '0', '0.4', '0.25']
    assert lines[-2].startswith('lengths in mm; mesh resolution (mr) ')
    assert lines[-1] == '2 of 4 views placed in 1 object; 3 registrations attempted'


def test_explain_says_where_a_view_was_lost(folder):
    text = explain(folder)
    row = next(line for line in text.splitlines() if line.startswith('c.ply'))
    # The attempt that came furthest, not the one that lost everything in the groups.
    assert row.split(maxsplit=3)[3] == (
        'furthest with b.ply: refused by the verdict: score 0.01 < 0.04')
    assert 'no registration was tried: bad.ply: truncated' in text


def test_explain_tells_the_stages_of_a_view_and_of_a_pair(folder):
    text = explain(folder, ['c.ply'])
    assert 'c.ply against b.ply (with 1 more): no ccv_groups left of 20 matches: no group' in text
    pair = explain(folder, ['c.ply', 'a.ply'])
    # What was tried with the object that held a.ply counts, what with b.ply alone does not.
    assert 'c.ply against b.ply (with 1 more)' in pair and 'c.ply against b.ply:' not in pair


@pytest.mark.parametrize(('names', 'message'), [
    (['z.ply'], "the run has no 'z.ply'"), (['.ply'], 'fits 4 views')])
def test_explain_names_a_wrong_view(folder, names, message):
    with pytest.raises(ParameterError, match=message):
        explain(folder, names)


def test_explain_names_a_folder_that_is_no_run(tmp_path):
    with pytest.raises(InputError, match=r'poses\.json: cannot be read'):
        explain(tmp_path)
    for name in ('poses.json', 'trace.json'):
        (tmp_path / name).write_text('{}', encoding='utf-8')
    with pytest.raises(InputError, match='is not a run folder'):
        explain(tmp_path)
    (tmp_path / 'poses.json').write_text('{', encoding='utf-8')
    with pytest.raises(InputError, match='is no JSON'):
        explain(tmp_path)


def test_plain_values_are_json_s_own():
    value = plain({'a': np.float64(0.1), 'b': [np.int32(2), np.nan], 'c': np.bool_(True)})
    assert value == {'a': 0.1, 'b': [2, None], 'c': True}
    assert type(value['b'][0]) is int and type(value['c']) is bool


def test_principal_frame_is_a_rotation_ordered_by_extent():
    rng = np.random.default_rng(0)
    frame = principal_frame(rng.normal(size=(500, 3)) * [1.0, 9.0, 3.0])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert np.abs(frame).argmax(axis=1).tolist() == [1, 2, 0]


def test_a_save_that_fails_leaves_the_result_before_it_whole(folder, run, monkeypatch):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    run.session.objects[0].views.pop()

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, 'No space left on device')

    monkeypatch.setattr('ros_rops.reporting.run_folder.trace_document', full)
    with pytest.raises(InputError, match='No space left'):
        write_run(folder, run)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    monkeypatch.undo()
    (folder / '.fresh').mkdir()  # a process that was killed left it
    write_run(folder, run)
    assert {path.name for path in folder.iterdir()} == set(before)
    assert (folder / 'object_0.ply').read_bytes() != before['object_0.ply']


def test_runs_beside_each_other_may_point_to_themselves_at_once(tmp_path):
    folders = [tmp_path / f'run_{number}' for number in range(4)]

    def point(folder: Path) -> None:
        for _ in range(200):
            point_latest(folder)

    with ThreadPoolExecutor() as pool:
        list(pool.map(point, folders))
    assert (tmp_path / 'latest').readlink().name in {folder.name for folder in folders}
    assert [path.name for path in tmp_path.iterdir()] == ['latest']
