# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Loop closure. Truth: exact poses, known motions of single edges, and graphs counted by hand."""

import itertools

import numpy as np
import pytest
from reference.posed import around, turntable, wronged
from ros_rops.core.config import Config
from ros_rops.core.fine_types import EdgeFit
from ros_rops.core.se3 import move, rigid
from ros_rops.modelling.joint import Joint
from ros_rops.modelling.loops import close, cycle_basis, loops_of, measure_edges
from ros_rops.modelling.posed import resolution_of
from scipy.spatial.transform import Rotation


def graph(*pairs):
    return [EdgeFit(i, j, 100 - k, 0.5, 0.1) for k, (i, j) in enumerate(pairs)]


def joint_of(views):
    return Joint.of(views, resolution_of(views), Config().fine)


def turned(degrees, axis, shift):
    return rigid(
        Rotation.from_rotvec(np.radians(degrees) * np.asarray(axis, float)).as_matrix(),
        np.asarray(shift, float))


def test_poses_that_agree_close():
    edges = {pair: np.eye(4) for pair in itertools.combinations(range(4), 2)}
    loop = close((2, 0, 3, 1), edges, np.ones(3))
    assert loop.rotation_deg == pytest.approx(0.0) and loop.translation == pytest.approx(0.0)


@pytest.mark.parametrize('cycle', [(0, 1, 2, 3), (3, 2, 1, 0), (1, 2, 3, 0)])
def test_one_wrong_edge_is_what_a_loop_is_off_by(cycle):
    middle = np.array([5.0, 0.0, 0.0])
    wrong = turned(2.0, [0, 0, 1], [0.1, 0.0, 0.3])
    edges = {pair: np.eye(4) for pair in [(0, 1), (1, 2), (2, 3), (0, 3)]}
    edges[1, 2] = wrong
    loop = close(cycle, edges, middle)
    assert loop.rotation_deg == pytest.approx(2.0)
    sense = wrong if cycle != (3, 2, 1, 0) else np.linalg.inv(wrong)
    assert loop.translation == pytest.approx(np.linalg.norm(move(sense, middle[None]) - middle))


def test_a_loop_is_the_product_of_relative_poses():
    """Composed from view to view by T_next_view, brought back into the object's frame."""
    rng = np.random.default_rng(4)
    poses = [rigid(Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)) for _ in range(4)]
    cycle, edges, total = (1, 3, 0, 2), {}, np.eye(4)
    for a, b in zip(cycle, (*cycle[1:], cycle[0]), strict=True):
        motion = turned(20.0, rng.normal(size=3), rng.normal(size=3))
        edges[min(a, b), max(a, b)] = motion if a < b else np.linalg.inv(motion)
        total = np.linalg.inv(poses[b]) @ motion @ poses[a] @ total
    back = poses[1] @ total @ np.linalg.inv(poses[1])
    middle = np.array([1.0, 2.0, 3.0])
    loop = close(cycle, edges, middle)
    assert loop.translation == pytest.approx(np.linalg.norm(move(back, middle[None]) - middle))
    angle = Rotation.from_matrix(back[:3, :3]).magnitude()
    assert loop.rotation_deg == pytest.approx(np.degrees(angle))


def test_errors_that_cancel_do_not_show():
    step = turned(1.0, [0, 1, 0], [0.2, 0.0, 0.0])
    edges = {(0, 1): step, (1, 2): np.linalg.inv(step), (0, 2): np.eye(4)}
    assert close((0, 1, 2), edges, np.zeros(3)).rotation_deg == pytest.approx(0.0, abs=1e-6)


def test_a_basis_has_an_edge_more_than_a_tree_for_each_loop():
    pairs = [(0, 1), (1, 2), (0, 2), (2, 3), (0, 3), (4, 5)]
    cycles = cycle_basis(7, graph(*pairs))
    assert len(cycles) == len(pairs) - (7 - 3)  # three groups: 0-3, 4-5, 6
    known = set(pairs)
    for cycle in cycles:
        steps = zip(cycle, (*cycle[1:], cycle[0]), strict=True)
        assert all((min(step), max(step)) in known for step in steps)
        assert len(set(cycle)) == len(cycle) >= 3


def test_a_tree_has_no_loop():
    assert cycle_basis(4, graph((0, 1), (1, 2), (1, 3))) == []
    assert cycle_basis(1, []) == []


def test_exact_poses_close_within_the_noise():
    views = around('blob')
    resolution = resolution_of(views)
    loops = loops_of(joint_of(views), threads=2)
    document = loops.document([one.name for one in views])
    assert document['count'] >= 3
    assert document['translation']['mean'] < 0.3 * resolution
    assert document['worst']['translation'] == document['translation']['max']


def test_an_edge_measured_alone_takes_a_wrong_view_back():
    views = around('blob')
    joint = joint_of(wronged(views, 1, degrees=1.0, shift_mr=1.0))
    best = max(
        (one for one in joint.edges if 1 in (one.source, one.target)),
        key=lambda one: one.overlap)
    pair = (best.source, best.target)
    motion = measure_edges(joint, [pair])[pair]
    if pair[1] == 1:
        motion = np.linalg.inv(motion)
    middle = views[1].points.mean(axis=0)
    moved = wronged(views, 1, degrees=1.0, shift_mr=1.0)[1]
    back = motion @ moved.T_object_view
    away = move(back @ np.linalg.inv(views[1].T_object_view), middle[None]) - middle
    assert np.linalg.norm(away) < 0.35 * resolution_of(views)


def test_the_ring_of_a_turntable_is_a_loop_of_its_own():
    views = turntable('blob', np.arange(0, 360, 40))
    ring = tuple(range(9))
    loops = loops_of(joint_of(views), ring, threads=2)
    assert sum(set(one.views) == set(ring) for one in loops.loops) == 1
