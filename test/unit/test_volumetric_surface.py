# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces from signed distances, of a ball seen from six sides: truth is its radius."""

from dataclasses import replace

import numpy as np
import pytest
from reference.bumpy import rigid
from ros_rops.core.config import Config, ModelConfig
from ros_rops.core.errors import ModelError
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.modelling.posed import pose_views, resolution_of
from ros_rops.modelling.topology import face_vectors
from ros_rops.modelling.volume import volumetric_surface
from scipy.spatial.transform import Rotation

RADIUS, STEP, AWAY = 12.0, 0.5, 60.0
SIDES = [Rotation.from_euler('xyz', angles, degrees=True) for angles in (
    (0, 0, 0), (90, 0, 0), (180, 0, 0), (270, 0, 0), (0, 90, 0), (0, 270, 0))]


def _seen(kind, noise=0.0, seed=0, radius=RADIUS):
    """One side of the ball, from below, in the sensor's frame at the ball's centre."""
    ticks = np.arange(-radius, radius + STEP, STEP)
    x, y = np.meshgrid(ticks, ticks)
    if kind == 'pinhole':
        rays = np.stack([x / AWAY, y / AWAY, np.ones_like(x)], axis=-1)
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        b = AWAY * rays[..., 2]
        root = b**2 - AWAY**2 + radius**2
        points = rays * (b - np.sqrt(np.maximum(root, 0)))[..., None] - [0, 0, AWAY]
    else:
        root = radius**2 - x**2 - y**2
        points = np.stack([x, y, -np.sqrt(np.maximum(root, 0))], axis=-1)
    hit = root > 0
    grid = np.full(hit.shape, -1, np.int32)
    grid[hit] = np.arange(hit.sum())
    points = points[hit]
    points[:, 2] += np.random.default_rng(seed).normal(0, noise, len(points))
    sensor = SensorModel(kind, (0.0, 0.0, -AWAY) if kind == 'pinhole' else (0.0, 0.0, 0.0))
    colors = np.broadcast_to(np.uint8([200, 40, 7]), points.shape)
    return RangeView(f'{kind}{seed}', points, grid, sensor, colors)


def _posed(kind, sides=SIDES, noise=0.0, shift=(0.0, 0.0, 0.0)):
    views = {f'{n}': replace(_seen(kind, noise, n), name=f'{n}') for n in range(len(sides))}
    poses = [(f'{n}', rigid(side, shift)) for n, side in enumerate(sides)]
    return pose_views(poses, views, {name: int(name) for name in views}, Config())


def _surface(posed, config=ModelConfig(), **more):  # noqa: B008 (frozen)
    return volumetric_surface(posed, config, resolution=resolution_of(posed), **more)


@pytest.mark.parametrize('kind', ['orthographic', 'pinhole', 'unknown'])
def test_a_ball_from_all_sides_is_closed_and_round(kind):
    surface = _surface(_posed(kind, shift=(40.0, -7.0, 3.0)))
    away = surface.vertices - [40.0, -7.0, 3.0]
    gaps = np.linalg.norm(away, axis=1) - RADIUS
    assert np.quantile(np.abs(gaps), 0.9) < 0.06 and np.abs(gaps).max() < 0.3
    assert surface.facts['closed'] and surface.facts['manifold'] and surface.facts['oriented']
    assert surface.facts['components'] == 1
    assert surface.facts['volume'] == pytest.approx(4 / 3 * np.pi * RADIUS**3, rel=0.02)
    assert (np.einsum('ij,ij->i', surface.normals, away) > 0.95 * RADIUS).all()
    assert np.array_equal(np.unique(surface.colors, axis=0), [[200, 40, 7]])


def test_the_sides_of_a_thin_wall_do_not_push_each_other_out():
    """Truth: analytic. A wall of 2.2 mr, seen from both sides."""
    x, y = np.meshgrid(np.arange(-10.0, 11.0), np.arange(-10.0, 11.0))
    points = np.stack([x, y, np.full_like(x, -1.1)], axis=-1).reshape(-1, 3)
    grid = np.arange(len(points), dtype=np.int32).reshape(x.shape)
    views = {
        name: RangeView(name, points, grid, SensorModel('orthographic')) for name in ('0', '1')}
    posed = pose_views(
        [('0', np.eye(4)), ('1', rigid(SIDES[2], (0, 0, 0)))], views, {'0': 0, '1': 1}, Config())
    surface = volumetric_surface(posed, ModelConfig(), resolution=1.0)
    gaps = np.abs(np.abs(surface.vertices[:, 2]) - 1.1)
    assert surface.facts['components'] == 2 and gaps.max() < 0.05


def test_noise_is_averaged():
    """Truth: 90 % of single measurements lie within 1.64 sigma; six views must do better."""
    surface = _surface(_posed('orthographic', noise=0.1))
    gaps = np.linalg.norm(surface.vertices, axis=1) - RADIUS
    assert np.quantile(np.abs(gaps), 0.9) < 1.64 * 0.1
    assert 0.05 < surface.facts['spread'] < 0.2


def test_one_view_is_open_and_faces_its_sensor():
    posed = _posed('pinhole', SIDES[:1])
    surface = _surface(posed)
    assert not surface.facts['closed'] and surface.facts['components'] == 1
    mesh = posed[0].mesh
    seen = np.linalg.norm(face_vectors(mesh.vertices, mesh.faces), axis=1).sum() / 2
    assert surface.facts['area'] == pytest.approx(seen, rel=0.1)
    assert (surface.normals[:, 2] < 0.1).all() and surface.vertices[:, 2].max() < 0.0
    assert surface.facts['spread'] == 0.0


def test_a_stray_surface_that_others_see_through_goes():
    """A wrong view has a flake far in front of the ball; another looks through it at the ball."""
    posed = _posed('orthographic')
    x, y = np.meshgrid(np.arange(-3, 3.1, STEP), np.arange(-3, 3.1, STEP))
    flake = np.stack([x, y, np.full_like(x, -RADIUS - 4)], axis=-1).reshape(-1, 3)
    grid = np.arange(len(flake), dtype=np.int32).reshape(x.shape)
    wrong = RangeView('wrong', flake, grid, SensorModel('orthographic'))
    strayed = (*posed, *pose_views([('wrong', np.eye(4))], {'wrong': wrong}, {'wrong': 9},
                                   Config()))
    assert np.linalg.norm(_surface(strayed[1:]).vertices, axis=1).max() > RADIUS + 3
    surface = _surface(strayed)
    assert np.linalg.norm(surface.vertices, axis=1).max() < RADIUS + 0.5
    assert surface.facts['components'] == 1


def test_memory_is_said_before_and_kept_within():
    said = []
    posed = _posed('pinhole')
    resolution = resolution_of(posed)
    fine = _surface(posed, ModelConfig(voxel_mr=0.32), say=said.append)
    small = _surface(posed, ModelConfig(voxel_mr=0.32, memory_mb=16), say=said.append)
    assert fine.facts['voxel'] == pytest.approx(0.32 * resolution)
    assert fine.facts['volume_mb'] > 16 >= small.facts['volume_mb']
    assert small.facts['voxel'] > fine.facts['voxel']
    assert len(said) == 2 and 'memory_mb' in said[1] and 'memory_mb' not in said[0]
    assert f'{fine.facts["voxels"]:,}' in said[0]


def test_stray_points_far_away_change_nothing():
    posed = _posed('pinhole')
    expected = _surface(posed)
    view = posed[0].view
    far = np.vstack([view.points, [[1e6, 0, 1e6], [1e6, 1, 1e6], [1e6, 0, 1e6 + 1]]])
    strayed = replace(view, points=far, colors=np.broadcast_to(view.colors[:1], far.shape))
    again = pose_views([('0', posed[0].T_object_view)], {'0': strayed}, {'0': 0}, Config())
    surface = _surface((*again, *posed[1:]))
    assert surface.facts['voxels'] == expected.facts['voxels']
    np.testing.assert_allclose(surface.vertices, expected.vertices, atol=1e-4)


def test_same_bytes_whatever_the_threads():
    posed = _posed('pinhole', noise=0.05)
    one, two = (_surface(posed, threads=n) for n in (1, 3))
    assert one.vertices.tobytes() == two.vertices.tobytes()
    assert one.faces.tobytes() == two.faces.tobytes()


def test_nothing_to_make_a_surface_of():
    posed = _posed('pinhole', SIDES[:1])
    with pytest.raises(ModelError, match='no view'):
        volumetric_surface([], ModelConfig(), resolution=1.0)
    bare = replace(posed[0], mesh=replace(posed[0].mesh, faces=np.zeros((0, 3), np.int32)))
    with pytest.raises(ModelError, match='no view'):
        volumetric_surface([bare], ModelConfig(), resolution=1.0)
    with pytest.raises(ModelError, match='resolution'):
        volumetric_surface(posed, ModelConfig(), resolution=float('nan'))
    with pytest.raises(ModelError):
        volumetric_surface(posed, ModelConfig(voxel_mr=50.0), resolution=1.0)
