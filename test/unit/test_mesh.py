# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Meshing; truth: analytic surfaces, and what the sensor can have seen."""

import math

import numpy as np
import pytest
from reference.mesh_twin import surface
from reference.surfaces import DOWN, height_view
from ros_rops.core.config import MeshConfig
from ros_rops.core.errors import ShapeError, ViewError
from ros_rops.core.mesh import build_mesh, image_plane
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.kernels.mesh import delaunay_triangles, grid_triangles, mesh_from_triangles


@pytest.mark.parametrize('grid', [True, False])
def test_plane_is_meshed_fully(grid):
    mesh = build_mesh(height_view(lambda x, y: 0 * x, grid=grid), MeshConfig())
    area = np.cross(
        mesh.vertices[mesh.faces[:, 1]] - mesh.vertices[mesh.faces[:, 0]],
        mesh.vertices[mesh.faces[:, 2]] - mesh.vertices[mesh.faces[:, 0]],
    )
    assert len(mesh.faces) == 2 * 19 * 19
    assert area.sum(axis=0) / 2 == pytest.approx([0, 0, 19 * 19])
    assert np.allclose(mesh.normals, [0, 0, 1])
    assert mesh.boundary.sum() == 4 * 19
    edges = 2 * 20 * 19 + 19 * 19 * math.sqrt(2)
    assert mesh.resolution == pytest.approx(edges / (2 * 20 * 19 + 19 * 19))


@pytest.mark.parametrize('grid', [True, False])
def test_depth_step_is_not_bridged(grid):
    mesh = build_mesh(height_view(lambda x, y: np.where(x < 10, 0, 9.0), grid=grid), MeshConfig())
    assert np.ptp(mesh.vertices[mesh.faces][:, :, 2], axis=1).max() == 0
    assert len(mesh.faces) == 2 * 2 * 9 * 19
    assert mesh.boundary.reshape(20, 20)[:, 9:11].all()


@pytest.mark.parametrize('grid', [True, False])
def test_slope_within_the_limits_is_kept(grid):
    mesh = build_mesh(height_view(lambda x, y: 2 * x, grid=grid), MeshConfig())
    assert len(mesh.faces) == 2 * 19 * 19
    assert np.allclose(mesh.normals, np.array([-2, 0, 1]) / math.sqrt(5))


def test_grazing_triangles_are_dropped():
    view = height_view(lambda x, y: 2 * x)  # seen at 63.4 degrees
    with pytest.raises(ViewError, match='no triangle'):
        build_mesh(view, MeshConfig(grazing_deg=60.0))


def test_pinhole_sphere_has_radial_normals():
    v, u = np.mgrid[-0.4:0.4:80j, -0.4:0.4:80j]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    centre = np.array([0.0, 0.0, 3.0])
    along = rays @ centre
    inside = along**2 - 9 + 1 > 0
    depth = along - np.sqrt(np.where(inside, along**2 - 8, 0))
    grid = np.full(inside.shape, -1, np.int32)
    grid[inside] = np.arange(inside.sum())
    points = (rays * depth[..., None])[inside]
    for pixels in (grid, None):
        mesh = build_mesh(RangeView('ball', points, pixels, SensorModel('pinhole')), MeshConfig())
        inner = ~mesh.boundary
        radial = (points - centre)[inner]
        assert inner.sum() > 0.8 * len(points)
        assert np.einsum('ij,ij->i', radial, mesh.normals[inner]).min() > 0.98


def test_holes_of_the_grid_stay_open():
    view = height_view(lambda x, y: 0 * x)
    grid = view.grid.copy()
    grid[5:8, 5:8] = -1
    mesh = build_mesh(RangeView('hole', view.points, grid, DOWN), MeshConfig())
    assert len(mesh.faces) == 2 * 19 * 19 - 2 * 16 + 4  # four corner cells keep half
    assert mesh.boundary[6 * 20 + 6]
    assert not mesh.normals[6 * 20 + 6].any()


def test_anisotropic_grid_is_kept_whole():
    y, x = np.mgrid[0:10, 0:30].astype(float)
    points = np.stack([x, 5 * y, 0 * x], axis=-1).reshape(-1, 3)
    view = RangeView('stretched', points, np.arange(300, dtype=np.int32).reshape(10, 30), DOWN)
    assert len(build_mesh(view, MeshConfig()).faces) == 2 * 9 * 29


def test_far_from_the_origin_nothing_changes():
    view = height_view(lambda x, y: np.sin(x) + 0.3 * y, grid=False)
    moved = RangeView('far', view.points + 1e6, None, DOWN)
    near, far = build_mesh(view, MeshConfig()), build_mesh(moved, MeshConfig())
    assert len(near.faces) == len(far.faces)
    assert far.resolution == pytest.approx(near.resolution, rel=1e-6)


@pytest.mark.parametrize(('points', 'message'), [
    (np.zeros((0, 3)), '0 points'),
    (np.eye(3)[:2], '2 points'),
    (np.zeros((50, 3)), 'no triangle'),
    (np.arange(30.0)[:, None] * [1, 2, 3], 'no triangle'),
])
def test_views_without_a_surface_are_refused(points, message):
    with pytest.raises(ViewError, match=message):
        build_mesh(RangeView('poor', points, None, DOWN), MeshConfig())


def test_empty_grid_is_refused():
    view = height_view(lambda x, y: 0 * x)
    blank = RangeView('blank', view.points, np.full((20, 20), -1, np.int32), DOWN)
    with pytest.raises(ViewError, match='no triangle'):
        build_mesh(blank, MeshConfig())


def test_points_behind_a_pinhole_are_refused():
    points = np.random.default_rng(0).normal(size=(40, 3)) - [0, 0, 50]
    with pytest.raises(ViewError, match='in front'):
        build_mesh(RangeView('behind', points, None, SensorModel('pinhole')), MeshConfig())


def test_duplicated_points_do_no_harm():
    view = height_view(lambda x, y: 0.2 * x, grid=False)
    mesh = build_mesh(RangeView('twice', np.tile(view.points, (2, 1)), None, DOWN), MeshConfig())
    assert len(mesh.vertices) == 800
    assert len(mesh.faces) == 2 * 19 * 19


def test_image_plane_of_a_pinhole_is_the_tangent():
    points = np.array([[1.0, 2.0, 4.0], [0.0, 0.0, -1.0]])
    uv, indices = image_plane(SensorModel('pinhole'), points)
    assert indices.tolist() == [0]
    assert sorted(np.abs(uv[0])) == pytest.approx([0.25, 0.5])


@pytest.mark.parametrize('seed', range(3))
def test_kernel_equals_the_twin(seed):
    random = np.random.default_rng(seed)
    uv = random.random((400, 2)) * 20
    step = np.where(uv[:, 0] > 12, 3.0, 0.0)
    points = np.c_[uv, 2 * np.sin(uv[:, 0]) + step + random.normal(size=400) * 0.1]
    rays = random.normal(size=(400, 3)) * 0.1 + [0, 0, 1]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    candidates = delaunay_triangles(uv)
    found = mesh_from_triangles(points, rays, candidates, 2.5, 0.3)
    faces, normals, boundary, resolution = surface(points, rays, candidates, 2.5, 0.3)
    assert 0.2 * len(candidates) < len(faces) < 0.9 * len(candidates)
    assert np.array_equal(found.faces, faces)
    assert np.allclose(found.normals, normals, atol=1e-12)
    assert np.array_equal(found.boundary, boundary)
    assert found.resolution == pytest.approx(resolution, rel=1e-12)


def test_points_on_a_slanted_line_are_no_surface():
    t = np.random.default_rng(4).random(300)[:, None]
    with pytest.raises(ViewError, match='no triangle'):
        build_mesh(RangeView('line', t * [0.3, 0.7, 0.9], None, DOWN), MeshConfig())


def test_kernel_faces_check_shapes():
    points = np.zeros((4, 3))
    faces = np.zeros((1, 3), np.int32)
    with pytest.raises(ShapeError, match='points'):
        grid_triangles(np.zeros((4, 2)), np.zeros((2, 2), np.int32))
    with pytest.raises(ShapeError, match='grid: expected'):
        grid_triangles(points, np.zeros(4, np.int32))
    with pytest.raises(ShapeError, match='below 4'):
        grid_triangles(points, np.full((2, 2), 4, np.int32))
    with pytest.raises(ShapeError, match='rays'):
        mesh_from_triangles(points, points[:2], faces, 4.0, 0.1)
    with pytest.raises(ShapeError, match='faces: expected'):
        mesh_from_triangles(points, points, faces[:, :2], 4.0, 0.1)
    with pytest.raises(ShapeError, match='indices'):
        mesh_from_triangles(points, points, faces + 9, 4.0, 0.1)
