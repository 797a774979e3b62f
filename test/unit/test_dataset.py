# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Dataset folders, poses and sources; truth: what the tests write, and the bunny's poses."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from ros_rops.core.errors import InputError, ParameterError, ShapeError
from ros_rops.core.types import RangeView
from ros_rops.recordings.dataset import read_dataset
from ros_rops.recordings.poses import read_conf, read_poses
from ros_rops.recordings.reader import BadView, NotedView, read_view, read_view_noted
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.writers import write_dataset, write_object, write_view
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))
needs_scans = pytest.mark.skipif(not DATA.is_dir(), reason=f'no real scans at {DATA}')


def some_view(name: str, seed: int = 0, *, grid: bool = True) -> RangeView:
    rng = np.random.default_rng(seed)
    cells = np.where(rng.random((7, 11)) < 0.3, -1, 0).astype(np.int32)
    cells[cells == 0] = np.arange(np.count_nonzero(cells == 0))
    points = rng.normal(size=(cells.max() + 1, 3))
    colors = rng.integers(0, 256, points.shape).astype(np.uint8)
    return RangeView(name, points, cells if grid else None, colors=colors)


def some_pose(seed: int) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.random(random_state=seed).as_matrix()
    T[:3, 3] = np.random.default_rng(seed).normal(size=3)
    return T


@pytest.mark.parametrize('suffix', ['.ply', '.npz'])
@pytest.mark.parametrize('grid', [True, False])
def test_view_round_trip(tmp_path, suffix, grid):
    view = some_view('a', grid=grid)
    write_view(tmp_path / f'a{suffix}', view)
    back = read_view(tmp_path / f'a{suffix}')
    np.testing.assert_array_equal(back.points, view.points)
    np.testing.assert_array_equal(back.colors, view.colors)
    if grid:
        np.testing.assert_array_equal(back.grid, view.grid)
    else:
        assert back.grid is None


def test_dataset_round_trip_in_natural_order(tmp_path):
    names = ['view10', 'view2', 'view1.npz']
    poses = {name: some_pose(k) for k, name in enumerate(names)}
    views = [some_view(name, k) for k, name in enumerate(names)]
    write_dataset(tmp_path / 'set', views, poses, units='mm', objects={'view2': 'cup'})
    dataset = read_dataset(tmp_path / 'set')
    assert [p.name for p in dataset.paths] == ['view1.npz', 'view2.ply', 'view10.ply']
    assert (dataset.name, dataset.units, dataset.reference) == ('set', 'mm', 'exact')
    assert dataset.objects == {'view2.ply': 'cup'}
    np.testing.assert_array_equal(dataset.T_world_view['view10.ply'], poses['view10'])
    assert dataset.T_world_view['view10.ply'].dtype == np.float64
    assert {noted.view.units for noted in dataset.read_views()} == {'mm'}


def test_stated_units_win_over_the_extent(tmp_path):
    write_dataset(tmp_path, [some_view('a')], {'a': np.eye(4)}, units='mm')
    noted = read_view_noted(tmp_path / 'views' / 'a.ply')
    assert noted.view.units == 'mm'  # its extent says metres
    assert not any('units' in note for note in noted.notes)
    assert read_view(tmp_path / 'views' / 'a.ply', units='m').units == 'm'


def test_folder_without_poses(tmp_path):
    write_view(tmp_path / 'a.ply', some_view('a'))
    dataset = read_dataset(tmp_path)
    assert (dataset.units, dataset.T_world_view) == ('auto', {})
    assert len(dataset.read_views()) == 1


def poses_file(**changes: object) -> str:
    content = {'units': 'm', 'reference': 'exact', 'T_world_view': {'a.ply': np.eye(4).tolist()}}
    return json.dumps(content | changes)


BAD_POSES = {
    'not json': ('{', 'not a file of reference poses'),
    'list': ('[]', 'not a file of reference poses'),
    'units': (poses_file(units='inch'), 'inch'),
    'no poses': (json.dumps({'units': 'm'}), 'not a file of reference poses'),
    'scaled': (poses_file(T_world_view={'a.ply': (2 * np.eye(4)).tolist()}), 'no rigid'),
    'mirrored': (poses_file(T_world_view={'a.ply': np.diag([1, 1, -1, 1]).tolist()}), 'no rigid'),
    '3x4': (poses_file(T_world_view={'a.ply': np.eye(4)[:3].tolist()}), 'no rigid'),
    'ragged': (poses_file(T_world_view={'a.ply': [[1], [2, 3]]}), 'not a file of reference'),
    'stranger': (poses_file(T_world_view={'b.ply': np.eye(4).tolist()}), "'b.ply', no such view"),
}


@pytest.mark.parametrize('case', BAD_POSES)
def test_bad_poses(tmp_path, case):
    text, words = BAD_POSES[case]
    write_view(tmp_path / 'a.ply', some_view('a'))
    (tmp_path / 'reference_poses.json').write_text(text)
    with pytest.raises(InputError, match=words):
        read_dataset(tmp_path)


def test_writers_refuse(tmp_path):
    view = some_view('a')
    with pytest.raises(ParameterError, match="no pose of 'a'"):
        write_dataset(tmp_path, [view], {}, units='m')
    with pytest.raises(ParameterError, match='plain file name'):
        write_dataset(tmp_path, [some_view('../a')], {'../a': np.eye(4)}, units='m')
    with pytest.raises(ParameterError, match='neither'):
        write_view(tmp_path / 'a.stl', view)
    with pytest.raises(ParameterError, match='neither'):
        write_object(tmp_path / 'a.stl', view.points)
    with pytest.raises(ShapeError, match='view_ids'):
        write_object(tmp_path / 'a.ply', view.points, view_ids=np.zeros(2, np.int32))
    with pytest.raises(ShapeError, match='points'):
        write_object(tmp_path / 'a.ply', np.zeros((3, 2)))
    for suffix in ('.ply', '.npz'):
        with pytest.raises(InputError, match='cannot be written'):
            write_view(tmp_path / 'none' / f'a{suffix}', view)
    (tmp_path / 'file').write_text('')
    with pytest.raises(InputError, match='cannot be made'):
        write_dataset(tmp_path / 'file', [view], {'a': np.eye(4)}, units='m')


def test_object_files(tmp_path):
    view = some_view('a')
    normals = np.random.default_rng(9).normal(size=view.points.shape)
    ids = np.arange(len(normals), dtype=np.int32)
    for suffix in ('.ply', '.npz'):
        write_object(tmp_path / f'o{suffix}', view.points, normals=normals, colors=view.colors,
                     view_ids=ids)
        back = read_view(tmp_path / f'o{suffix}')
        np.testing.assert_array_equal(back.points, view.points)
        np.testing.assert_array_equal(back.colors, view.colors)
    o3d = pytest.importorskip('open3d')
    other = o3d.t.io.read_point_cloud(str(tmp_path / 'o.ply'))
    np.testing.assert_allclose(other.point['normals'].numpy(), normals, atol=1e-6)
    np.testing.assert_array_equal(other.point['view_id'].numpy().ravel(), ids)


def test_conf_convention(tmp_path):
    """The transpose: a quaternion of +90 degrees about z turns the points by -90."""
    half = np.sqrt(0.5)
    (tmp_path / 'a.conf').write_text(f'camera 1 2 3\nbmesh a.ply 1 2 3 0 0 {half} {half}\n')
    T = read_conf(tmp_path / 'a.conf')['a.ply']
    np.testing.assert_allclose(T @ [1, 0, 0, 1], [1, 1, 3, 1], atol=1e-12)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('camera 1 2 3\n', 'no bmesh'),
        ('bmesh a.ply 1 2 3 0 0 1\n', 'seven numbers'),
        ('bmesh a.ply 1 2 3 0 0 0 x\n', 'seven numbers'),
        ('bmesh a.ply 1 2 3 0 0 0 0\n', 'no rigid'),
    ],
)
def test_bad_conf(tmp_path, text, words):
    (tmp_path / 'a.conf').write_text(text)
    with pytest.raises(InputError, match=words):
        read_conf(tmp_path / 'a.conf')


@needs_scans
@pytest.mark.parametrize(
    ('name', 'conf'), [('bunny', 'bun'), ('dragon_stand', 'dragonStandRight')])
def test_conf_agrees_with_reference_poses(name, conf):
    poses = read_conf(DATA / name / f'{conf}.conf')
    reference = read_poses(DATA / name / 'reference_poses.json').T_world_view
    for view, T in reference.items():
        np.testing.assert_allclose(poses[view], T, atol=1e-7)


@needs_scans
@pytest.mark.parametrize(
    ('name', 'count', 'units', 'organized'),
    [('bunny', 10, 'm', True), ('dragon_stand', 15, 'm', True), ('chef', 10, 'mm', False),
     ('parasaurolophus', 10, 'mm', False)],
)
def test_real_sets(name, count, units, organized):
    dataset = read_dataset(DATA / name)
    assert len(dataset.paths) == len(dataset.T_world_view) == count
    for path in dataset.paths[:3]:
        view = read_view(path)  # the units come from the poses beside it
        assert view.name in dataset.T_world_view
        assert view.units == units
        assert 14000 < len(view.points) < 80000
        assert (view.grid is not None) == organized
        if organized:
            assert np.count_nonzero(view.grid >= 0) == len(view.points)


def names_of(sources) -> list[str]:
    outcomes = [o for source in sources for o in source.views()]
    return [o.view.name if isinstance(o, NotedView) else o.name for o in outcomes]


def test_name_that_is_no_text_is_refused_in_a_sentence(tmp_path):
    odd = os.fsdecode(bytes(tmp_path) + b'/v\xff.ply')
    try:
        Path(odd).write_bytes(b'')
    except OSError as error:
        pytest.skip(f'this file system has only names in UTF-8 ({error})')
    with pytest.raises(InputError, match='not UTF-8; rename it'):
        find_views([tmp_path])


def test_find_views(tmp_path):
    write_dataset(tmp_path / 'a', [some_view(n) for n in ('v10', 'v9')],
                  {n: np.eye(4) for n in ('v10', 'v9')}, units='m')
    (tmp_path / 'b').mkdir()
    write_view(tmp_path / 'b' / 'v9.ply', some_view('x'))
    (tmp_path / 'b' / 'notes.md').write_text('not a view')
    write_view(tmp_path / 'single.npz', some_view('x'))
    inputs = [tmp_path / 'single.npz', tmp_path / 'a', tmp_path / 'b', tmp_path / 'a' / 'views']
    sources = find_views(inputs)
    assert [s.count() for s in sources] == [1] * 4
    assert names_of(sources) == ['single.npz', 'a/v9.ply', 'v10.ply', 'b/v9.ply']


def test_equal_names_are_told_apart_by_their_folders(tmp_path):
    for folder in ('p/set', 'q/set', 'q/other'):
        (tmp_path / folder).mkdir(parents=True)
        write_view(tmp_path / folder / 'v.ply', some_view('x'))
    write_view(tmp_path / 'w.ply', some_view('x'))
    folders = [tmp_path / f for f in ('p/set', 'q/set', 'q/other', 'w.ply')]
    assert names_of(find_views(folders)) == ['p/set/v.ply', 'q/set/v.ply', 'other/v.ply', 'w.ply']
    (tmp_path / 'q' / 'views').mkdir()
    twins = [tmp_path / 'q' / 'v.ply', tmp_path / 'q' / 'views' / 'v.ply']
    for twin in twins:
        write_view(twin, some_view('x'))
    assert names_of(find_views(twins)) == [str(twin) for twin in twins]


def test_damaged_view_does_not_end_the_rest(tmp_path):
    write_view(tmp_path / 'v1.ply', some_view('x'))
    (tmp_path / 'v2.ply').write_bytes((tmp_path / 'v1.ply').read_bytes()[:-9])
    (tmp_path / 'v3.xyz').write_bytes(b'')
    write_view(tmp_path / 'v4.npz', some_view('x'))
    outcomes = [o for source in find_views([tmp_path]) for o in source.views()]
    assert [type(o) for o in outcomes] == [NotedView, BadView, BadView, NotedView]
    assert 'v2.ply' in outcomes[1].reason and 'truncated' in outcomes[1].reason
    assert 'v3.xyz' in outcomes[2].reason and 'empty' in outcomes[2].reason


def test_bad_inputs(tmp_path):
    with pytest.raises(InputError, match='no input'):
        find_views([])
    with pytest.raises(InputError, match='nowhere: no such file or folder'):
        find_views([tmp_path / 'nowhere'])
    with pytest.raises(InputError, match='holds no view'):
        find_views([tmp_path])
    (tmp_path / 'a.doc').write_text('')
    with pytest.raises(InputError, match='none of'):
        find_views([tmp_path / 'a.doc'])
    with pytest.raises(InputError, match='holds no view'):
        read_dataset(tmp_path)
    with pytest.raises(InputError, match='cannot be read'):
        read_dataset(tmp_path / 'nowhere')


@pytest.mark.skipif(os.geteuid() == 0, reason='root may read everything')
def test_unreadable_folder(tmp_path):
    (tmp_path / 'locked').mkdir(mode=0)
    with pytest.raises(InputError, match='locked.*cannot be read'):
        find_views([tmp_path / 'locked'])


def test_folder_whose_listing_fails(tmp_path, monkeypatch):
    def refuse(self):
        raise PermissionError(13, 'Permission denied')

    monkeypatch.setattr(Path, 'iterdir', refuse)
    with pytest.raises(InputError, match='cannot be read.*Permission denied'):
        find_views([tmp_path])
    with pytest.raises(InputError, match='cannot be read.*Permission denied'):
        read_dataset(tmp_path)
