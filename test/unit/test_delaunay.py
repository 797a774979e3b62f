# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Plane triangulation; truth: Qhull where it is unique, empty circles and area elsewhere."""

import numpy as np
import pytest
from ros_rops.core.errors import ShapeError
from ros_rops.kernels.mesh import delaunay_triangles
from scipy.spatial import ConvexHull, Delaunay


def as_set(triangles):
    return {tuple(sorted(triangle)) for triangle in triangles.tolist()}


def doubled_areas(uv, triangles):
    a, b, c = (uv[triangles[:, k]] for k in range(3))
    return np.cross(np.c_[b - a, 0 * a[:, 0]], np.c_[c - a, 0 * a[:, 0]])[:, 2]


@pytest.mark.parametrize('count', [3, 4, 10, 300, 3000])
@pytest.mark.parametrize('spread', [1.0, 1e-6, 1e9])
def test_equals_qhull_on_random_points(count, spread):
    uv = np.random.default_rng(count).normal(size=(count, 2)) * spread
    triangles = delaunay_triangles(uv)
    assert as_set(triangles) == as_set(Delaunay(uv).simplices)
    assert doubled_areas(uv, triangles).min() > 0


@pytest.mark.parametrize('shape', [(2, 2), (2, 40), (31, 17), (60, 60)])
def test_lattices_are_covered_with_empty_circles(shape):
    uv = np.stack(np.mgrid[0:shape[0], 0:shape[1]], axis=-1).reshape(-1, 2).astype(float)
    triangles = delaunay_triangles(uv)
    assert len(triangles) == 2 * (shape[0] - 1) * (shape[1] - 1)
    # Half a square each: the only triangles of a lattice whose circle is empty.
    assert np.allclose(doubled_areas(uv, triangles), 1)
    assert np.ptp(uv[triangles], axis=1).max() == 1


def test_hulls_are_covered_whatever_the_order_and_density():
    random = np.random.default_rng(2)
    ring = np.exp(2j * np.pi * random.random(500)) * (1 + 1e-4 * random.random(500))
    clump = random.normal(size=(500, 2)) * 1e-5 + [0.9, 0.1]
    line = np.c_[np.linspace(-1, 1, 300), np.zeros(300)]
    uv = np.concatenate([np.c_[ring.real, ring.imag], clump, line])
    for order in (np.arange(len(uv)), random.permutation(len(uv))):
        triangles = delaunay_triangles(uv[order])
        areas = doubled_areas(uv[order], triangles)
        assert areas.sum() / 2 == pytest.approx(ConvexHull(uv).volume, rel=1e-7)
        assert len(np.unique(triangles)) == len(uv)


def test_points_on_a_circle():
    angle = np.arange(64) * np.pi / 32
    uv = np.c_[np.cos(angle), np.sin(angle)]
    assert len(delaunay_triangles(uv)) == 62


def test_a_line_first_and_then_the_plane():
    uv = np.r_[np.c_[np.arange(-5.0, 6), np.zeros(11)], [[0.0, 90.0], [3.0, -80.0]]]
    assert as_set(delaunay_triangles(uv)) == as_set(Delaunay(uv).simplices)


def test_coinciding_points_count_once():
    uv = np.random.default_rng(3).normal(size=(200, 2))
    triangles = delaunay_triangles(np.tile(uv, (3, 1)))
    assert triangles.max() < 200
    assert as_set(triangles) == as_set(Delaunay(uv).simplices)


@pytest.mark.parametrize('uv', [
    np.zeros((0, 2)), np.zeros((1, 2)), np.zeros((9, 2)), np.eye(2),
    np.arange(40.0)[:, None] * [1, -1],
])
def test_nothing_comes_of_a_line(uv):
    assert delaunay_triangles(uv).shape == (0, 3)


@pytest.mark.parametrize('uv', [np.zeros((4, 3)), np.zeros(4), np.full((4, 2), np.nan)])
def test_wrong_arrays_are_refused(uv):
    with pytest.raises(ShapeError, match='uv'):
        delaunay_triangles(uv)
