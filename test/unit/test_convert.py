# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops convert`. Truth: what went in, bit by bit; mcap's own decoder."""

from dataclasses import replace
import io
import json
import os
from pathlib import Path
import shutil

from hypothesis import given, settings, strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
import numpy as np
import pytest
from ros_rops.cli.main import main
from ros_rops.core.errors import InputError
from ros_rops.core.types import RangeView, SensorModel, SupportPlane
from ros_rops.recordings.convert import to_folder, to_recording
from ros_rops.recordings.convert_recording import to_mcap
from ros_rops.recordings.dataset import read_dataset
from ros_rops.recordings.frames import frame_view, read_frames
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.poses import read_poses
from ros_rops.recordings.reader import read_view
from ros_rops.recordings.simulate import pinhole, Sensor, simulate
from ros_rops.recordings.station import Plan
from ros_rops.recordings.synthetic import look_at, Model
from ros_rops.recordings.view_facts import encode_facts, ViewFacts
from ros_rops.recordings.writers import write_dataset, write_view

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))
TETRA = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0], [0, 0, 0.05]])
SIDES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)


def view(name: str, seed: int = 0, **changes) -> RangeView:
    rng = np.random.default_rng(seed)
    points = rng.normal(5.0, 1.0, size=(20, 3))
    grid = np.full((6, 5), -1)
    grid.flat[rng.permutation(30)[:20]] = rng.permutation(20)
    return replace(RangeView(
        name, points, grid, SensorModel('pinhole', (0.1, 0.0, 1 / 3), (0.0, 0.6, 0.8)),
        rng.integers(0, 256, (20, 3)).astype(np.uint8), 'mm', 1_700_000_000_000_000_007 + seed,
        'eye', SupportPlane((0.0, 0.0, 1.0), 0.1)), **changes)


def assert_same(a: RangeView, b: RangeView) -> None:
    for name in ('name', 'sensor', 'units', 'stamp_ns', 'frame_id', 'support'):
        assert getattr(a, name) == getattr(b, name), name
    for name in ('points', 'grid', 'colors'):
        left, right = getattr(a, name), getattr(b, name)
        assert (left is None) == (right is None), name
        if left is not None:
            assert (left.shape, left.tobytes()) == (right.shape, right.tobytes()), name


def views_of(path: Path) -> list[RangeView]:
    return [frame_view(frame).view for frame in read_frames(path)]


@pytest.mark.parametrize('organized', [True, False])
def test_folder_to_recording_and_back(tmp_path, organized):
    # As others make them: nothing but points, grid and colours in the files.
    views = [view(f'scan{k}.ply', k) for k in range(12)]
    if not organized:
        views = [replace(v, grid=None, colors=None) for v in views]
    poses = {v.name: look_at(np.array([1.0, 2, 3 + k]), np.zeros(3), k / 7)
             for k, v in enumerate(views)}
    write_dataset(tmp_path / 'in', views, poses, units='mm', reference='published',
                  objects={v.name: f'cup {k % 2}' for k, v in enumerate(views)})
    to_recording([tmp_path / 'in'], tmp_path / 'x.mcap')
    to_folder(tmp_path / 'x.mcap', tmp_path / 'out')
    before, after = read_dataset(tmp_path / 'in'), read_dataset(tmp_path / 'out')
    assert [p.name for p in before.paths] == [p.name for p in after.paths]
    for one, other in zip(before.paths, after.paths, strict=True):
        assert_same(read_view(one, units='mm'), read_view(other))
    assert (tmp_path / 'in' / 'reference_poses.json').read_bytes() == (
        tmp_path / 'out' / 'reference_poses.json').read_bytes()
    to_recording([tmp_path / 'out'], tmp_path / 'y.mcap')
    assert (tmp_path / 'x.mcap').read_bytes() == (tmp_path / 'y.mcap').read_bytes()


def test_every_kind_of_view_file(tmp_path):
    (tmp_path / 'a.xyz').write_text('1 2 3\n4 5 6\n0.1 0.2 0.3\n')
    write_view(tmp_path / 'b.npz', view('b'))
    (tmp_path / 'c.pcd').write_text(
        'VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n'
        'POINTS 2\nDATA ascii\n1 2 3\nnan 0 0\n')
    (tmp_path / 'd.ply').write_bytes(b'ply\nno\n')
    done = to_recording([tmp_path], tmp_path / 'x.mcap', units='m', sensor='-z')
    assert done.views == 3
    assert 'd.ply' in done.faults[0]
    assert to_folder(tmp_path / 'x.mcap', tmp_path / 'out').views == 3
    for name in ('a.xyz', 'b.npz', 'c.pcd'):
        original = read_view(tmp_path / name, units='m', sensor='-z')
        back = read_view(tmp_path / 'out' / 'views' / f'{name}.ply')
        assert_same(original, replace(back, name=name))
    assert not (tmp_path / 'out' / 'reference_poses.json').exists()


sane = st.floats(-1e15, 1e15, allow_nan=False)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(
    st.text(st.characters(), max_size=10), st.none() | st.integers(-5, 2**62), st.text(max_size=5),
    st.lists(st.tuples(sane, sane, sane), max_size=5), st.booleans()), max_size=4))
def test_recording_to_folder_and_back(tmp_path_factory, rows):
    folder = tmp_path_factory.mktemp('convert')
    views = []
    for number, (name, stamp, frame, points, organized) in enumerate(rows):
        array = np.array(points, float).reshape(-1, 3)
        grid = np.arange(-1, len(array)).reshape(1, -1) if organized else None
        views.append(RangeView(f'{name}{number}', array, grid, stamp_ns=stamp, frame_id=frame))
    with create_mcap(folder / 'x.mcap') as mcap:
        for number, one in enumerate(views):
            mcap.add_view(one, topic='/cam/points', log_time_ns=number)
    if not views:
        with pytest.raises(InputError, match='holds no'):
            to_folder(folder / 'x.mcap', folder / 'out')
        return
    assert to_folder(folder / 'x.mcap', folder / 'out').views == len(views)
    to_recording([folder / 'out'], folder / 'y.mcap')
    again = {v.name: v for v in views_of(folder / 'y.mcap')}
    assert len(again) == len(views)
    for one in views:
        assert_same(one, again[one.name])
    shutil.rmtree(folder)


def test_facts_in_a_ply_are_a_comment_to_others(tmp_path):
    path = tmp_path / 'a.ply'
    one = view('end_header\nply')
    write_view(path, one, facts=ViewFacts(
        '/p', 'view', one.name, 'mm', one.sensor, one.stamp_ns, one.frame_id,
        support=one.support))
    assert_same(replace(one, name='a.ply'), read_view(path))
    assert read_view(path, units='m', sensor='-z').sensor.direction == (0.0, 0.0, -1.0)
    assert read_view(path, units='m').units == 'm'
    head = path.read_bytes().partition(b'\nend_header\n')[0].decode('ascii')
    line, = [line for line in head.splitlines() if line.startswith('comment ros_rops_view')]
    assert json.loads(line.split(' ', 2)[2])['name'] == one.name
    # Somebody's own comment with that word, or a damaged one, is a comment.
    data = path.read_bytes().replace(encode_facts(
        ViewFacts('/p', 'view', 'x'))[:10], b'{"topic"?:')
    path.write_bytes(data)
    assert read_view(path).stamp_ns is None


def test_a_simulated_recording_keeps_its_poses(tmp_path):
    simulate([Model(TETRA, SIDES, name='wedge')], tmp_path / 'x.mcap', Plan(views=3),
             Sensor(pinhole(40, 30, 50.0), 'depth'))
    assert to_folder(tmp_path / 'x.mcap', tmp_path / 'out').views == 3
    truth = read_poses(tmp_path / 'x_poses.json')
    found = read_dataset(tmp_path / 'out')
    assert (found.units, found.reference) == ('m', 'exact')
    assert set(found.objects.values()) == {'wedge'}
    by_stamp = {name.rpartition('@')[2]: T for name, T in truth.T_world_view.items()}
    for path in found.paths:
        np.testing.assert_array_equal(
            found.T_world_view[path.name], by_stamp[str(read_view(path).stamp_ns)])


def test_other_recordings_to_mcap(tmp_path):
    source = tmp_path / 'x.mcap'
    simulate([Model(TETRA, SIDES, name='wedge')], source, Plan(views=2),
             Sensor(pinhole(20, 16, 50.0), 'depth'))

    def raw(path: Path) -> list:
        with path.open('rb') as stream:
            return [(s.name, s.data, c.topic, m.log_time, m.data)
                    for s, c, m in make_reader(stream).iter_messages()]

    assert to_mcap(source, tmp_path / 'y.mcap') == len(raw(source)) == 7
    assert raw(tmp_path / 'y.mcap') == raw(source)
    assert to_mcap(source, tmp_path / 'y.mcap', topics=['/tf']) == 2
    with pytest.raises(InputError, match="no topic '/cup'"):
        to_mcap(source, tmp_path / 'z.mcap', topics=['/cup'])
    source.write_bytes(source.read_bytes()[:-400])
    data = io.BytesIO()
    writer = Writer(data)
    writer.start()
    schema = writer.register_schema('a/B', 'protobuf', b'')
    writer.add_message(writer.register_channel('/b', 'protobuf', schema), 1, b'x', 1)
    writer.finish()
    (tmp_path / 'p.mcap').write_bytes(data.getvalue())
    with pytest.raises(InputError, match='cannot be converted'):
        to_mcap(tmp_path / 'p.mcap', tmp_path / 'z.mcap')
    assert not (tmp_path / 'z.mcap').exists()


OUSTER = DATA.parent / 'recordings' / 'ouster_ros1_profile.mcap'


@pytest.mark.skipif(not OUSTER.is_file(), reason=f'no recording at {OUSTER}')
def test_ros1_becomes_ros2(tmp_path):
    to_mcap(OUSTER, tmp_path / 'x.mcap', topics=['/os1_cloud_node/points', '/tf_static'])
    with (tmp_path / 'x.mcap').open('rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        kinds = {c.topic: d for _, c, _, d in reader.iter_decoded_messages()}
    assert kinds['/tf_static'].transforms[0].child_frame_id == 'os1_imu'
    for one, other in zip(read_frames(OUSTER), read_frames(tmp_path / 'x.mcap'), strict=True):
        np.testing.assert_array_equal(one.points, other.points)
        assert (one.name, one.stamp_ns, one.frame_id) == (
            other.name, other.stamp_ns, other.frame_id)


@pytest.mark.skipif(not (DATA / 'bunny').is_dir(), reason=f'no scans at {DATA}')
@pytest.mark.parametrize('name', ['bunny', 'chef'])
def test_real_scans(tmp_path, name):
    few = tmp_path / name
    (few / 'views').mkdir(parents=True)
    paths = read_dataset(DATA / name).paths[:2]
    for path in paths:
        shutil.copy(path, few / 'views')
    given = json.loads((DATA / name / 'reference_poses.json').read_text())
    given['T_world_view'] = {p.name: given['T_world_view'][p.name] for p in paths}
    (few / 'reference_poses.json').write_text(json.dumps(given))
    to_recording([few], tmp_path / 'x.mcap')
    to_folder(tmp_path / 'x.mcap', tmp_path / 'out')
    units = read_dataset(few).units
    back = read_dataset(tmp_path / 'out')
    for path, copy in zip(paths, back.paths, strict=True):
        assert copy.name == (path.name if path.suffix == '.ply' else f'{path.name}.ply')
        one = read_view(few / 'views' / path.name, units=units)
        assert_same(one, replace(read_view(copy), name=path.name))
        np.testing.assert_array_equal(
            back.T_world_view[copy.name], given['T_world_view'][path.name])


def test_the_command(tmp_path, capsys):
    write_view(tmp_path / 'a.ply', view('a'))
    bag, out = str(tmp_path / 'x.mcap'), str(tmp_path / 'out')
    assert main(['convert', str(tmp_path / 'a.ply'), '--out', bag]) == 0
    assert main(['convert', bag, '--out', out]) == 0
    assert main(['convert', bag, '--out', str(tmp_path / 'copy.mcap')]) == 0
    assert '2 messages' in capsys.readouterr().out
    for words, said in (
            ([str(tmp_path / 'a.ply'), '--out', bag], 'exists already'),
            ([bag, '--out', out], 'exists already'),
            ([bag, '--out', bag], 'exists already'),
            ([str(tmp_path / 'a.ply'), '--out', out + '2'], 'does not end in .mcap'),
            ([bag, str(tmp_path / 'copy.mcap'), '--out', out + '2'], 'one recording at a time'),
            ([bag, '--out', out + '.mcap', '--units', 'm'], 'copied as it is'),
            (['none', '--out', bag], 'no such file'),
            ([bag, '--out', str(tmp_path / 'a.ply')], 'cannot be made'),
            ([str(tmp_path / 'a.ply'), '--out', str(tmp_path / 'no' / 'x.mcap')],
             'cannot be written')):
        assert main(['convert', *words]) == 2, words
        error = capsys.readouterr().err.strip()
        assert said in error
        assert len(error.splitlines()) == 1
    assert main(['convert', bag, '--out', out, '--force']) == 0
    (tmp_path / 'bad.ply').write_bytes(b'ply\n')
    assert main(['convert', str(tmp_path / 'bad.ply'), '--out', bag, '--force']) == 1
