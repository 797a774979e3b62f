# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What has not been seen, and where to look from.

Truth: analytic for balls; for rendered views the mesh that they were rendered from, of which
every candidate view is rendered too.
"""

from dataclasses import replace

import numpy as np
import pytest
from reference.bumpy import lattice
from reference.captures import model
from reference.posed import capture_from, posed, turntable
from ros_rops.core.config import Config
from ros_rops.modelling.closure import closed_surface, Closure
from ros_rops.modelling.coverage import coverage_of
from ros_rops.modelling.outlook import gains_of, sphere, suggestions
from ros_rops.modelling.posed import resolution_of
from ros_rops.modelling.products import SurfaceMesh
from ros_rops.modelling.turning import axis_of, ring_of
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

PRIOR = Config().prior


def of_triangles(vertices, faces, unseen, cell):
    tri = vertices[faces]
    cross = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return Closure(
        tri.mean(axis=1), cross / length[:, None], length / 2, unseen(tri.mean(axis=1)), 1, cell)


@pytest.fixture(scope='module')
def ball():
    normals = lattice(4000, Rotation.identity())
    return closed_surface(10.0 * normals + 3.0, normals, 1.0)


def test_a_ball_is_closed_outwards_and_of_its_size(ball):
    vertices, faces = ball
    radius = np.linalg.norm(vertices - 3.0, axis=1)
    assert abs(radius.mean() - 10.0) < 0.3 and radius.std() < 0.2
    tri = vertices[faces]
    assert np.einsum('ij,ij->', tri[:, 0], np.cross(tri[:, 1], tri[:, 2])) > 0
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def test_where_points_are_missing_it_closes():
    normals = lattice(4000, Rotation.identity())
    cap = normals[:, 2] < 0.7
    vertices, _ = closed_surface(10.0 * normals[cap], normals[cap], 1.0)
    top = vertices[np.hypot(vertices[:, 0], vertices[:, 1]) < 2.0]
    assert 6.0 < top[:, 2].max() < 11.0


@pytest.mark.parametrize('way', [(0, 0, 1), (0.6, 0, -0.8), (-1, 0, 0)])
def test_an_unseen_cap_is_looked_at_from_above_it(ball, way):
    closure = of_triangles(*ball, lambda at: (at - 3.0) @ np.array(way) > 8.5, 1.0)
    best = suggestions(closure)[0]
    assert np.dot(best.direction, way) > np.cos(np.radians(15))
    assert best.gain_share > 0.99
    assert gains_of(closure, -np.array([way], float))[0] == 0.0


def test_two_caps_take_two_directions(ball):
    closure = of_triangles(*ball, lambda at: np.abs(at[:, 2] - 3.0) > 8.0, 1.0)
    first, second = suggestions(closure)
    assert first.direction[2] * second.direction[2] < -0.9
    assert first.gain_share + second.gain_share > 0.98


def test_what_is_hidden_is_no_gain(ball):
    """A plate above the cap hides it from above: it must be looked at from the side."""
    cap = of_triangles(*ball, lambda at: at[:, 2] > 11.5, 1.0)
    x, y = np.meshgrid(np.arange(-8, 8.1, 0.5), np.arange(-8, 8.1, 0.5))
    plate = np.stack([x.ravel() + 3, y.ravel() + 3, np.full(x.size, 18.0)], axis=1)
    closure = Closure(
        np.concatenate([cap.centres, plate]),
        np.concatenate([cap.normals, np.tile([0.0, 0.0, 1.0], (len(plate), 1))]),
        np.concatenate([cap.areas, np.full(len(plate), 0.25)]),
        np.concatenate([cap.unseen, np.zeros(len(plate), bool)]), 1, 1.0)
    assert gains_of(cap, np.array([[0.0, 0.0, 1.0]]))[0] > 0.99
    assert gains_of(closure, np.array([[0.0, 0.0, 1.0]]))[0] == 0.0
    best = suggestions(closure)[0]
    assert best.gain_share > 0.5 and best.direction[2] < 0.8


def test_nothing_unseen_asks_for_nothing(ball):
    assert suggestions(of_triangles(*ball, lambda at: np.zeros(len(at), bool), 1.0)) == ()


class Truth:
    """The mesh that views were rendered from."""

    def __init__(self, name):
        self.thing = model(name)
        tri = self.thing.vertices[self.thing.faces]
        self.centres = tri.mean(axis=1)
        self.areas = np.linalg.norm(
            np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1) / 2

    def unseen(self, views):
        points = np.concatenate([one.points for one in views])
        distance, _ = cKDTree(points).query(self.centres)
        return distance > 1.5 * resolution_of(views)

    def left(self, unseen, direction):
        """Return the share of the unseen area that a view from there leaves."""
        points = posed([capture_from(self.thing, direction, 'x')])[0].points
        distance, _ = cKDTree(points).query(self.centres[unseen])
        areas = self.areas[unseen]
        return areas[distance > 1.5 * 0.0027].sum() / areas.sum()


@pytest.mark.parametrize(('name', 'gap'), [
    ('blob', (0.3, 0.5, 0.8)), ('bracket', (-0.2, 0.4, -0.9))])
def test_a_sector_left_out_is_where_to_look_from(name, gap):
    truth, gap = Truth(name), np.asarray(gap) / np.linalg.norm(gap)
    looks = sphere(24)
    looks = looks[looks @ gap < np.cos(np.radians(110))]
    views = posed([capture_from(truth.thing, one, f'v{k}') for k, one in enumerate(looks)])
    found = coverage_of(views, None, resolution_of(views), None)
    unseen = truth.unseen(views)
    assert 0.6 < found.unseen_share / (truth.areas[unseen].sum() / truth.areas.sum()) < 1.6
    best = found.directions[0]
    assert np.dot(best.direction, gap) > np.cos(np.radians(40))
    mine = 1.0 - truth.left(unseen, best.direction)
    most = max(1.0 - truth.left(unseen, one) for one in sphere(16))
    assert mine > 0.9 * most


TURNED = np.arange(0, 151, 30)


def test_a_turntable_is_told_by_the_poses():
    views = turntable('blob', TURNED)
    axis = axis_of(views, None, PRIOR, resolution_of(views))
    assert np.allclose(axis, [0, 0, 1], atol=1e-6)
    assert ring_of(views, axis, PRIOR.tilt_deg) == tuple(range(len(TURNED)))


def test_the_axis_has_the_sense_of_the_turns():
    resolution = resolution_of(turntable('blob', TURNED))
    for given in (None, np.array([0, 0, 2.0]), np.array([0, 0, -1.0])):
        assert axis_of(turntable('blob', TURNED), given, PRIOR, resolution)[2] > 0.99
        assert axis_of(turntable('blob', -TURNED), given, PRIOR, resolution)[2] < -0.99


@pytest.mark.parametrize('angles', [TURNED, -TURNED])
def test_the_next_angle_turns_on_into_the_missing_sector(angles):
    views = turntable('blob', angles)
    resolution = resolution_of(views)
    axis = axis_of(views, None, PRIOR, resolution)
    turn = coverage_of(views, None, resolution, axis).turn
    # Seen from 0 to 150 degrees on: the middle of the rest is 105 degrees ahead.
    assert 60.0 <= turn.angle_deg <= 150.0
    truth, way = Truth('blob'), 1.0 if angles[-1] > 0 else -1.0
    unseen = truth.unseen(views)
    after = [
        truth.areas[truth.unseen((*views, turntable('blob', [angles[-1] + way * step])[0]))].sum()
        for step in (turn.angle_deg, *np.arange(30, 331, 60))]
    total = truth.areas[unseen].sum()
    assert total - after[0] > 0.85 * (total - min(after[1:]))


def test_views_by_hand_have_no_axis():
    thing = model('blob')
    views = posed([capture_from(thing, one, f'v{k}') for k, one in enumerate(sphere(6))])
    assert axis_of(views, None, PRIOR, resolution_of(views)) is None
    assert axis_of(views[:1], None, PRIOR, 1.0) is None


def test_a_closed_model_tells_its_own_unseen_area():
    thing = model('blob')
    views = posed([capture_from(thing, one, f'v{k}') for k, one in enumerate(sphere(3))])
    faces = thing.faces
    filled = thing.vertices[faces].mean(axis=1)[:, 2] > 0.03
    surface = SurfaceMesh(
        thing.vertices, faces, np.zeros((len(thing.vertices), 3), np.float32), None, filled,
        {'closed': True})
    areas = Truth('blob').areas
    found = coverage_of(views, surface, resolution_of(views), None)
    assert found.area == pytest.approx(areas.sum())
    assert found.unseen_area == pytest.approx(areas[filled].sum())
    assert found.holes == 1
    assert found.directions
    whole = replace(surface, filled=np.zeros(len(faces), bool))
    nothing = coverage_of(views, whole, resolution_of(views), None)
    assert nothing.unseen_area == 0.0 and nothing.holes == 0 and nothing.directions == ()
    # One that is open says nothing of what is missing.
    bare = replace(surface, facts={'closed': False})
    open_one = coverage_of(views, bare, resolution_of(views), None)
    assert open_one.unseen_area != pytest.approx(areas[filled].sum())
