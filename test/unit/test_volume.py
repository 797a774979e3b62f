# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The volume against its twin in NumPy, and what is extracted from it against closed forms."""

from itertools import product

import numpy as np
import pytest
from reference import volume_twin
from reference.surfaces import bumps, DOWN, height_view
from ros_rops.core.config import MeshConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.mesh import build_mesh
from ros_rops.core.types import SensorModel
from ros_rops.kernels.sight import Sight
from ros_rops.kernels.volume import BRICK, Distances, Volume
from ros_rops.modelling.extraction import extract
from ros_rops.modelling.topology import face_vectors

PINHOLE = SensorModel('pinhole', origin=(8.0, 12.0, 40.0), direction=(0.0, 0.0, -1.0))
ORIGIN = np.array([7.3, 8.1, 0.4])


def _views():
    """Two views of one field, the second shifted up a little and with rays that pass by."""
    mesh = build_mesh(height_view(bumps, (18, 19), jitter=0.2), MeshConfig())
    weights = np.linspace(0.2, 1, len(mesh.vertices)).astype(np.float32)
    x, y = np.mgrid[-20:40, -20:40] + 0.5
    table = np.stack([x, y, np.full_like(x, -30.0)], axis=-1).reshape(-1, 3).astype(np.float32)
    raised = np.eye(4)
    raised[2, 3] = 0.3
    return mesh, [
        Sight.of(mesh.vertices, mesh.faces, weights, PINHOLE),
        Sight.of(mesh.vertices, mesh.faces, weights[::-1], DOWN, T_object_view=raised,
                 beyond=table)]


def _volume(voxel=0.8, band=2.0, threads=0):
    mesh, sights = _views()
    volume = Volume(ORIGIN, voxel, band)
    assert volume.touch(mesh.vertices, mesh.faces, longest=20.0, most=10_000)
    for sight in sights:
        volume.integrate(sight, threads=threads)
    return volume, mesh, sights


def _places(bricks, voxel):
    steps = np.stack(np.meshgrid(*[np.arange(BRICK)] * 3, indexing='ij'), axis=-1)
    return ORIGIN + voxel * (BRICK * bricks[:, None, None, None] + steps)


def test_distances_as_the_twin_has_them():
    volume, _, sights = _volume()
    bricks, values = volume.distances()
    low, high = bricks.min(axis=0), bricks.max(axis=0) + 1
    means = volume_twin.distances(
        _places(bricks, 0.8).reshape(-1, 3), sights, 2.0, 0.8).reshape(values.shape)
    lattice = np.full((high - low) * BRICK, np.nan)
    places = [tuple(slice(a, a + BRICK) for a in (brick - low) * BRICK) for brick in bricks]
    for place, brick in zip(places, means, strict=True):
        lattice[place] = brick
    whole = volume_twin.continued(lattice, 2.0 / 0.8)
    expected = np.array([whole[place] for place in places])
    added = np.isfinite(expected) & np.isnan(means)
    assert added.sum() > 100 and 0.1 < np.isnan(expected).mean() < 0.9
    same = np.isnan(values) == np.isnan(expected)
    # Single precision decides otherwise where a limit is met to the last digit.
    assert (~same).mean() < 1e-4
    known = same & np.isfinite(values) & (np.abs(expected) > 2e-3)
    np.testing.assert_allclose(values[known], expected[known], atol=2e-4)
    assert np.nanmin(np.abs(values)) >= np.float32(1e-3)


def test_bricks_reach_as_far_as_the_band():
    """Truth: analytic. Each place within the band of a vertex lies in a brick."""
    volume, mesh, _ = _volume()
    kept = {tuple(brick) for brick in volume.distances().bricks.tolist()}
    directions = np.array(list(product((-1, 0, 1), repeat=3))[:13])
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    used = mesh.vertices[np.unique(mesh.faces)]
    around = (used[:, None] + 1.99 * np.concatenate([directions, -directions])).reshape(-1, 3)
    assert {tuple(b) for b in np.floor(
        (around - ORIGIN) / 0.8 / BRICK).astype(int).tolist()} <= kept
    assert volume.bricks == len(kept)


def test_same_bytes_whatever_the_threads():
    one, *others = [_volume(threads=n)[0].distances(threads=n) for n in (1, 2, 5)]
    for other in others:
        assert one.values.tobytes() == other.values.tobytes()
        assert one.bricks.tobytes() == other.bricks.tobytes()


def test_too_many_bricks_and_faces_that_are_no_surface():
    mesh, _ = _views()
    assert not Volume(ORIGIN, 0.8, 2.0).touch(mesh.vertices, mesh.faces, longest=20.0, most=3)
    volume = Volume(ORIGIN, 0.8, 2.0)
    far = np.array([[0, 0, 0], [1e6, 0, 0], [0, 1e6, 0], [1e12, 0, 0], [1e12, 1, 0], [1e12, 0, 1]])
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    assert volume.touch(far, faces, longest=20.0, most=10) and volume.bricks == 0
    assert volume.distances().values.shape == (0, 8, 8, 8)


def _of_field(field, bricks):
    """Bricks (B, 3) that know a distance everywhere; in voxels, about the origin."""
    steps = np.stack(np.meshgrid(*[np.arange(BRICK)] * 3, indexing='ij'), axis=-1)
    values = field(BRICK * np.asarray(bricks)[:, None, None, None] + steps).astype(np.float32)
    values = np.where(np.abs(values) < 1e-3, np.float32(1e-3), values)
    return Distances(np.asarray(bricks, np.int32), values)


def _sides(faces):
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(sides, axis=0, return_counts=True)


def test_a_ball_over_many_blocks_is_closed_and_turned_outwards():
    """Truth: analytic. Radius 37.3 voxels, over the walls of all blocks, each vertex once."""
    middle = np.array([1.2, -3.4, 0.7])
    found = extract(_of_field(
        lambda p: np.linalg.norm(p - middle, axis=-1) - 37.3,
        list(product(range(-6, 6), repeat=3))))
    away = np.linalg.norm(found.vertices - middle, axis=1)
    np.testing.assert_allclose(away, 37.3, atol=5e-3)
    _, counts = _sides(found.faces)
    assert (counts == 2).all()
    assert len(found.vertices) - len(counts) + len(found.faces) == 2
    assert len(np.unique(np.round(found.vertices, 4), axis=0)) == len(found.vertices)
    volume = np.einsum('ij,ij->', found.vertices[found.faces[:, 0]], np.cross(
        found.vertices[found.faces[:, 1]], found.vertices[found.faces[:, 2]])) / 6
    assert volume == pytest.approx(4 / 3 * np.pi * 37.3**3, rel=2e-3)


def test_a_noisy_field_is_manifold_across_blocks():
    """Truth: Lewiner et al. 2003. No edge has more than two faces, and inner ones have two."""
    rng = np.random.default_rng(4)
    noise = rng.normal(size=(48, 48, 48))
    found = extract(_of_field(
        lambda p: noise[tuple(np.moveaxis(p, -1, 0))], list(product(range(2, 6), repeat=3))))
    sides, counts = _sides(found.faces)
    assert counts.max() == 2 and len(found.faces) > 50_000
    rim = found.vertices[sides[counts == 1]].mean(axis=1)
    assert ((rim < 17) | (rim > 46)).any(axis=1).all()


def test_unknown_corners_leave_a_hole_and_nothing_else():
    """Truth: analytic. A plane with a square of unknown voxels: all cubes but those around."""
    plane = _of_field(lambda p: p[..., 2] - 3.5, list(product(range(-5, 5), range(-5, 5), [0])))
    values = plane.values.copy()
    values[np.flatnonzero((plane.bricks == [0, 0, 0]).all(axis=1)), 2:5, 2:5] = np.nan
    found = extract(Distances(plane.bricks, values))
    area = np.linalg.norm(face_vectors(found.vertices, found.faces), axis=1).sum() / 2
    assert area == pytest.approx(79 * 79 - 16, abs=1e-6)
    assert (np.cross(*np.moveaxis(
        found.vertices[found.faces[:, 1:]] - found.vertices[found.faces[:, :1]], 1, 0)
    )[:, 2] > 0).all()


def test_no_surface_between_what_was_seen_through_and_what_is_behind():
    """Truth: analytic. A plane that ends in a step of four voxels: only the plane is left."""
    field = _of_field(
        lambda p: np.where(p[..., 0] < 4, p[..., 2] - 3.5, np.where(p[..., 2] < 4, -2.0, 2.0)),
        list(product((-1, 0), (-1, 0), [0])))
    found = extract(field, 3.4)
    assert found.vertices[:, 0].max() == 3.0 and len(extract(field).faces) > len(found.faces) > 0
    np.testing.assert_allclose(found.vertices[:, 2], 3.5)


def test_no_surface_at_all():
    for field in (lambda p: p[..., 0] * 0 + 1, lambda p: p[..., 0] * np.nan):
        found = extract(_of_field(field, [[0, 0, 0], [1, 0, 0]]))
        assert found.vertices.shape == (0, 3) and found.faces.shape == (0, 3)


def test_mistakes_are_named():
    mesh, _ = _views()
    with pytest.raises(ShapeError, match='origin'):
        Volume(np.zeros(2), 1.0, 2.0)
    with pytest.raises(ShapeError, match='voxel'):
        Volume(ORIGIN, 0.0, 2.0)
    volume = Volume(ORIGIN, 1.0, 2.0)
    with pytest.raises(ShapeError, match='vertices'):
        volume.touch(mesh.vertices[0], mesh.faces, longest=1.0, most=9)
    with pytest.raises(ShapeError, match='faces'):
        volume.touch(mesh.vertices, mesh.faces[:, :1], longest=1.0, most=9)
    with pytest.raises(ShapeError, match='numbers'):
        volume.touch(mesh.vertices[:5], mesh.faces, longest=1.0, most=9)
