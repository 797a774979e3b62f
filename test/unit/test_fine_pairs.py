# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Which views are matched, and steps over many; truth: analytic poses, elimination, counts."""

import dataclasses

import numpy as np
import pytest
from reference import bumpy
from ros_rops.core import block_system
from ros_rops.core.config import FineConfig
from ros_rops.core.fine import refine_shape
from ros_rops.core.fine_pairs import pairs_to_match
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

PARTNERS = 16


def patches(middles, count=200, seed=0):
    """Sample a ball of radius 1, each view those within 60 degrees of its direction."""
    rng = np.random.default_rng(seed)
    points = []
    for middle in middles:
        around = rng.normal(size=(8 * count, 3))
        around /= np.linalg.norm(around, axis=1)[:, None]
        points.append(around[around @ middle > 0.5])
    return points


def directions(count, seed=0):
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1)[:, None]


def test_few_views_are_all_matched():
    points = patches(directions(PARTNERS + 1))
    pairs = pairs_to_match(points, points, 0.5, PARTNERS)
    assert pairs.tolist() == [[i, j] for i in range(17) for j in range(17) if i != j]


@pytest.mark.parametrize('count', [18, 60, 150])
def test_many_views_have_about_as_many_partners_and_stay_connected(count):
    points = patches(directions(count))
    pairs = pairs_to_match(points, points, 0.5, PARTNERS)
    assert len(np.unique(pairs, axis=0)) == len(pairs) <= (PARTNERS + 2) * count
    assert {(i, j) for i, j in pairs} == {(j, i) for i, j in pairs}
    assert np.bincount(pairs[:, 0], minlength=count).min() >= PARTNERS // 4
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    assert connected_components(graph)[0] == 1


def test_what_does_not_overlap_is_not_matched():
    middles = directions(30)
    points = patches(middles)
    far = [p + (9.0 if k >= 15 else 0.0) for k, p in enumerate(points)]
    pairs = pairs_to_match(far, points, 0.5, PARTNERS)
    assert ((pairs < 15).sum(axis=1) != 1).all()
    back = [-p for p in points]
    sides = [p if k < 15 else b for k, (p, b) in enumerate(zip(points, back, strict=True))]
    assert ((pairs_to_match(points, sides, 0.5, PARTNERS) < 15).sum(axis=1) != 1).all()


def test_two_groups_joined_by_one_view_stay_connected():
    middles = np.array([[0.0, 0.0, 1.0]] * 25 + [[1.0, 0.0, 0.0]] + [[0.0, 0.0, -1.0]] * 25)
    points = patches(middles)
    pairs = pairs_to_match(points, points, 0.5, PARTNERS)
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(51, 51))
    assert connected_components(graph)[0] == 1


def test_conjugate_gradients_find_what_elimination_finds():
    rng, count = np.random.default_rng(3), 40
    blocks = np.zeros((count, count, 6, 6))
    for i in range(count):
        blocks[i, i] += 1e-5 * np.eye(6)
        for j in {(i + 1) % count, int(rng.integers(count))} - {i}:
            rows = rng.normal(size=(8, 6))
            for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                blocks[a, b] += sign * rows.T @ rows
    right = rng.normal(size=(count, 6))
    dense = blocks.transpose(0, 2, 1, 3).reshape(6 * count, 6 * count)
    truth = np.linalg.solve(dense, right.reshape(-1)).reshape(count, 6)
    few = block_system.FEW
    assert few < count
    found = block_system.solve_blocks(blocks.copy(), right.copy())
    assert np.abs(found - truth).max() < 1e-7 * np.abs(truth).max()
    nothing = block_system.solve_blocks(blocks.copy(), np.zeros((count, 6)))
    assert not nothing.any()


def test_few_partners_hold_as_well_as_all():
    turns = np.arange(24) * np.pi / 12
    around = [[np.cos(a), np.sin(a), 0.4 * (-1) ** k] for k, a in enumerate(turns)]
    views, truth, resolution = bumpy.views_of(around, count=6000)
    start = bumpy.disturbed(views, truth, resolution)
    worst = []
    for partners in (8, 100):
        config = dataclasses.replace(FineConfig(), partners=partners)
        result = refine_shape(views, start, resolution, config, threads=2)
        again = refine_shape(views, start, resolution, config, threads=1)
        assert np.array_equal(result.poses, again.poses)
        assert result.converged and {view.component for view in result.views} == {0}
        worst.append(max(bumpy.errors(views, result.poses, truth, resolution)[0]))
    assert worst[0] < max(2.0 * worst[1], 0.05)
