# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops bench model`. Truth: analytic (shapes known exactly, poses moved by known amounts)."""

from dataclasses import replace
import json

import numpy as np
import pytest
from reference.bench_sets import random_pose
from ros_rops.bench import model
from ros_rops.bench.__main__ import main
from ros_rops.bench.model import measure, model_table, raw, reached
from ros_rops.bench.model_cases import EXACT, LIMITS, shape_case
from ros_rops.bench.model_distance import Triangles
from ros_rops.bench.model_frames import aligned_poses, settled
from ros_rops.bench.model_peers import drawn, PEERS
from ros_rops.bench.model_run import Made, made, Maker, ModelJob, nothing
from ros_rops.bench.model_score import cloud_accuracy, judge_surface, surface_facts
from ros_rops.bench.model_shapes import cup, dres_of, knot, read_shape, scan, Scanner
from ros_rops.core.errors import InputError, ModelError
from ros_rops.core.se3 import move
from ros_rops.modelling.products import SurfaceMesh
from scipy.spatial.transform import Rotation

SMALL = Scanner(pixels=60)


def surface(vertices, faces):
    return SurfaceMesh(
        np.asarray(vertices), faces, np.zeros((len(vertices), 3), np.float32), None,
        np.zeros(len(faces), bool))


@pytest.fixture(scope='module')
def case():
    return shape_case('thin:knot', SMALL)


@pytest.mark.parametrize('make', [cup, knot])
def test_thin_shapes_are_closed_and_right_side_out(make):
    vertices, faces = make()
    facts = surface_facts(surface(vertices, faces))
    assert facts['closed'] and facts['components'] == 1
    assert facts['branching_edges'] == facts['turned_edges'] == 0
    corners = vertices[faces]
    volume = np.einsum('nd,nd->n', corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume > 0


def test_the_cup_holds_as_much_material_as_its_walls():
    vertices, faces = cup()
    corners = vertices[faces]
    volume = np.einsum('nd,nd->n', corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    r, h, w = 0.04, 0.08, 0.002
    expected = np.pi * r * r * h - np.pi * (r - w) ** 2 * (h - w)  # and the round rim
    assert volume == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize('sight', ['pinhole', 'orthographic'])
def test_scans_lie_on_the_shape_from_both_kinds_of_sensor(sight):
    shape = read_shape('thin:knot')
    reference = Triangles(shape.vertices, shape.faces)
    views = scan(shape, replace(SMALL, sight=sight))
    assert len(views) == 26
    assert cloud_accuracy(views, reference, 1.0) < 1e-9
    for view, T in views:
        # The sensor is on the outer side of what it saw.
        closest = reference.closest(move(T, view.points))
        to_sensor = view.sensor.to_sensor(view.points) @ T[:3, :3].T
        assert (np.einsum('nd,nd->n', reference.normals[closest.face], to_sensor) > -1e-6).mean() \
            > 0.99


def test_noise_runs_along_the_ray_and_has_its_strength():
    shape = read_shape('thin:cup')
    for sight in ('pinhole', 'orthographic'):
        clean = scan(shape, replace(SMALL, sight=sight))[0][0]
        noisy = scan(shape, replace(SMALL, sight=sight, noise_mr=0.5))[0][0]
        step = noisy.points - clean.points
        along = np.einsum('nd,nd->n', step, clean.sensor.to_sensor(clean.points))
        np.testing.assert_allclose(np.linalg.norm(step, axis=1), np.abs(along), atol=1e-12)
        sigma = 0.5 * dres_of([(clean, np.eye(4))])
        assert np.std(along) == pytest.approx(sigma, rel=0.15)


def test_an_unorganized_scan_has_no_grid():
    views = scan(read_shape('thin:knot'), replace(SMALL, organized=False))
    assert all(view.grid is None for view, _ in views)


def test_an_unknown_shape_is_the_callers_mistake():
    with pytest.raises(InputError, match='thin:cup'):
        read_shape('thin:ice')


def test_poses_are_carried_to_the_reference_as_a_whole():
    rng = np.random.default_rng(1)
    reference = {name: random_pose(rng) for name in 'abcd'}
    frame = random_pose(rng)
    found = aligned_poses(
        {name: frame @ T for name, T in reference.items()}, reference,
        dict.fromkeys(reference, np.zeros(3)), 1.0)
    for name, T in reference.items():
        np.testing.assert_allclose(found[name], T, atol=1e-9)


def test_a_model_moved_settles_back():
    vertices, faces = knot()
    reference = Triangles(vertices, faces)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec([0.0, 0.01, 0.005]).as_matrix()
    T[:3, 3] = 0.0005, -0.0003, 0.0004
    found = settled(move(T, vertices), faces, reference, dres=0.001)
    np.testing.assert_allclose(found @ T, np.eye(4), atol=1e-6)


def test_a_body_of_revolution_is_not_turned_about_its_axis():
    vertices, faces = cup()
    T = np.eye(4)
    T[:3, 3] = 0.0003, -0.0002, 0.0004
    found = settled(move(T, vertices), faces, Triangles(vertices, faces), dres=0.001)
    np.testing.assert_allclose(found @ T, np.eye(4), atol=1e-4)


def test_what_is_reached_looks_at_both_numbers():
    vertices, faces = knot()
    one = judge_surface(
        surface(vertices, faces), Triangles(vertices, faces), np.eye(4), 1.0, samples=100)
    limits = LIMITS['bunny']

    def told(accuracy, share):
        return reached(replace(one, accuracy=accuracy, completeness=share), limits)

    assert (told(0.3, 1.0), told(0.6, 1.0), told(0.8, 1.0)) == ('aim', 'must', 'neither')
    assert (told(0.3, 0.996), told(0.3, 0.9)) == ('must', 'neither')
    assert reached(one, None) is None
    # Over what was seen, where that is what counts.
    assert reached(replace(one, completeness=0.5, completeness_seen=1.0), EXACT) == 'aim'


def test_a_perfect_surface_has_perfect_numbers(case, monkeypatch):
    exact = surface(case.reference.vertices, case.reference.faces)
    monkeypatch.setattr(model, 'made_apart', lambda maker, job: Made(exact, (3.0, 1.0, 2.0)))
    found = measure(case, Maker('perfect', nothing, nothing), ModelJob(case.views, case.dres),
                    samples=2000)
    assert found['reached'] == 'aim' and found['seconds_warm'] == 1.5
    assert found['score']['worst'] < 1e-6 and found['fit'] < 1e-6
    assert found['counted']['closed'] and found['seen_share'] == found['score']['seen_share']
    points = raw(case)
    assert points['score']['accuracy'] < 1e-6 and points['score']['completeness'] > 0.99
    text = model_table([points, found])
    assert 'perfect' in text and 'aim' in text and '100.00%' in text


def test_a_maker_that_fails_is_a_line_not_the_end(case):
    def fail(job, prepared):
        raise ModelError('no surface comes')

    def crash(job, prepared):
        raise KeyError('x')

    job = ModelJob(case.views, case.dres)
    assert made(Maker('m', nothing, fail), job).error == 'no surface comes'
    assert made(Maker('m', nothing, crash), job).error == "KeyError: 'x'"


@pytest.mark.parametrize('sight', ['pinhole', 'orthographic'])
def test_depth_images_for_peers_show_the_view(sight):
    shape = read_shape('thin:cup')
    pairs = tuple(scan(shape, replace(SMALL, sight=sight)))[2:3]
    job = ModelJob(pairs, dres_of(pairs))
    image = drawn(job.posed()[0], job.dres)
    hit = image.depth > 0
    local = image.depth[hit][:, None] * image.camera.rays()[hit]
    points = move(np.linalg.inv(image.T_camera_world), local)
    reference = Triangles(shape.vertices, shape.faces)
    # Pixels lie on the view's triangles, which cut corners of the shape.
    assert np.quantile(reference.closest(points).distance, 0.9) < 0.3 * job.dres
    assert hit.sum() > 1.2 * len(pairs[0][0].points)


def test_open3d_makes_a_surface_of_the_views(case):
    pytest.importorskip('open3d')
    found = made(PEERS['open3d tsdf'], ModelJob(case.views, case.dres))
    assert found.error == ''
    score = judge_surface(found.surface, case.reference, np.eye(4), case.dres, samples=5000)
    assert score.completeness > 0.9 and score.median < 1


def test_the_case_runs_from_the_command_line(tmp_path, capsys, monkeypatch):
    vertices, faces = knot()
    exact = Made(surface(vertices, faces), (0.1,), 10.0, 20.0)
    monkeypatch.setattr(model, 'made_apart', lambda maker, job: exact)
    file, maps = tmp_path / 'out.json', tmp_path / 'maps'
    assert main(['model', 'thin:knot', '--pixels', '40', '--noise', '0', '--json', str(file),
                 '--samples', '500', '--maps', str(maps)]) == 0
    points, found = json.loads(file.read_text())['cases']
    assert (points['by'], found['by']) == ('points as they are', 'volume')
    assert found['limits']['accuracy_must'] == 0.5 and found['reached'] == 'aim'
    assert len(list(maps.glob('*.png'))) == 1
    assert '| knot: pinhole' in capsys.readouterr().out


@pytest.mark.parametrize(('words', 'said'), [
    (['--reference', 'x'], 'SET=MESH'), (['--noise', '-1'], '--noise'),
    (['--pixels', '1'], '--pixels'), (['--samples', '1'], '--samples')])
def test_what_makes_no_sense_is_the_callers_mistake(words, said, capsys):
    assert main(['model', 'thin:knot', *words]) == 2
    assert said in capsys.readouterr().err
