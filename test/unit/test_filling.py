# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Holes filled. Truth: analytic bodies seen from some sides only, and every triangle by itself."""

from dataclasses import replace

import numpy as np
import pytest
from reference.winding_twin import winding_number
from ros_rops.core.config import Config
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.kernels.winding import Winding
from ros_rops.modelling.posed import pose_views, resolution_of
from ros_rops.modelling.volume import volumetric_surface
import trimesh

PINHOLE = SensorModel('pinhole')


def camera(direction):
    """Pose of a camera 4 away that looks at the origin from `direction`."""
    z = -np.asarray(direction, float) / np.linalg.norm(direction)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    T[:3, 3] = -4 * z
    return T


def seen_from(depth, directions, size=100):
    """Render views of a body; depth(eye, rays) is the distance along each ray, NaN beside."""
    poses, views = [], {}
    v, u = np.mgrid[0:size, 0:size]
    # Wide enough for all of the body: what is cut off by the image was not seen.
    rays = np.stack([(u - size / 2) / (1.4 * size), (v - size / 2) / (1.4 * size), 0 * u + 1.0], 2)
    rays = rays.reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    for number, direction in enumerate(directions):
        T = camera(direction)
        distance = depth(T[:3, 3], rays @ T[:3, :3].T)
        hit = np.isfinite(distance)
        grid = np.where(hit, np.cumsum(hit) - 1, -1).reshape(size, size).astype(np.int32)
        name = str(number)
        views[name] = RangeView(name, (rays * distance[:, None])[hit], grid, PINHOLE)
        poses.append((name, T))
    numbers = {name: number for number, name in enumerate(views)}
    return pose_views(poses, views, numbers, Config())


def ball(eye, rays):
    """Distance along rays to the unit ball about the origin."""
    along = rays @ eye
    inner = along**2 - eye @ eye + 1
    with np.errstate(invalid='ignore'):
        return -along - np.sqrt(inner)


def cube(eye, rays):
    """Distance along rays to the cube from -0.7 to 0.7."""
    with np.errstate(divide='ignore'):
        one, other = (-0.7 - eye) / rays, (0.7 - eye) / rays
    near, far = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    return np.where(near < far, near, np.nan)


def made(views, **changes):
    config = replace(Config().model, holes='filled', **changes)
    return volumetric_surface(views, config, resolution=resolution_of(views), threads=2)


AROUND = [*((np.cos(turn), np.sin(turn), .4) for turn in np.arange(8) * np.pi / 4), (0, 0, 1)]


def test_the_floor_that_a_cube_stands_on_is_closed_flat():
    views = seen_from(cube, AROUND)
    mr = resolution_of(views)
    surface = made(views)
    assert surface.facts['closed'] and surface.facts['manifold']
    assert surface.facts['components'] == 1
    # The lowest row of pixels on the walls lies up to a pixel above the floor.
    assert surface.facts['volume'] == pytest.approx(1.4**3, abs=1.4**2 * mr)
    floor = surface.vertices[surface.faces[surface.filled]].mean(axis=1)
    inner = np.abs(floor[:, :2]).max(axis=1) < 0.6
    assert inner.sum() > 100
    assert np.quantile(np.abs(floor[inner, 2] + 0.7), 0.9) < 1.5 * mr
    seen = surface.vertices[surface.faces[~surface.filled]].mean(axis=1)
    assert seen[:, 2].min() > -0.7 - mr


def test_without_the_wish_holes_stay_open():
    views = seen_from(cube, AROUND)
    surface = volumetric_surface(
        views, Config().model, resolution=resolution_of(views), threads=2)
    assert not surface.facts['closed'] and not surface.filled.any()


def test_the_part_of_a_ball_that_was_not_seen_becomes_a_flat_cap():
    views = seen_from(ball, AROUND)
    surface = made(views)
    assert surface.facts['closed'] and surface.facts['manifold']
    radius = np.linalg.norm(surface.vertices, axis=1)
    assert radius.max() < 1 + resolution_of(views)
    seen = surface.vertices[np.unique(surface.faces[~surface.filled])]
    hull = trimesh.PointCloud(seen).convex_hull.volume
    # The rim is scalloped, and the cap within its hull.
    assert 0.9 * hull < surface.facts['volume'] < 1.01 * hull
    marked = surface.vertices[surface.faces[surface.filled]].mean(axis=1)
    assert marked[:, 2].max() < -0.3 and surface.facts['filled_share'] < 0.3


def test_one_view_alone_becomes_a_solid():
    surface = made(seen_from(ball, [(0, 0, 1)]))
    assert surface.facts['closed'] and surface.facts['manifold']
    assert 0 < surface.facts['volume'] < 4.18879


def test_what_a_view_saw_to_be_empty_stays_empty():
    """Two walls, whose gap would be filled, but a third view looks through it on to a wall."""
    def walls(eye, rays):
        with np.errstate(divide='ignore', invalid='ignore'):
            reach = (-0.5 - eye[2]) / rays[:, 2]
            place = eye + reach[:, None] * rays
            floor = np.where((np.abs(place) <= 0.9).all(axis=1) & (reach > 0), reach, np.nan)
            solid = cube_at(eye, rays, (-0.6, 0, 0)), cube_at(eye, rays, (0.6, 0, 0))
        return np.fmin(floor, np.fmin(*solid))

    def cube_at(eye, rays, centre):
        half = np.array([0.25, 0.7, 0.5])
        one, other = (centre - half - eye) / rays, (centre + half - eye) / rays
        near, far = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
        return np.where(near < far, near, np.nan)

    views = seen_from(walls, [(1, 0, .2), (-1, 0, .2), (0, 1, .2), (0, -1, .2), (0, 0, 1)])
    surface = made(views)
    assert surface.facts['closed']
    marked = surface.vertices[surface.faces[surface.filled]].mean(axis=1)
    for view in views:
        look = view.sight().look(marked, reach=0.3)
        clear = np.where(np.isnan(look.distance), 0.0, look.distance * look.cosine)
        assert (clear > 2.5 * surface.facts['voxel']).mean() < 0.002


def test_threads_make_no_difference():
    views = seen_from(cube, AROUND)
    config = replace(Config().model, holes='filled')
    one, other = (
        volumetric_surface(views, config, resolution=resolution_of(views), threads=threads)
        for threads in (1, 2))
    assert one.vertices.tobytes() == other.vertices.tobytes()
    assert one.faces.tobytes() == other.faces.tobytes()


def open_ball():
    mesh = trimesh.creation.icosphere(4)
    faces = np.array(mesh.faces, np.int32)[mesh.triangles_center[:, 2] > -0.6]
    return np.array(mesh.vertices), faces


def test_winding_numbers_are_those_of_the_triangles_one_by_one():
    vertices, faces = open_ball()
    points = np.random.default_rng(0).uniform(-1.4, 1.4, (300, 3))
    turns = Winding.of(vertices, faces).at(points, threads=2)
    exact = [winding_number(vertices, faces, point) for point in points]
    assert np.abs(turns - exact).max() < 2e-3
    assert turns.tobytes() == Winding.of(vertices, faces).at(points, threads=1).tobytes()


def test_winding_numbers_at_the_mouth_of_an_open_ball_are_one_half():
    vertices, faces = open_ball()
    rim = vertices[faces][vertices[faces][:, :, 2] < -0.55][:, 2].min()
    mouth = np.array([[0.0, 0, rim], [0.2, 0.1, rim], [-0.3, 0.2, rim]])
    # The rim is a zigzag of 0.07, of which this is the lower end.
    assert np.abs(Winding.of(vertices, faces).at(mouth) - 0.5).max() < 0.03


def test_what_is_no_mesh_is_refused():
    vertices, faces = open_ball()
    for wrong in ((vertices[:, :2], faces), (vertices, faces[:, :2]), (vertices[:9], faces)):
        with pytest.raises(ShapeError):
            Winding.of(*wrong)
    with pytest.raises(ShapeError):
        Winding.of(vertices, faces).at(np.zeros(3))
    assert Winding.of(vertices, faces[:0]).at(np.zeros((1, 3))).tolist() == [0.0]
