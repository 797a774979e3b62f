# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces made presentable. Truth: analytic solids, and trimesh's word on the same faces."""

import math

import numpy as np
import pytest
from ros_rops.core.errors import ShapeError
from ros_rops.modelling.cleaning import cleaned, mesh_facts
from ros_rops.modelling.products import SurfaceMesh
from ros_rops.modelling.topology import vertex_normals
import trimesh

FINE = 0.01


def surface(mesh, normals=None):
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces, np.int32)
    normals = vertex_normals(vertices, faces) if normals is None else normals
    return SurfaceMesh(
        vertices, faces, normals.astype(np.float32), None, np.zeros(len(faces), bool))


def ball(radius=1.0, centre=(0.0, 0.0, 0.0), level=3):
    mesh = trimesh.creation.icosphere(level, radius)
    mesh.apply_translation(centre)
    return mesh


def joined(*meshes):
    return trimesh.util.concatenate(meshes)


def scrambled(mesh, share, seed=0):
    """Return the mesh with a share of its faces turned round."""
    turn = np.random.default_rng(seed).random(len(mesh.faces)) < share
    faces = np.where(turn[:, None], mesh.faces[:, ::-1], mesh.faces)
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def agree(result):
    """Check the facts against what trimesh says of the same faces."""
    other = trimesh.Trimesh(result.vertices, result.faces, process=False)
    assert other.is_winding_consistent == result.facts['oriented']
    assert other.is_watertight == result.facts['closed']
    assert len(other.split(only_watertight=False)) == result.facts['components']
    assert result.facts['area'] == pytest.approx(other.area)
    if result.facts['closed']:
        assert result.facts['volume'] == pytest.approx(other.volume)


def test_a_sound_ball_stays_as_it_is():
    mesh = ball()
    result = cleaned(surface(mesh), resolution=FINE)
    assert np.array_equal(result.faces, mesh.faces)
    assert result.facts['manifold'] and result.facts['floating_removed'] == 0
    agree(result)


@pytest.mark.parametrize('share', [0.0, 0.3, 0.8, 1.0])
def test_faces_turned_at_random_end_up_outwards(share):
    mesh = scrambled(ball(), share)
    result = cleaned(surface(mesh, np.zeros(mesh.vertices.shape)), resolution=FINE)
    assert result.facts['volume'] == pytest.approx(ball().volume)
    outward = np.einsum('ij,ij->i', result.normals, result.vertices)
    assert outward.min() > 0.99
    agree(result)


def test_an_open_piece_agrees_with_the_normals_towards_the_sensors():
    mesh = ball()
    half = mesh.submesh([np.flatnonzero(mesh.triangles_center[:, 2] > 0)], append=True)
    inwards = cleaned(
        surface(half, -vertex_normals(half.vertices, half.faces)), resolution=FINE)
    radial = np.einsum(
        'ij,ij->i', trimesh.Trimesh(inwards.vertices, inwards.faces, process=False).face_normals,
        inwards.vertices[inwards.faces].mean(axis=1))
    assert (radial < 0).all() and inwards.facts['holes'] == 1
    agree(inwards)


def test_faces_twice_and_without_extent_go():
    mesh = ball()
    faces = np.concatenate([mesh.faces, mesh.faces[:40], mesh.faces[:7, [1, 2, 0]], [[5, 5, 9]]])
    result = cleaned(
        surface(trimesh.Trimesh(mesh.vertices, faces, process=False)), resolution=FINE)
    assert len(result.faces) == len(mesh.faces) and result.facts['closed']


def test_an_edge_without_length_closes():
    mesh = trimesh.creation.icosphere(2)
    vertices = np.array(mesh.vertices)
    a, b = mesh.edges_unique[17]
    vertices[a] = vertices[b]
    result = cleaned(surface(trimesh.Trimesh(vertices, mesh.faces, process=False)),
                     resolution=FINE)
    assert len(result.faces) == len(mesh.faces) - 2
    agree(result)
    assert result.facts['closed'] and result.facts['manifold']


def two_cubes(shift):
    """Two unit cubes that share an edge (shift 1 1 0) or a vertex (1 1 1), merged there."""
    one = trimesh.creation.box((1, 1, 1))
    other = one.copy()
    other.apply_translation(shift)
    both = joined(one, other)
    both.merge_vertices()
    return both


@pytest.mark.parametrize(('shift', 'crowded', 'added'), [
    ((1, 1, 0), 1, 2), ((1, 1, 1), 0, 1)])
def test_solids_that_touch_are_taken_apart(shift, crowded, added):
    both = two_cubes(shift)
    assert not mesh_facts(both.vertices, np.array(both.faces, np.int32))['manifold']
    result = cleaned(surface(both), resolution=FINE)
    assert result.facts['crowded_edges'] == crowded
    assert result.facts['split_vertices'] == added
    assert result.facts['components'] == 2 and result.facts['manifold']
    assert result.facts['volume'] == pytest.approx(2.0)
    agree(result)


def test_a_ring_of_blocks_that_touches_itself_becomes_manifold():
    """Voxels that meet in an edge whose ends hang together all around."""
    filled = np.ones((3, 3, 2), bool)
    filled[1, 1, 1] = filled[2, 2, 1] = False
    filled[0, 0, 0] = False
    blocks = trimesh.voxel.VoxelGrid(filled).as_boxes()
    blocks.merge_vertices()
    centres = np.round(blocks.triangles_center, 6)
    _, first, count = np.unique(centres, axis=0, return_index=True, return_counts=True)
    outer = trimesh.Trimesh(blocks.vertices, blocks.faces[first[count == 1]], process=False)
    result = cleaned(surface(outer), resolution=FINE)
    assert result.facts['crowded_edges'] > 0
    assert result.facts['manifold'] and result.facts['closed']
    assert result.facts['volume'] == pytest.approx(filled.sum())
    agree(result)


def test_a_fin_on_a_solid_is_cut_off_at_its_edge():
    box = trimesh.creation.box((1, 1, 1))
    a, b = box.edges_unique[0]
    vertices = np.concatenate([box.vertices, box.vertices[[a, b]].mean(axis=0)[None] * 2])
    faces = np.concatenate([box.faces, [[a, b, len(vertices) - 1]]])
    result = cleaned(surface(trimesh.Trimesh(vertices, faces, process=False)), resolution=FINE)
    assert result.facts['crowded_edges'] == 1 and result.facts['floating_removed'] == 1
    assert result.facts['volume'] == pytest.approx(1.0)
    agree(result)


def test_a_moebius_strip_is_cut_once():
    turns = np.linspace(0, 2 * math.pi, 60, endpoint=False)
    width = np.array([-0.3, 0.3])
    t, w = np.meshgrid(turns, width, indexing='ij')
    radius = 1 + w * np.cos(t / 2)
    vertices = np.stack([radius * np.cos(t), radius * np.sin(t), w * np.sin(t / 2)], -1)
    k = np.arange(60)
    here, there = 2 * k, 2 * ((k + 1) % 60)
    last = k == 59
    low, high = np.where(last, there + 1, there), np.where(last, there, there + 1)
    faces = np.concatenate([
        np.stack([here, low, here + 1], 1), np.stack([here + 1, low, high], 1)])
    result = cleaned(
        surface(trimesh.Trimesh(vertices.reshape(-1, 3), faces, process=False)), resolution=FINE)
    assert result.facts['oriented'] and result.facts['manifold']
    assert len(result.faces) == len(faces) and result.facts['boundary_edges'] > 120
    agree(result)


def test_specks_and_slivers_go_and_parts_stay():
    speck = ball(0.02, (3, 0, 0), 1)
    patch = ball(1.0, (0, 5, 0))
    patch = patch.submesh(
        [np.flatnonzero(patch.triangles_center[:, 2] > 0.97)], append=True)
    n = 80
    strip = trimesh.Trimesh(
        np.concatenate([np.stack([np.arange(n) * 0.05, np.full(n, y), np.full(n, 4.0)], 1)
                        for y in (0.0, 0.04)]),
        np.concatenate([np.stack([np.arange(n - 1), np.arange(1, n), np.arange(n, 2 * n - 1)], 1),
                        np.stack([np.arange(1, n), np.arange(n + 1, 2 * n),
                                  np.arange(n, 2 * n - 1)], 1)]), process=False)
    far = ball(0.3, (0, 0, 9))
    scene = joined(ball(), speck, patch, strip, far)
    result = cleaned(surface(scene), resolution=0.03)
    assert result.facts['floating_removed'] == 2
    assert result.facts['components'] == 3
    expected = (speck.area + strip.area) / scene.area
    assert result.facts['floating_share'] == pytest.approx(expected)
    agree(result)


def test_the_wall_of_a_hollow_goes_and_an_inverted_solid_is_turned():
    hollow = ball(0.5)
    hollow.invert()
    result = cleaned(surface(joined(ball(), hollow, ball(0.3, (4, 0, 0)))), resolution=FINE)
    assert result.facts['hidden_removed'] == 1 and result.facts['components'] == 2
    inside_out = joined(ball(), ball(0.3, (4, 0, 0)))
    inside_out.invert()
    turned = cleaned(surface(inside_out), resolution=FINE)
    assert turned.facts['volume'] > 0


def test_what_lies_in_a_closed_piece_goes():
    inner = ball(0.5)
    sheet = inner.submesh([np.flatnonzero(inner.triangles_center[:, 0] > 0)], append=True)
    result = cleaned(surface(joined(ball(), sheet)), resolution=FINE)
    assert result.facts['hidden_removed'] == 1 and result.facts['closed']


def test_colours_and_marks_stay_with_their_faces():
    mesh = joined(ball(), ball(0.02, (3, 0, 0), 1))
    colours = (np.abs(mesh.vertices) * 50).astype(np.uint8)
    marks = mesh.triangles_center[:, 2] > 0.5
    given = surface(mesh)
    result = cleaned(SurfaceMesh(
        given.vertices, given.faces, given.normals, colours, marks), resolution=FINE)
    assert np.array_equal(result.colors, (np.abs(result.vertices) * 50).astype(np.uint8))
    centres = result.vertices[result.faces].mean(axis=1)
    assert np.array_equal(result.filled, centres[:, 2] > 0.5)


def test_nothing_in_nothing_out():
    empty = SurfaceMesh(
        np.zeros((0, 3)), np.zeros((0, 3), np.int32), np.zeros((0, 3), np.float32), None,
        np.zeros(0, bool))
    result = cleaned(empty, resolution=FINE)
    assert result.facts['components'] == 0 and not result.facts['closed']


@pytest.mark.parametrize(('vertices', 'faces', 'resolution'), [
    ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], 1.0),
    ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], 1.0),
    ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], 0.0),
])
def test_what_is_no_mesh_is_refused(vertices, faces, resolution):
    with pytest.raises(ShapeError):
        cleaned(SurfaceMesh(
            np.array(vertices, float), np.array(faces, np.int32), np.zeros((3, 3), np.float32),
            None, np.zeros(1, bool)), resolution=resolution)
