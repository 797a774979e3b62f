# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The motion held least. Truth: analytic; which motions a plane, a ball, a tube leave free."""

import numpy as np
import pytest
from reference.bumpy import lattice
from ros_rops.modelling.constraint import least_constrained
from scipy.spatial.transform import Rotation

LEAST = 0.003
MIDDLE = np.array([4.0, -2.0, 7.0])


def plane(rng):
    points = np.concatenate([rng.uniform(-5, 5, (2000, 2)), np.zeros((2000, 1))], axis=1)
    return points, np.tile([0.0, 0.0, 1.0], (2000, 1))


def ball(rng):
    normals = lattice(2000, Rotation.identity())
    return 3.0 * normals, normals


def tube(rng):
    angle, height = rng.uniform(0, 2 * np.pi, 2000), rng.uniform(-9, 9, 2000)
    normals = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return 2.0 * normals + np.outer(height, [0, 0, 1]), normals


def cone(rng):
    """Return a body of revolution: only the turn about its axis is free."""
    points, normals = tube(rng)
    slope = 1.0 - 0.08 * points[:, 2:]
    points = points * np.concatenate([slope, slope, np.ones_like(slope)], axis=1)
    normals = normals + np.array([0.0, 0.0, 0.16])
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def thread(rng, advance=3.0):
    """Return a helicoid: rotation by an angle and a shift along the axis in proportion."""
    angle, radius = rng.uniform(0, 12, 2000), rng.uniform(0.5, 8, 2000)
    c, s = np.cos(angle), np.sin(angle)
    points = np.stack([radius * c, radius * s, advance * angle], axis=1)
    normals = np.stack([advance * s, -advance * c, radius], axis=1)
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def judged(surface, rotation, units='unknown'):
    points, normals = surface(np.random.default_rng(0))
    points, normals = rotation.apply(points), rotation.apply(normals)
    points = points - points.mean(axis=0)
    size = np.sqrt((points ** 2).sum(axis=1).mean())
    rows = np.concatenate([np.cross(points, normals) / size, normals], axis=1)
    values, motions = np.linalg.eigh(rows.T @ rows / len(rows))
    return least_constrained(np.maximum(values, 0.0), motions, MIDDLE, size, LEAST, units)


TURNED = Rotation.from_rotvec([0.3, -0.7, 1.1])


@pytest.mark.parametrize(('surface', 'kind', 'count'), [
    (plane, 'translation', 3), (ball, 'rotation', 3), (tube, 'translation', 2),
    (cone, 'rotation', 1), (thread, 'screw', 1)])
def test_kind_and_number_of_free_motions(surface, kind, count):
    found = judged(surface, TURNED)
    assert found.kind == kind
    assert not found.held and found.stiffness < 1e-3
    assert 'hardly held' in found.text
    assert (f'one of {count} motions' in found.text) == (count > 1)


@pytest.mark.parametrize('surface', [tube, cone, thread])
def test_direction_is_that_of_the_axis(surface):
    found = judged(surface, TURNED)
    assert abs(np.dot(found.direction, TURNED.apply([0, 0, 1]))) > 0.999


def test_a_plane_slides_within_itself():
    found = judged(plane, TURNED)
    assert abs(np.dot(found.direction, TURNED.apply([0, 0, 1]))) < 1e-3


def test_the_axis_of_a_ball_passes_through_its_middle():
    found = judged(ball, TURNED)
    assert np.linalg.norm(np.asarray(found.point) - MIDDLE) < 0.1
    assert 'through its middle' in found.text


def test_a_screw_says_how_far_a_turn_takes_it():
    # 3 units a radian; metres are told as millimetres, as all reports have them.
    for units, factor, name in (('m', 1000.0, 'mm'), ('mm', 1.0, 'mm'), ('unknown', 1.0, 'units')):
        text = judged(thread, TURNED, units).text
        assert f'screws ({2 * np.pi * 3.0 * factor:.3g} {name} a turn)' in text


def test_a_place_says_its_unit():
    # The axis of a cone whose points are not about it alike passes by their middle.
    def half(rng):
        points, normals = cone(rng)
        return points[points[:, 0] > 0], normals[points[:, 0] > 0]

    found = judged(half, TURNED, 'm')
    said = found.text.partition('through (')[2].partition(') mm')[0]
    np.testing.assert_allclose(
        [float(value) for value in said.split(',')], 1000.0 * np.array(found.point), atol=10.0)


def test_a_body_without_symmetry_is_held():
    def bumpy(rng):
        points, normals = ball(rng)
        points = points * [1.0, 1.6, 2.4]
        normals = normals / [1.0, 1.6, 2.4]
        return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)

    found = judged(bumpy, TURNED)
    assert found.held and found.stiffness > 0.02
    assert 'hardly' not in found.text


def test_nothing_matched_is_nothing_known():
    assert least_constrained(np.zeros(6), np.eye(6), MIDDLE, 1.0, LEAST) is None
