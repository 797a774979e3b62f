# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops export`. Truth: the run folder written here, read back by mcap_ros2 and by rosbags."""

import json
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from msg_adapters import point_cloud2
import numpy as np
import pytest
from ros_rops.cli.main import main
from ros_rops.recordings.frames import read_frames
from ros_rops.recordings.ply import parse_vertices
from ros_rops.recordings.synthetic import look_at
from ros_rops.recordings.writers import write_object
from ros_rops.reporting.mesh_files import ply_bytes
from rosbags.highlevel import AnyReader
from scipy.spatial.transform import Rotation

VIEWS = ['/cam/points@1700000000000000000', '/cam/points@1700000003000000000', '/cam/points@5']
POSES = {name: look_at(np.array([0.3 + k, 0.2, 0.1]), np.zeros(3), k)
         for k, name in enumerate(VIEWS[:2])}


def run_folder(folder: Path, units: str = 'm', colors: bool = True) -> np.ndarray:
    folder.mkdir()
    rng = np.random.default_rng(0)
    points = rng.normal(size=(50, 3))
    normals = rng.normal(size=(50, 3))
    write_object(
        folder / 'object_4.ply', points, normals=normals,
        colors=rng.integers(0, 256, (50, 3)).astype(np.uint8) if colors else None,
        view_ids=np.repeat([0, 1], 25).astype(np.int32))
    (folder / 'poses.json').write_text(json.dumps({
        'units': units, 'mesh_resolution': 0.001,
        'objects': [{'id': 4, 'views': [
            {'name': name, 'T_object_view': T.tolist()} for name, T in POSES.items()]}],
        'views': [
            {'name': name, 'status': 'placed' if name in POSES else 'pending',
             'object': 4 if name in POSES else None, 'reason': ''} for name in VIEWS]}))
    return points


def by_mcap(path: Path) -> list:
    with path.open('rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [(c.topic, m.log_time, d) for _, c, m, d in reader.iter_decoded_messages()]


def by_rosbags(path: Path) -> list:
    with AnyReader([path]) as reader:
        return [(c.topic, t, reader.deserialize(d, c.msgtype)) for c, t, d in reader.messages()]


def test_the_cloud_of_a_model_keeps_its_fields(tmp_path):
    points = run_folder(tmp_path / 'run')
    columns = parse_vertices((tmp_path / 'run' / 'object_4.ply').read_bytes())
    columns['weight'] = np.linspace(0, 3, 50).astype(np.float32)
    columns['directions'] = np.arange(50).astype(np.uint8)
    (tmp_path / 'run' / 'object_4.ply').write_bytes(ply_bytes(columns, ()))
    assert main(['export', str(tmp_path / 'run'), '--out', str(tmp_path / 'x.mcap')]) == 0
    cloud, = [m for topic, _, m in by_rosbags(tmp_path / 'x.mcap') if topic == '/object_4/cloud']
    kinds = {field.name: {5: '<i4', 7: '<f4'}[field.datatype] for field in cloud.fields}
    assert list(kinds)[-3:] == ['view_id', 'weight', 'directions']
    rows = np.frombuffer(bytes(cloud.data), np.dtype(list(kinds.items())))
    np.testing.assert_allclose(rows['x'], points[:, 0], rtol=1e-6)
    for name in ('weight', 'directions', 'view_id'):
        np.testing.assert_array_equal(rows[name], columns[name])


@pytest.mark.parametrize('read', [by_mcap, by_rosbags])
@pytest.mark.parametrize('units', ['m', 'mm'])
def test_others_read_the_result(tmp_path, read, units):
    points = run_folder(tmp_path / 'run', units)
    assert main(['export', str(tmp_path / 'run'), '--out', str(tmp_path / 'x.mcap')]) == 0
    found = read(tmp_path / 'x.mcap')
    assert {time for _, time, _ in found} == {1_700_000_003_000_000_000}
    scale = 0.001 if units == 'mm' else 1.0
    message, = [m for topic, _, m in found if topic == '/tf_static']
    for k, item in enumerate(message.transforms):
        assert item.header.frame_id == 'object_4'
        assert item.child_frame_id == f'object_4/view_{k:03d}'
        T = POSES[VIEWS[k]]
        t, q = item.transform.translation, item.transform.rotation
        np.testing.assert_allclose([t.x, t.y, t.z], scale * T[:3, 3], atol=1e-12)
        R = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
        np.testing.assert_allclose(R, T[:3, :3], atol=1e-9)
    cloud, = [m for topic, _, m in found if topic == '/object_4/cloud']
    assert [f.name for f in cloud.fields] == [
        'x', 'y', 'z', 'rgb', 'normal_x', 'normal_y', 'normal_z', 'view_id']
    assert cloud.header.frame_id == 'object_4'
    xyz, rgb = point_cloud2.decode(cloud)
    np.testing.assert_allclose(xyz, scale * points, rtol=1e-6)
    assert rgb.max() > 200
    ids = np.frombuffer(bytes(cloud.data), '<i4').reshape(50, -1)[:, -1]
    np.testing.assert_array_equal(ids, np.repeat([0, 1], 25))
    reports = [json.loads(m.data) for topic, _, m in found if topic == '/view_reports']
    assert [r['name'] for r in reports] == VIEWS
    assert [r['frame_id'] for r in reports] == ['object_4/view_000', 'object_4/view_001', '']


def test_our_own_reader_reads_it(tmp_path):
    points = run_folder(tmp_path / 'run', colors=False)
    assert main(['export', str(tmp_path / 'run'), '--out', str(tmp_path / 'x.mcap')]) == 0
    frame, = read_frames(tmp_path / 'x.mcap')
    np.testing.assert_array_equal(frame.points, points.astype(np.float32))
    assert frame.colors is None


def test_what_cannot_be_exported(tmp_path, capsys):
    run_folder(tmp_path / 'run')
    out = str(tmp_path / 'x.mcap')
    (tmp_path / 'empty').mkdir()
    (tmp_path / 'odd').mkdir()
    (tmp_path / 'odd' / 'poses.json').write_text('{"objects": [{}]}')
    for words, said in (
            ([str(tmp_path / 'none'), '--out', out], 'no such file'),
            ([str(tmp_path / 'empty'), '--out', out], 'no such file'),
            ([str(tmp_path / 'odd'), '--out', out], 'is not the poses.json'),
            ([str(tmp_path / 'run'), '--out', out + '.bag'], 'does not end in .mcap')):
        assert main(['export', *words]) == 2
        assert said in capsys.readouterr().err
    assert main(['export', str(tmp_path / 'run'), '--out', out]) == 0
    assert main(['export', str(tmp_path / 'run'), '--out', out]) == 2
    (tmp_path / 'run' / 'object_4.ply').write_bytes(b'ply\n')
    assert main(['export', str(tmp_path / 'run'), '--out', out, '--force']) == 2
    assert 'object_4.ply' in capsys.readouterr().err
    (tmp_path / 'run' / 'object_4.ply').write_bytes(ply_bytes({'x': np.zeros(3)}, ()))
    assert main(['export', str(tmp_path / 'run'), '--out', out, '--force']) == 2
    assert 'it lacks nx, ny, nz, view_id, y, z' in capsys.readouterr().err
    (tmp_path / 'run' / 'object_4.ply').unlink()
    assert main(['export', str(tmp_path / 'run'), '--out', out, '--force']) == 2
    assert 'object_4.ply: is not there; `rops model' in capsys.readouterr().err
