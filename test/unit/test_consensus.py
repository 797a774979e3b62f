# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The kernel of the assembled cloud. Truth: its NumPy twin; planes and spheres (analytic)."""

import numpy as np
import pytest
from reference import consensus_twin
from ros_rops.core.errors import ShapeError
from ros_rops.kernels.consensus import agree, dents, heaviest, piece_sizes, Reach, Samples, spread

REACH = Reach(1.5, 1.0, 1.0)


def sheets(offsets, noise=0.0, radius=None, seed=0, side=12.0):
    """Return samples of as many views of a plane or sphere as `offsets`, which lift each."""
    rng = np.random.default_rng(seed)
    points, normals, views = [], [], []
    for view, offset in enumerate(offsets):
        flat = rng.uniform(-side / 2, side / 2, (int(side * side * 1.3), 2))
        height = np.zeros(len(flat)) if radius is None else (
            np.sqrt(radius**2 - np.square(flat).sum(axis=1)))
        normal = np.column_stack([flat, height]) if radius else (
            np.tile([0, 0, 1.0], (len(flat), 1)))
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        lift = offset + rng.normal(0, noise, len(flat)) if noise else np.full(len(flat), offset)
        points.append(np.column_stack([flat, height]) + lift[:, None] * normal)
        normals.append(normal)
        views.append(np.full(len(flat), view, np.int32))
    count = sum(map(len, points))
    return Samples(
        np.concatenate(points), np.concatenate(normals).astype(np.float32),
        rng.uniform(0.2, 1.0, count).astype(np.float32), np.concatenate(views),
        rng.integers(0, 256, (count, 4), dtype=np.uint8), len(offsets))


def inner(samples, side=8.0):
    return np.flatnonzero(
        (np.abs(samples.points[:, :2]) < side / 2).all(axis=1)).astype(np.int32)


@pytest.mark.parametrize('move', [True, False])
def test_agrees_with_its_twin(move):
    samples = sheets([0.0, 0.3, -0.2], noise=0.2, radius=15.0)
    targets = np.arange(0, len(samples.points), 7, dtype=np.int32)
    got = agree(samples, targets, REACH, move=move)
    for row, target in enumerate(targets):
        want = consensus_twin.agree(samples, target, REACH, move=move)
        np.testing.assert_allclose(got.points[row], want[0], atol=2e-5)
        np.testing.assert_allclose(got.normals[row], want[1], atol=1e-4)
        np.testing.assert_allclose(got.weights[row], want[2], rtol=1e-3)
        np.testing.assert_allclose(got.colors[row], want[6], atol=1)
        assert (got.views[row], got.directions[row], got.support[row]) == want[3:6]


def test_sheets_apart_become_one_and_it_lies_between_them():
    samples = sheets([0.0, 0.5])
    got = agree(samples, inner(samples), REACH)
    assert np.ptp(samples.points[:, 2]) == 0.5
    assert np.std(got.points[:, 2]) < 0.25 / 2
    assert 0.2 < np.mean(got.points[:, 2]) < 0.3
    assert np.mean(got.directions == 2) > 0.95


def test_a_sphere_neither_shrinks_nor_swells():
    samples = sheets([0.0, 0.0], radius=15.0)
    got = agree(samples, inner(samples), REACH)
    # The mean of the neighbours lies 0.019 below: half their mean squared distance, 1.5**2 / 4,
    # over the radius.
    assert np.abs(np.linalg.norm(got.points, axis=1) - 15.0).max() < 0.002


def test_noise_is_averaged_and_normals_with_it():
    samples = sheets([0.0, 0.0, 0.0], noise=0.3, side=20.0)
    got = agree(samples, inner(samples), REACH)
    assert np.std(got.points[:, 2]) < 0.3 / 2
    assert np.median(np.degrees(np.arccos(got.normals[:, 2]))) < 12


def test_both_sides_of_a_thin_plate_stay():
    samples = sheets([0.0, -0.6])
    normals = samples.normals.copy()
    normals[samples.views == 1] *= -1
    samples = samples._replace(normals=normals)
    got = agree(samples, inner(samples), REACH)
    front = got.normals[:, 2] > 0
    assert np.abs(got.points[front, 2]).max() < 1e-5
    assert np.abs(got.points[~front, 2] + 0.6).max() < 1e-5
    assert len(spread(got.points, got.normals, np.arange(len(front), dtype=np.int32), 1.0)) > (
        1.6 * len(spread(got.points[front], got.normals[front],
                         np.arange(front.sum(), dtype=np.int32), 1.0)))


def test_any_number_of_threads_gives_the_same_bytes():
    samples = sheets([0.0, 0.3], noise=0.2, side=30.0)
    targets = np.arange(len(samples.points), dtype=np.int32)
    one, four = (agree(samples, targets, REACH, threads=threads) for threads in (1, 4))
    assert all(a.tobytes() == b.tobytes() for a, b in zip(one, four, strict=True))


def test_spread_chooses_as_its_twin():
    samples = sheets([0.0, 0.4], noise=0.3)
    order = np.random.default_rng(1).permutation(len(samples.points)).astype(np.int32)
    got = spread(samples.points, samples.normals, order, 0.7)
    want = consensus_twin.spread(samples.points, samples.normals, order, 0.7)
    np.testing.assert_array_equal(got, want)


def test_the_heaviest_of_each_cell_stays():
    points = np.array([[0, 0, 0], [0.2, 0, 0], [0.1, 0, 0], [5, 0, 0]], float)
    normals = np.array([[0, 0, 1], [0, 0, 1], [0, 0, -1], [0, 0, 1]], np.float32)
    weights = np.array([0.5, 0.9, 0.1, 0.1], np.float32)
    np.testing.assert_array_equal(heaviest(points, normals, weights, 1.0), [1, 2, 3])


def test_dents_agree_with_their_twin_and_pieces_are_counted():
    rng = np.random.default_rng(0)
    vertices, normals = rng.normal(size=(2, 9, 3))
    faces = np.array([[0, 1, 2], [1, 2, 3], [5, 6, 7]], np.int32)
    np.testing.assert_allclose(
        dents(vertices, faces, normals), consensus_twin.dents(vertices, faces, normals), atol=1e-6)
    np.testing.assert_array_equal(piece_sizes(faces, 9), [4, 4, 4, 4, 0, 3, 3, 3, 0])


@pytest.mark.parametrize(('change', 'text'), [
    ({'weights': np.ones(3, np.float32)}, 'weights'), ({'view_count': 1}, 'views'),
    ({'colors': np.zeros((3, 4), np.uint8)}, 'colors'),
    ({'normals': np.zeros((3, 3), np.float32)}, 'points, normals'),
])
def test_samples_that_do_not_fit_together_are_refused(change, text):
    samples = sheets([0.0, 0.1])._replace(**change)
    with pytest.raises(ShapeError, match=text):
        agree(samples, np.zeros(1, np.int32), REACH)


def test_numbers_out_of_range_are_refused():
    samples = sheets([0.0])
    count = len(samples.points)
    order = np.arange(count, dtype=np.int32)
    with pytest.raises(ShapeError, match='targets'):
        agree(samples, np.array([count], np.int32), REACH)
    with pytest.raises(ShapeError, match='reach'):
        agree(samples, order, Reach(0.0, 1.0, 1.0))
    with pytest.raises(ShapeError, match='spacing'):
        spread(samples.points, samples.normals, order, 0.0)
    with pytest.raises(ShapeError, match='order'):
        spread(samples.points, samples.normals, np.zeros_like(order), 1.0)
    with pytest.raises(ShapeError, match='side'):
        heaviest(samples.points, samples.normals, samples.weights, -1.0)
    with pytest.raises(ShapeError, match='weights'):
        heaviest(samples.points, samples.normals, samples.weights[1:], 1.0)
    with pytest.raises(ShapeError, match='faces'):
        dents(samples.points, np.array([[0, 1, count]], np.int32), samples.normals)
