# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Synthetic captures; truth: analytic surfaces, the fields behind the objects, the demo file."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from ros_rops.core.errors import ParameterError
from ros_rops.recordings.depth_noise import DepthNoise
from ros_rops.recordings.make_demo import demo_captures, demo_models, TOPIC
from ros_rops.recordings.poses import read_poses
from ros_rops.recordings.procedural import EXTENT_M, mesh_of, OBJECTS
from ros_rops.recordings.raycast import Camera, cast
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.synthetic import (
    look_at, Model, render_view, resolution_of, synthetic_views)
from ros_rops.recordings.view_facts import organized

BAGS = Path(__file__).resolve().parents[2] / 'bags'
CAMERA = Camera(60, 40, 50.0, 55.0, 29.5, 19.5)


def sphere(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points, axis=-1) - 0.08


@pytest.fixture(scope='module')
def ball() -> Model:
    return Model(*mesh_of(sphere, cell=0.004), name='ball')


@pytest.mark.parametrize('name', ['ball', *OBJECTS])
def test_mesh_is_closed_and_outward(name):
    field = sphere if name == 'ball' else OBJECTS[name]()
    vertices, faces = mesh_of(field, cell=0.004)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forward = {tuple(e) for e in edges.tolist()}
    assert len(forward) == len(edges)  # every directed edge once ...
    assert forward == {(b, a) for a, b in forward}  # ... and its reverse once
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = np.einsum('ij,ij->i', a, np.cross(b, c)).sum() / 6
    if name == 'ball':
        assert volume == pytest.approx(4 / 3 * np.pi * 0.08**3, rel=0.01)
    assert volume > 2e-4
    assert np.abs(vertices).max() < EXTENT_M - 0.01  # nothing is cut off
    assert np.abs(field(vertices)).max() < 1e-4


def test_depth_of_a_tilted_plane_is_exact():
    corners = np.array([[-9, -9, 4.0], [9, -9, 6.0], [9, 9, 8.0], [-9, 9, 6.0]])
    depth, face = cast(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32), CAMERA)
    rays = CAMERA.rays()  # the plane: z = 6 + x / 9 + y / 9
    np.testing.assert_allclose(
        depth, 6 / (1 - rays[..., 0] / 9 - rays[..., 1] / 9), rtol=1e-12)
    assert set(np.unique(face)) == {0, 1}


def test_nearer_surface_hides_the_other():
    far = np.array([[-9, -9, 5.0], [9, -9, 5.0], [0, 9, 5.0]])
    near = far * [0.05, 0.05, 0.4]
    vertices, faces = np.concatenate([far, near]), np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    for order in (faces, faces[::-1]):
        depth, _ = cast(vertices, order, CAMERA)
        assert set(np.unique(depth[np.isfinite(depth)].round(9))) == {2.0, 5.0}
        assert depth[20, 30] == pytest.approx(2.0)


def test_nothing_behind_or_beside_the_camera():
    triangle = np.array([[-1, -1, -3.0], [1, -1, -3.0], [0, 1, -3.0]])
    faces = np.array([[0, 1, 2]], np.int32)
    for vertices in (triangle, triangle * [1, 1, 0], triangle * [1, 1, -1] + [50, 0, 0]):
        depth, face = cast(vertices, faces, CAMERA)
        assert np.isnan(depth).all()
        assert (face == -1).all()


def test_points_lie_on_the_object_under_the_exact_pose(ball):
    for capture in synthetic_views(ball, count=5, pixels=80):
        T = capture.T_world_view
        world = capture.view.points @ T[:3, :3].T + T[:3, 3]
        radii = np.linalg.norm(world, axis=1)
        assert len(world) > 1000
        assert radii.max() < 0.08 + 1e-5
        assert radii.min() > 0.08 - 8e-5  # diagonals of 4 mm cells sag by 3 * 4^2 / (8 * 80) mm
        eye = T[:3, 3]
        outward = np.einsum('ij,ij->i', world, eye - world)
        assert outward.min() > -1e-4  # only the side that faces the camera
        assert capture.view.sensor.kind == 'pinhole'
        assert capture.view.grid.shape == (80, 80)


def test_grid_matches_the_pixels(ball):
    view = synthetic_views(ball, count=1, pixels=64)[0].view
    rows, columns = np.nonzero(view.grid >= 0)
    p = view.points[view.grid[rows, columns]]
    np.testing.assert_allclose(1.05 * 64 * p[:, 0] / p[:, 2] + 31.5, columns, atol=1e-9)
    np.testing.assert_allclose(1.05 * 64 * p[:, 1] / p[:, 2] + 31.5, rows, atol=1e-9)


@pytest.mark.parametrize('level', [0.5, 2.0])
def test_uniform_noise_has_the_stated_size(ball, level):
    """Difference along the ray between a noisy and a clean capture of the same pose."""
    clean = synthetic_views(ball, count=3, pixels=100)
    noisy = synthetic_views(ball, count=3, pixels=100, noise_mr=level)
    for a, b in zip(clean, noisy, strict=True):
        np.testing.assert_array_equal(a.T_world_view, b.T_world_view)
        np.testing.assert_array_equal(a.view.grid, b.view.grid)
        along = np.linalg.norm(b.view.points, axis=1) - np.linalg.norm(a.view.points, axis=1)
        resolution = resolution_of(organized(a.view)[0])
        assert along.std() == pytest.approx(level * resolution, rel=0.06)
        assert abs(along.mean()) < 0.1 * level * resolution


def test_resolution_of_a_unit_lattice():
    y, x = np.mgrid[:20, :30].astype(float)
    points = np.stack([x, y, 0 * x], axis=-1)
    straight, diagonal = 20 * 29 + 19 * 30, 19 * 29
    mean = (straight + diagonal * np.sqrt(2)) / (straight + diagonal)
    assert resolution_of(points) == pytest.approx(mean)
    points[:, 15:, 2] += 50  # a step does not count
    assert resolution_of(points) == pytest.approx(mean, rel=0.01)
    assert resolution_of(np.full((4, 4, 3), np.nan)) == 0.0


def test_depth_noise(ball):
    camera = Camera(160, 160, 160.0, 160.0, 79.5, 79.5)
    T = look_at(np.array([0.1, -0.2, 0.2]), np.zeros(3))
    clean = organized(render_view(ball, T, camera).view)[0]
    noise = DepthNoise(axial=0.01, quantum=0.0, grazing_deg=60.0, lost=0.0)
    noisy = organized(
        render_view(ball, T, camera, noise=noise, rng=np.random.default_rng(1)).view)[0]
    both = np.isfinite(noisy[..., 2])
    error = (noisy - clean)[both, 2]
    assert error.std() == pytest.approx((0.01 * clean[both, 2] ** 2).mean(), rel=0.05)
    world = clean @ T[:3, :3].T + T[:3, 3]
    toward = T[:3, 3] - world
    cosine = (world * toward).sum(-1) / np.linalg.norm(world, axis=-1)
    angle = np.degrees(np.arccos(cosine / np.linalg.norm(toward, axis=-1)))
    assert angle[both].max() < 63  # facets deviate by a degree or two from the sphere
    assert np.isnan(noisy[angle > 63, 2]).all()
    stepped = organized(render_view(
        ball, T, camera, noise=DepthNoise(quantum=0.05), rng=np.random.default_rng(1)).view)[0]
    levels = np.unique(stepped[np.isfinite(stepped[..., 2]), 2])
    np.testing.assert_allclose(np.diff(levels) / np.diff(levels).min() % 1, 0, atol=1e-6)
    edges = DepthNoise(axial=0.0, quantum=0.0, grazing_deg=90.0, lost=0.0)
    frayed = organized(
        render_view(ball, T, camera, noise=edges, rng=np.random.default_rng(1)).view)[0]
    missing = np.isnan(frayed[..., 2]) & np.isfinite(clean[..., 2])
    assert 0 < missing.sum() < 0.05 * np.isfinite(clean[..., 2]).sum()
    assert angle[missing].min() > 60


def test_colours_and_stated_errors(ball):
    colors = np.full(ball.vertices.shape, 77, np.uint8)
    model = Model(ball.vertices, ball.faces, colors, units='mm')
    capture = render_view(model, look_at(np.array([0.0, 0, 0.4]), np.zeros(3)), CAMERA)
    assert set(np.unique(capture.view.colors)) == {77}
    assert capture.view.units == 'mm'
    with pytest.raises(ParameterError, match='rng'):
        render_view(model, np.eye(4), CAMERA, noise_mr=1.0)
    with pytest.raises(ParameterError, match='count'):
        synthetic_views(model, count=0)


def test_look_at_is_a_rigid_pose_that_looks_at_the_target():
    rng = np.random.default_rng(3)
    for eye in (*rng.normal(size=(5, 3)), np.array([0.0, 0.0, 2.0]), np.array([0.0, -3.0, 0])):
        target = np.zeros(3)
        T = look_at(eye, target, 1.1)
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(T[:3, :3]) > 0
        seen = np.linalg.inv(T) @ [*target, 1]
        np.testing.assert_allclose(seen, [0, 0, np.linalg.norm(eye), 1], atol=1e-12)


@pytest.fixture(scope='module')
def demo():
    source, = find_views([BAGS / 'demo.mcap'])
    return [outcome.view for outcome in source.views()]


def test_demo_recording_is_what_its_generator_makes(demo):
    """Point by point; a last digit may differ between processors, so a few may move a step."""
    made = demo_captures(demo_models())
    poses = read_poses(BAGS / 'demo_poses.json')
    assert len(made) == len(demo) == len(poses.T_world_view) == 20
    for capture, view in zip(made, demo, strict=True):
        assert view.name == capture.view.name
        assert view.stamp_ns == capture.view.stamp_ns
        assert poses.objects[view.name] == capture.object_name
        np.testing.assert_allclose(
            poses.T_world_view[view.name], capture.T_world_view, atol=1e-12)
        stored, fresh = organized(view)[0], organized(capture.view)[0]
        holes = np.isnan(stored[..., 2]) == np.isnan(fresh[..., 2])
        assert holes.mean() > 0.9999
        same = np.isclose(stored, fresh, rtol=0, atol=1e-6, equal_nan=True).all(axis=-1)
        assert same.mean() > 0.9999


def test_demo_recording_is_fit_for_its_purpose(demo):
    poses = read_poses(BAGS / 'demo_poses.json')
    shown = [poses.objects[view.name] for view in demo]
    assert sorted(set(shown)) == sorted(OBJECTS)
    assert 5 < sum(a != b for a, b in pairwise(shown)) < 19  # shuffled
    assert (BAGS / 'demo.mcap').stat().st_size < 5_000_000
    fields = {name: make() for name, make in OBJECTS.items()}
    for view in demo:
        assert view.name.startswith(f'{TOPIC}@')
        assert view.sensor.kind == 'pinhole'
        assert view.units == 'm'
        assert view.colors is not None
        assert len(view.points) > 5000
        border = np.concatenate([view.grid[[0, -1]].ravel(), view.grid[:, [0, -1]].ravel()])
        assert (border == -1).mean() > 0.9  # the object is in the image
        T = poses.T_world_view[view.name]
        world = view.points @ T[:3, :3].T + T[:3, 3]
        off = fields[poses.objects[view.name]](world)
        assert np.percentile(np.abs(off), 99) < 0.002  # the pose is the right one
