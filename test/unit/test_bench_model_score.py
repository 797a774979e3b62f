# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Judging surfaces. Truth: analytic (spheres, planes), brute force, Open3D as an oracle."""

from dataclasses import replace

import numpy as np
import pytest
from ros_rops.bench.model_distance import Triangles
from ros_rops.bench.model_score import judge_surface, seen_by, surface_facts
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import RangeView, SensorModel
from ros_rops.modelling.products import SurfaceMesh


def sphere(radius=1.0, steps=60):
    """Return a sphere of rings, its triangles counter-clockwise from outside, no seam."""
    lat = np.pi * np.arange(1, steps) / steps
    lon = np.pi * np.arange(2 * steps) / steps
    ring = np.stack([
        np.sin(lat)[:, None] * np.cos(lon), np.sin(lat)[:, None] * np.sin(lon),
        np.broadcast_to(np.cos(lat)[:, None], (len(lat), len(lon)))], axis=-1).reshape(-1, 3)
    vertices = np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]]) * radius
    size, rows = len(lon), np.arange(len(lat) - 1)[:, None] * len(lon)
    here, after = np.arange(size), (np.arange(size) + 1) % size
    faces = [np.stack([rows + here, rows + size + here, rows + after], axis=-1).reshape(-1, 3),
             np.stack([rows + after, rows + size + here, rows + size + after],
                      axis=-1).reshape(-1, 3)]
    top, low = np.full(size, len(ring)), np.full(size, len(ring) + 1)
    last = (len(lat) - 1) * size
    faces += [np.stack([top, here, after], axis=-1),
              np.stack([low, last + after, last + here], axis=-1)]
    return vertices, np.concatenate(faces).astype(np.int32)


def surface(vertices, faces):
    return SurfaceMesh(
        vertices, faces, np.zeros((len(vertices), 3), np.float32), None,
        np.zeros(len(faces), bool))


def plane(side=10, z=0.0):
    y, x = np.mgrid[:side + 1, :side + 1]
    vertices = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1).astype(float)
    low = (y[:-1, :-1] * (side + 1) + x[:-1, :-1]).ravel()
    quads = np.stack([low, low + 1, low + side + 2, low + side + 1], axis=1)
    return vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)


def judged(model, reference, T=None, dres=0.01, **more):
    return judge_surface(surface(*model), Triangles(*reference), np.eye(4) if T is None else T,
                         dres, samples=5000, **more)


def test_a_plane_raised_is_as_far_as_it_was_raised():
    score = judged(plane(z=0.25), plane(), dres=0.1)
    assert [score.accuracy, score.median, score.worst] == pytest.approx([2.5] * 3)
    assert score.bias == pytest.approx(2.5)
    assert score.completeness == 0.0
    assert (score.normals_deg, score.turned_share) == (pytest.approx(0.0), 0.0)
    assert judged(plane(z=-0.1), plane(), dres=0.1).bias == pytest.approx(-1.0)
    assert judged(plane(z=-0.1), plane(), dres=0.1).completeness == 1.0


@pytest.mark.parametrize('offset', [0.03, -0.03])
def test_a_sphere_of_another_radius_is_as_far_as_the_radii_differ(offset):
    # The flat triangles lie up to 1 - cos(1.5 deg) = 0.00034 inside of the round sphere.
    score = judged(sphere(1.0 + offset), sphere())
    for value in (score.accuracy, score.accuracy_vertices, score.median):
        assert value == pytest.approx(3.0, abs=0.05)
    assert score.bias == pytest.approx(100 * offset, abs=0.05)


def test_half_a_sphere_is_half_complete_and_accurate():
    vertices, faces = sphere()
    half = faces[vertices[faces].mean(axis=1)[:, 2] > 0]
    score = judged((vertices, half), (vertices, faces))
    assert score.completeness == pytest.approx(0.5, abs=0.02)
    assert score.worst < 1e-9
    # The other way round nothing is missing, and what is too much is nearest to the rim.
    score = judged((vertices, faces), (vertices, half))
    assert score.completeness == 1.0
    assert score.accuracy > 50
    assert score.accuracy_inner < 1e-9


def test_the_pose_is_applied_to_the_model():
    T = np.eye(4)
    T[:3, 3] = 1.0, -2.0, 3.0
    vertices, faces = sphere()
    assert judged((vertices - T[:3, 3], faces), (vertices, faces), T).worst < 1e-9


def test_a_surface_inside_out_is_told():
    vertices, faces = sphere()
    score = judged((vertices, faces[:, ::-1]), (vertices, faces))
    assert (score.turned_share, score.normals_deg) == (1.0, pytest.approx(180.0))


def test_seen_is_what_has_a_scan_point_near_on_its_side():
    vertices, faces = sphere()
    reference = Triangles(vertices, faces)
    upper = vertices[vertices[:, 2] > 0.01]
    down = SensorModel('orthographic', direction=(0.0, 0.0, -1.0))
    view = RangeView('upper', upper, sensor=down)
    seen = seen_by(reference, [(view, np.eye(4))], dres=1e-6)
    np.testing.assert_array_equal(seen, reference.vertices[:, 2] > 0.01)
    up = replace(view, sensor=SensorModel('orthographic', direction=(0.0, 0.0, 1.0)))
    assert not seen_by(reference, [(up, np.eye(4))], dres=1e-6).any()
    half = faces[vertices[faces].mean(axis=1)[:, 2] > 0]
    score = judged((vertices, half), (vertices, faces), seen=seen)
    assert (score.completeness_seen, score.seen_share) == (1.0, seen.mean())


def brute(points, corners, fine=120):
    """Return distances by looking at many places of every triangle: never too small."""
    u, v = np.mgrid[:fine + 1, :fine + 1] / fine
    inside = u + v <= 1
    weights = np.stack([1 - u - v, u, v], axis=-1)[inside]
    places = np.einsum('wk,tkd->twd', weights, corners).reshape(-1, 3)
    return np.sqrt(((points[:, None] - places[None]) ** 2).sum(-1)).min(axis=1)


def soup(count=30, seed=3):
    """Return triangles of very different sizes, long and degenerate ones among them."""
    rng = np.random.default_rng(seed)
    middles = rng.normal(size=(count, 1, 3))
    corners = middles + rng.normal(size=(count, 3, 3)) * 10 ** rng.uniform(-3, 0.3, (count, 1, 1))
    corners[0, 2] = corners[0, 1]
    corners[1, 2] = (corners[1, 0] + corners[1, 1]) / 2
    corners[2] = corners[2, :1]
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def test_distances_are_exact():
    vertices, faces = soup()
    mesh = Triangles(vertices, faces)
    points = np.random.default_rng(4).normal(size=(40, 3)) * 2
    found = mesh.closest(points)
    coarse = brute(points, mesh.corners)
    assert (found.distance <= coarse + 1e-12).all()
    assert (coarse - found.distance).max() < 0.03
    rebuilt = np.einsum('nk,nkd->nd', found.weights, mesh.corners[found.face])
    np.testing.assert_allclose(rebuilt, found.foot, atol=1e-12)
    assert (found.weights >= 0).all()
    # Nearest place: no step along its triangle, within it, comes nearer.
    rng = np.random.default_rng(5)
    for _ in range(50):
        other = rng.dirichlet(np.ones(3), len(points))
        step = 0.99 * found.weights + 0.01 * other
        place = np.einsum('nk,nkd->nd', step, mesh.corners[found.face])
        assert (np.linalg.norm(points - place, axis=1) >= found.distance - 1e-12).all()


def test_distances_are_those_of_open3d():
    o3d = pytest.importorskip('open3d')
    vertices, faces = soup(300)
    points = np.random.default_rng(6).normal(size=(2000, 3)) * 2
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(vertices.astype(np.float32), faces.astype(np.uint32))
    expected = scene.compute_distance(points.astype(np.float32)).numpy()
    np.testing.assert_allclose(
        Triangles(vertices, faces).closest(points).distance, expected, atol=2e-5)


def test_samples_are_even_over_the_area():
    vertices, faces = plane(2)
    vertices = vertices * (1.0, 3.0, 1.0)
    points, owners = Triangles(vertices, faces).samples(10000, seed=1)
    counts = np.histogram2d(points[:, 0], points[:, 1], bins=(4, 6))[0]
    assert abs(counts / 10000 * 24 - 1).max() < 0.15
    assert set(owners) == set(range(len(faces)))


def test_what_is_counted_on_a_surface():
    vertices, faces = sphere(steps=12)
    facts = surface_facts(surface(vertices, faces))
    assert facts['closed'] and facts['components'] == 1 and facts['holes'] == 0
    assert facts['open_edges'] == facts['branching_edges'] == facts['turned_edges'] == 0
    assert surface_facts(surface(vertices, faces[1:]))['open_edges'] == 3
    assert surface_facts(surface(vertices, faces[1:]))['holes'] == 1
    turned = faces.copy()
    turned[5] = turned[5, ::-1]
    assert surface_facts(surface(vertices, turned))['turned_edges'] == 3
    assert surface_facts(surface(vertices, np.vstack([faces, faces[:1]])))['branching_edges'] == 3
    chip = np.array([[0, 1, 2]]) + len(vertices)
    both = surface(np.vstack([vertices, vertices[faces[0]] + 9]), np.vstack([faces, chip]))
    assert (surface_facts(both)['components'], surface_facts(both)['floating']) == (2, 1)


@pytest.mark.parametrize(('faces', 'said'), [
    (np.zeros((0, 3), int), 'at least one'), ([[0, 1, 7]], '0 .. 2'), ([0, 1, 2], r'\(F, 3\)')])
def test_a_mesh_without_sense_is_refused(faces, said):
    with pytest.raises(ShapeError, match=said):
        Triangles(np.eye(3), np.asarray(faces))


def test_a_judgement_without_a_length_is_refused():
    with pytest.raises(ShapeError, match='dres'):
        judged(plane(), plane(), dres=0.0)
    with pytest.raises(ShapeError, match='seen'):
        judged(plane(), plane(), seen=np.ones(3, bool))
