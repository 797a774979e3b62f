# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Lines of sight: against the twin in NumPy, and against surfaces known in closed form."""

import numpy as np
import pytest
from reference import sight_twin
from reference.bumpy import rigid
from reference.surfaces import bumps, DOWN, height_view
from ros_rops.core.config import MeshConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.mesh import build_mesh
from ros_rops.core.types import SensorModel
from ros_rops.kernels.sight import Sight
from scipy.spatial.transform import Rotation

POSE = rigid(Rotation.from_euler('xyz', [0.4, -1.1, 2.0]), [3.0, -70.0, 11.0])
PINHOLE = SensorModel('pinhole', origin=(8.0, 12.0, 40.0), direction=(0.0, 0.0, -1.0))
UNKNOWN = SensorModel('unknown', direction=(0.0, 0.0, -1.0))


def _made(sensor, shape=(22, 26), beyond=None):
    mesh = build_mesh(height_view(bumps, shape, jitter=0.2), MeshConfig())
    weights = np.linspace(0.1, 1, len(mesh.vertices)).astype(np.float32)
    # A hole, for rays to find nothing in.
    faces = mesh.faces[np.linalg.norm(
        mesh.vertices[mesh.faces[:, 0], :2] - [9, 9], axis=1) > 2.5]
    sight = Sight.of(
        mesh.vertices, faces, weights, sensor, T_object_view=POSE, beyond=beyond)
    return sight, mesh, faces, weights


def _somewhere(count=400, seed=2):
    rng = np.random.default_rng(seed)
    return rng.uniform([-3, -3, -14], [29, 25, 18], (count, 3)) @ POSE[:3, :3].T + POSE[:3, 3]


def _moved(points):
    return np.asarray(points, np.float64) @ POSE[:3, :3].T + POSE[:3, 3]


@pytest.mark.parametrize('sensor', [DOWN, PINHOLE], ids=lambda s: s.kind)
def test_every_ray_as_the_twin_finds_it(sensor):
    sight, mesh, faces, weights = _made(sensor)
    found = sight.look(_somewhere(), reach=0.0)
    expected = sight_twin.look(_somewhere(), mesh.vertices, faces, weights, sensor, POSE)
    assert 0.1 < np.isnan(expected[0]).mean() < 0.9
    np.testing.assert_allclose(found, expected, atol=2e-5)
    # Through a vertex the ray meets several triangles, all at one distance.
    seen = np.unique(faces)
    through = sight.look(_moved(mesh.vertices[seen]), reach=0.0)
    np.testing.assert_allclose(through.distance, 0.0, atol=1e-6)
    np.testing.assert_allclose(through.weight, weights[seen], atol=1e-6)


@pytest.mark.parametrize('sensor', [DOWN, PINHOLE, UNKNOWN], ids=lambda s: s.kind)
def test_same_bytes_whatever_the_threads(sensor):
    points = _somewhere(5000)
    answers = [_made(sensor)[0].look(points, reach=4.0, threads=n) for n in (1, 2, 5)]
    for one in answers[1:]:
        assert all(a.tobytes() == b.tobytes() for a, b in zip(answers[0], one, strict=True))


def test_a_plane_from_an_unknown_sensor():
    """Truth: analytic. Height above the plane, on both sides; nothing beside it or too far."""
    mesh = build_mesh(height_view(lambda x, y: 0 * x, (10, 10)), MeshConfig())
    weights = np.ones(100, np.float32)
    sight = Sight.of(mesh.vertices, mesh.faces, weights, UNKNOWN, T_object_view=POSE)
    points = [[4.3, 4.1, 1.5], [4.3, 4.1, -1.5], [4.3, 4.1, 3.5], [12.0, 4.0, 0.0],
              [9.5, 4.0, 1.0], [0.0, 0.0, 2.0]]
    look = sight.look(_moved(points), reach=3.0)
    np.testing.assert_allclose(
        look.distance, [1.5, -1.5, np.nan, np.nan, np.nan, 2.0], atol=1e-6)
    assert look.weight[:2] == pytest.approx(1.0)


def test_distance_from_an_unknown_sensor_is_that_to_the_nearest_triangle():
    """Truth: the nearest of very many samples of the surface; the sign by its height."""
    sight, mesh, faces, _ = _made(UNKNOWN)
    parts = np.random.default_rng(0).dirichlet([1, 1, 1], 400)
    samples = np.einsum('sk,fkx->fsx', parts, mesh.vertices[faces]).reshape(-1, 3)
    points = _somewhere(150)
    local = (points - POSE[:3, 3]) @ POSE[:3, :3]
    nearest = np.array([np.linalg.norm(samples - p, axis=1).min() for p in local])
    found = sight.look(points, reach=6.0).distance
    known = np.isfinite(found)
    assert known.sum() > 40
    np.testing.assert_allclose(np.abs(found[known]), nearest[known], atol=0.05)
    assert not known[nearest > 6.1].any()
    above = local[:, 2] - bumps(local[:, 0], local[:, 1])
    clear = known & (np.abs(above) > 0.5)
    assert np.array_equal(found[clear] > 0, above[clear] > 0)


def test_rays_that_pass_by():
    """Truth: analytic. A table below and beside the surface; empty down to it, unknown under."""
    x, y = np.mgrid[-30:60, -30:60] + 0.5
    table = np.stack([x, y, np.full_like(x, -20.0)], axis=-1).reshape(-1, 3)
    sight, *_ = _made(DOWN, beyond=table.astype(np.float32))
    points = [[-15, 5, 0], [-15, 5, -19], [-15, 5, -21], [45, 45, 3], [12, 18, 30], [90, 0, 0]]
    distance = sight.look(_moved(points), reach=0.0).distance
    assert np.array_equal(np.isposinf(distance), [True, True, False, True, False, False])
    assert np.isnan(distance[[2, 5]]).all() and np.isfinite(distance[4])


def test_nothing_beside_the_surface_without_rays_that_pass_by():
    sight, *_ = _made(DOWN)
    distance = sight.look(_moved([[-15, 5, 0], [9.2, 9.2, 3.0]]), reach=5.0).distance
    assert np.isnan(distance).all()


@pytest.mark.parametrize('sensor', [DOWN, PINHOLE, UNKNOWN], ids=lambda s: s.kind)
def test_a_stray_triangle_far_away_costs_no_memory_and_changes_nothing(sensor):
    sight, mesh, faces, weights = _made(sensor)
    far = np.array([[1e6, 1e6, -9e5], [1e6, 1.1e6, -9e5], [1.1e6, 1e6, -9e5]])
    strayed = Sight.of(
        np.vstack([mesh.vertices, far]), np.vstack([faces, np.arange(3, dtype=np.int32) + len(
            mesh.vertices)]), np.append(weights, np.ones(3, np.float32)), sensor,
        T_object_view=POSE)
    points = _somewhere(2000)
    expected, found = sight.look(points, reach=4.0), strayed.look(points, reach=4.0)
    # A pinhole's axis, the mean of its rays, turned a little: its last digits differ.
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_a_view_without_faces_says_nothing():
    for sensor in (DOWN, PINHOLE, UNKNOWN):
        sight = Sight.of(
            np.zeros((4, 3)), np.zeros((0, 3), np.int32), np.ones(4, np.float32), sensor)
        assert np.isnan(sight.look(np.ones((3, 3)), reach=2.0).distance).all()
        assert sight.look(np.zeros((0, 3)), reach=2.0).distance.shape == (0,)


def test_mistakes_are_named():
    mesh = build_mesh(height_view(bumps, (8, 8)), MeshConfig())
    weights = np.ones(64, np.float32)
    sight = Sight.of(mesh.vertices, mesh.faces, weights, DOWN)
    with pytest.raises(ShapeError, match='vertices'):
        Sight.of(mesh.vertices[:, :2], mesh.faces, weights, DOWN)
    with pytest.raises(ShapeError, match='faces'):
        Sight.of(mesh.vertices, mesh.faces[:, :2], weights, DOWN)
    with pytest.raises(ShapeError, match='64 vertices'):
        Sight.of(mesh.vertices, mesh.faces + 60, weights, DOWN)
    with pytest.raises(ShapeError, match='weights'):
        Sight.of(mesh.vertices, mesh.faces, weights[1:], DOWN)
    with pytest.raises(ShapeError, match='beyond'):
        Sight.of(mesh.vertices, mesh.faces, weights, DOWN, beyond=np.zeros(3, np.float32))
    with pytest.raises(ShapeError, match='T_object_view'):
        Sight.of(mesh.vertices, mesh.faces, weights, DOWN, T_object_view=2 * np.eye(4))
    with pytest.raises(ShapeError, match='points'):
        sight.look(mesh.vertices[0], reach=1.0)
    with pytest.raises(ShapeError, match='reach'):
        sight.look(mesh.vertices, reach=float('nan'))
