# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops simulate`. Truth: analytic spheres and planes, the poses asked for, byte comparison."""

from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
import pytest
from ros_rops.cli.main import main
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.recordings.depth_noise import DepthNoise, disturb, PRESETS
from ros_rops.recordings.poses import read_poses
from ros_rops.recordings.procedural import mesh_of
from ros_rops.recordings.scene import look, Placed
from ros_rops.recordings.simulate import FRAME, pinhole, Sensor, simulate
from ros_rops.recordings.simulate_models import read_models, UPS
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.station import about_z, place, Plan, shots
from ros_rops.recordings.stl import parse_mesh
from ros_rops.recordings.synthetic import look_at, Model
from scipy.spatial.transform import Rotation

CAMERA = pinhole(96, 72, 50.0)
TETRA = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0], [0, 0, 0.05]])
SIDES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)


@pytest.fixture(scope='module')
def ball() -> Model:
    return Model(*mesh_of(lambda p: np.linalg.norm(p, axis=-1) - 0.08, cell=0.004), name='ball')


@pytest.fixture
def tetra(tmp_path) -> str:
    path = tmp_path / 'tetra.obj'
    path.write_text(''.join(
        [f'v {x} {y} {z}\n' for x, y, z in TETRA]
        + [f'f {a + 1} {b + 1} {c + 1}\n' for a, b, c in SIDES]))
    return str(path)


def messages(path: Path) -> list:
    with path.open('rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [(c.topic, m.log_time, d) for _, c, m, d in reader.iter_decoded_messages()]


def matrix(transform) -> np.ndarray:
    t, q = transform.transform.translation, transform.transform.rotation
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
    T[:3, 3] = t.x, t.y, t.z
    return T


def test_table_and_ball_have_their_analytic_depth(ball):
    eye = np.array([0.5, 0.1, 0.4])
    T = look_at(eye, np.array([0, 0, 0.05]), 0.3)
    up = np.eye(4)
    up[2, 3] = 0.08
    depth = look([Placed(ball, up)], np.linalg.inv(T), CAMERA, table_radius=0.3).depth
    rays = CAMERA.rays() @ T[:3, :3].T
    with np.errstate(divide='ignore'):
        table = -eye[2] / rays[..., 2]
    hit = eye + table[..., None] * rays
    table[(np.hypot(hit[..., 0], hit[..., 1]) > 0.3) | (table < 0)] = np.nan
    to = np.array([0, 0, 0.08]) - eye
    a, b = (rays**2).sum(-1), rays @ to
    root = b**2 - a * (to @ to - 0.08**2)
    sphere = np.where(root > 0, (b - np.sqrt(np.maximum(root, 0))) / a, np.nan)
    most = a * 0.08**2  # of a ray through the middle
    inside = root > 0.1 * most  # away from the outline, which the facets cut
    truth = np.where(inside, sphere, table)
    ring = (root > -0.1 * most) & ~inside
    np.testing.assert_allclose(depth[~ring & ~inside], truth[~ring & ~inside], rtol=1e-9)
    np.testing.assert_allclose(depth[inside], truth[inside], atol=3e-4)
    assert inside.sum() > 500
    assert np.isfinite(table[~ring]).sum() > 1000
    assert np.isnan(truth[~ring]).sum() > 50


@pytest.mark.parametrize('name', ['d435', 'kinect', 'structured-light'])
def test_noise_grows_with_the_square_of_depth(name):
    rng = np.random.default_rng(5)
    spread = []
    for depth in (0.4, 0.8):
        flat = np.full((200, 200), depth)
        noisy = disturb(flat, np.ones(flat.shape), PRESETS[name], rng)[1:-1, 1:-1]
        missing = np.isnan(noisy).mean()
        assert 0.5 < missing / PRESETS[name].lost < 1.5
        error = noisy - depth
        step = PRESETS[name].disparity * depth**2
        spread.append(np.nanstd(error) / depth**2)
        expected = np.hypot(PRESETS[name].axial, step / np.sqrt(12) / depth**2)
        assert spread[-1] == pytest.approx(expected, rel=0.15)
        assert abs(np.nanmean(error)) < 0.05 * step + 1e-4 * depth**2
    assert spread[0] == pytest.approx(spread[1], rel=0.15)


def test_disparity_is_in_steps_and_flying_pixels_lie_between():
    depth = np.where(np.arange(80) < 40, 0.5, 1.0) * np.ones((60, 1))
    still = DepthNoise(0.0, 0.0, 89.0, 0.02, 0.0, 0.002, 0.0)
    rng = np.random.default_rng(1)
    found = disturb(depth, np.ones(depth.shape), still, rng)[1:-1, 1:-1]
    counts = 1 / (found[np.isfinite(found)] * 0.002)
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)
    flying = DepthNoise(0.0, 0.0, 89.0, 0.02, 0.0, 0.0, 1.0)
    found = disturb(depth, np.ones(depth.shape), flying, rng)[1:-1, 1:-1]
    between = (found > 0.5001) & (found < 0.9999)
    assert set(np.nonzero(between)[1]) == {38}  # the last column of the near side
    assert 10 < between.sum() < 50


def test_placed_objects_stand_on_the_table_apart():
    models = [Model(TETRA * s, SIDES, name=str(s)) for s in (1.0, 0.6, 0.8)]
    for together in (True, False):
        placed = place(models, together=together, rng=np.random.default_rng(3))
        feet, rings = [], []
        for one in placed:
            T = one.T_turntable_object
            points = one.model.vertices @ T[:3, :3].T + T[:3, 3]
            feet.append(points[:, 2].min())
            rings.append(points[:, :2])
        np.testing.assert_allclose(feet, 0, atol=1e-12)
        if together:
            gaps = [np.linalg.norm(a.mean(0) - b.mean(0)) for a in rings for b in rings
                    if a is not b]
            assert min(gaps) > 0.2


def test_turntable_turns_and_the_camera_stays():
    placed = [Placed(Model(TETRA, SIDES), np.eye(4))]
    plan = Plan(views=4, mixed=False, still=2, moving=1, rate_hz=10.0)
    found = shots(placed, plan, np.random.default_rng(0), above=True)
    assert len(found) == plan.frames(1) == 11
    assert [s.stop for s in found] == [0, 0, None, 1, 1, None, 2, 2, None, 3, 3]
    turns = [0, 0, 45, 90, 90, 135, 180, 180, 225, 270, 270]
    for shot, turn in zip(found, turns, strict=True):
        np.testing.assert_allclose(shot.T_world_turntable, about_z(np.deg2rad(turn)), atol=1e-12)
        np.testing.assert_allclose(shot.T_world_camera, found[0].T_world_camera, atol=1e-12)
    assert np.diff([s.stamp_ns for s in found]).tolist() == [100_000_000] * 10
    assert found[0].T_world_camera[2, 3] > 0
    assert found[0].T_world_camera[2, 1] < 0  # the image's y axis points down


@pytest.mark.parametrize('plan', [Plan(views=5), Plan(capture='hand-held', views=5)])
@pytest.mark.parametrize('output', ['points', 'depth', 'depth-float'])
def test_transforms_and_sidecar_tell_the_exact_poses(tmp_path, ball, plan, output):
    models = [ball, Model(ball.vertices * 0.7, ball.faces, name='small')]
    sensor = Sensor(CAMERA, output, None, None)
    assert simulate(models, tmp_path / 'x.mcap', plan, sensor, seed=3) == 10
    truth = read_poses(tmp_path / 'x_poses.json')
    found = messages(tmp_path / 'x.mcap')
    fixed = {t.child_frame_id: matrix(t) for topic, _, d in found if topic == '/tf_static'
             for t in d.transforms}
    moving = {time: {t.child_frame_id: matrix(t) for t in d.transforms}
              for topic, time, d in found if topic == '/tf'}
    frames = [(topic, time, d) for topic, time, d in found if topic == sensor.topic]
    assert len(frames) == len(truth.T_world_view) == 10
    for topic, time, data in frames:
        name = f'{topic}@{time}'
        chain = np.linalg.inv(moving[time]['turntable'] @ fixed[truth.objects[name]])
        np.testing.assert_allclose(
            chain @ moving[time][FRAME], truth.T_world_view[name], atol=1e-9)
        depth = depths(data, output)
        rays = CAMERA.rays()
        T = truth.T_world_view[name]
        points = (depth[..., None] * rays)[depth > 0] @ T[:3, :3].T + T[:3, 3]
        radius = 0.08 if truth.objects[name] == 'ball' else 0.056
        slack = 1.2e-3 if output == 'depth' else 1e-4
        assert np.abs(np.linalg.norm(points, axis=1) - radius).max() < slack
        assert len(points) > 100


def depths(message, output: str) -> np.ndarray:
    if output == 'points':
        step = message.point_step // 4
        return np.frombuffer(message.data, '<f4').reshape(72, 96, step)[..., 2].astype(float)
    if output == 'depth':
        return np.frombuffer(message.data, '<u2').reshape(72, 96) / 1000.0
    return np.frombuffer(message.data, '<f4').reshape(72, 96).astype(float)


def test_the_same_command_gives_the_same_bytes(tmp_path, tetra):
    words = ['simulate', tetra, '--views', '3', '--image', '64x48', '--table',
             '--color', '--seed', '5', '--together', '--as', 'depth']
    for name in ('a', 'b'):
        (tmp_path / name).mkdir()
        assert main([*words, '--out', str(tmp_path / name / 'x.mcap')]) == 0
    for name in ('x.mcap', 'x_poses.json'):
        assert (tmp_path / 'a' / name).read_bytes() == (tmp_path / 'b' / name).read_bytes()
    assert main([*words[:-1], 'points', '--seed', '6', '--out', str(tmp_path / 'y.mcap')]) == 0
    other = read_poses(tmp_path / 'y_poses.json').T_world_view
    assert len(other) == 3
    source, = find_views([tmp_path / 'y.mcap'])
    view = next(iter(source.views())).view
    assert view.grid.shape == (48, 64)
    assert view.colors.max() > 60  # the object's paint, beside the table's


@pytest.mark.parametrize('up', UPS)
def test_up_axis_size_and_units(tetra, up):
    model, = read_models([tetra], up=up, size=0.4)
    assert np.ptp(model.vertices, axis=0).max() == pytest.approx(0.4)
    axis = 'xyz'.index(up[-1])
    heights = (TETRA[:, axis] if len(up) == 1 else -TETRA[:, axis]) * 2
    np.testing.assert_allclose(model.vertices[:, 2], heights, atol=1e-12)
    edges = np.linalg.norm(np.diff(model.vertices, axis=0), axis=1)
    np.testing.assert_allclose(edges, 2 * np.linalg.norm(np.diff(TETRA, axis=0), axis=1))
    a, b, c = (model.vertices[model.faces[:, k]] for k in range(3))
    assert np.einsum('ij,ij->i', a, np.cross(b, c)).sum() > 0  # still outward
    small, = read_models([tetra], units='mm')
    np.testing.assert_allclose(np.ptp(small.vertices, axis=0), [2e-4, 1e-4, 5e-5])


def stl_bytes(binary: bool) -> bytes:
    corners = TETRA[SIDES].astype('<f4')
    if not binary:
        facets = ''.join(
            'facet normal 0 0 0\nouter loop\n' + ''.join(
                f'vertex {x} {y} {z}\n' for x, y, z in one) + 'endloop\nendfacet\n'
            for one in corners)
        return f'solid t\n{facets}endsolid t\n'.encode()
    record = np.zeros(4, np.dtype([('n', '<f4', 3), ('c', '<f4', (3, 3)), ('a', '<u2')]))
    record['c'] = corners
    return b'solid though binary'.ljust(80) + (4).to_bytes(4, 'little') + record.tobytes()


@pytest.mark.parametrize('binary', [True, False])
def test_stl(binary, tmp_path):
    data = stl_bytes(binary)
    points, faces = parse_mesh(data)
    assert points.shape == (4, 3)
    np.testing.assert_array_equal(points[faces], TETRA[SIDES].astype(np.float32))
    (tmp_path / 't.stl').write_bytes(data)
    assert read_models([str(tmp_path / 't.stl')])[0].name == 't'
    for bad in (data[:-20], data[:70], b'solid\n', b'\0' * 84, b'x'):
        (tmp_path / 't.stl').write_bytes(bad)
        with pytest.raises(InputError, match=r't\.stl'):
            read_models([str(tmp_path / 't.stl')])


@pytest.mark.parametrize(('options', 'words'), [
    (['--views', '0'], 'views'), (['--image', '640'], '--image'), (['--image', '0x9'], 'image'),
    (['--fov', '190'], 'fov'), (['--elevation', '90'], 'elevation'), (['--up', 'w'], 'up'),
    (['--moving', '2'], 'moving'), (['--rate', '0'], 'rate'), (['--size', '-1'], 'size'),
    (['--distance', 'nan'], 'distance'), (['--seed', '-1'], 'seed'), (['--table', '-2'], 'table'),
    (['--still', '0'], 'still'), (['--step', 'inf'], 'step'), (['--size', 'nan'], 'size')])
def test_nonsense_is_refused(tmp_path, tetra, capsys, options, words):
    out = tmp_path / 'x.mcap'
    assert main(['simulate', tetra, '--out', str(out), '--image', '32x24', *options]) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith('rops simulate: ')
    assert words in error
    assert len(error.splitlines()) == 1
    assert not out.exists()
    assert not list(tmp_path.glob('*.part'))


def test_bad_files_are_refused(tmp_path, tetra, capsys):
    empty = tmp_path / 'empty.ply'
    empty.write_text('ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n'
                     'property float y\nproperty float z\nelement face 0\n'
                     'property list uchar int vertex_indices\nend_header\n')
    (tmp_path / 'flat.obj').write_text('v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n')
    for mesh, out, words in (
            ('none.ply', 'x.mcap', 'no such file'), ('procedural:cup', 'x.mcap', 'blob'),
            (str(empty), 'x.mcap', 'holds no triangle'),
            (str(tmp_path / 'flat.obj'), 'x.mcap', 'without an extent'),
            (tetra, 'x.bag', 'does not end in .mcap'), (tetra, 'no/x.mcap', 'cannot be written')):
        assert main(['simulate', mesh, '--out', str(tmp_path / out), '--views', '1',
                     '--image', '32x24']) == 2
        assert words in capsys.readouterr().err
    words = ['simulate', tetra, '--out', str(tmp_path / 'x.mcap'), '--views', '1', '--image',
             '32x24']
    assert main(words) == 0
    assert main(words) == 2
    assert 'exists already' in capsys.readouterr().err.splitlines()[-1]
    assert main([*words, '--force']) == 0


def test_the_plan_names_what_is_wrong():
    with pytest.raises(ParameterError, match='order of time'):
        Plan(moving=1)
