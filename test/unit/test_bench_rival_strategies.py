# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Rival strategies for many views. Truth: exact poses of rendered views, and counting.

The small graphs have pairs whose answers are written down, so that the counts are known by hand.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from reference.bench_sets import random_pose
from ros_rops.bench.evaluate import known_views
from ros_rops.bench.multiview import Job, named_views, run_job
from ros_rops.bench.paper.rendered import rendered_set
from ros_rops.bench.rivals.connected_graph import (
    CONNECTED_GRAPH, connected_graphs, surface_area)
from ros_rops.bench.rivals.spanning_tree import SPANNING_TREE, spanning_trees
from ros_rops.bench.rivals.view_graph import Book
from ros_rops.core.config import Config
from ros_rops.core.types import Status
from ros_rops.recordings.simulate_models import read_models


class Told:
    """Pairs that are known by their names; everything else is refused."""

    def __init__(self, world, overlaps, areas=None, lies=()):
        self.world, self.overlaps, self.asked = world, overlaps, []
        self.lies = set(lies)
        areas = areas or [1.0] * len(world)
        self.views = [SimpleNamespace(mesh=SimpleNamespace(
            vertices=np.array([[0, 0, 0], [2 * a, 0, 0], [0, 1, 0]], float),
            faces=np.array([[0, 1, 2]]))) for a in areas]

    def result(self, i, j):
        assert i < j
        self.asked.append((i, j))
        overlap = self.overlaps.get((i, j))
        pose = None if overlap is None else np.linalg.inv(self.world[j]) @ self.world[i]
        if (i, j) in self.lies:
            pose = random_pose(np.random.default_rng(9))
        status = Status.REFUSED if overlap is None else Status.PLACED
        return SimpleNamespace(
            status=status, T_target_source=pose, numbers={'overlap': overlap or 0.0})

    def pose(self, i, j):
        T = self.result(min(i, j), max(i, j)).T_target_source
        return T if T is None or i < j else np.linalg.inv(T)

    def agree(self, part, other):
        """Two views see that they lie wrong, unless theirs is the pair that lies."""
        return all(
            np.allclose(np.linalg.inv(Tj) @ Ti, np.linalg.inv(self.world[j]) @ self.world[i])
            for i, Ti in other.items() for j, Tj in part.items()
            if (min(i, j), max(i, j)) not in self.lies)


def worlds(count):
    rng = np.random.default_rng(3)
    return [random_pose(rng) for _ in range(count)]


def assert_right(part, world):
    root = next(iter(part))
    frame = part[root] @ np.linalg.inv(world[root])
    for k, pose in part.items():
        np.testing.assert_allclose(pose, frame @ world[k], atol=1e-8)


def test_the_spanning_tree_asks_all_pairs_and_takes_the_most_inliers():
    # The pair 1-3 lies; the tree of the better pairs does without it.
    told = Told(worlds(5), {(0, 1): 0.6, (1, 2): 0.5, (2, 3): 0.4, (1, 3): 0.2}, lies=[(1, 3)])
    part, = spanning_trees(told)
    assert len(told.asked) == len(set(told.asked)) == 10
    assert sorted(part) == [0, 1, 2, 3]
    assert_right(part, told.world)


def test_the_spanning_tree_does_not_join_what_contradicts_itself():
    # The best pair of all lies, which shows as soon as others come to lie beside it.
    told = Told(worlds(4), {(0, 1): 0.6, (1, 2): 0.5, (2, 3): 0.9}, lies=[(2, 3)])
    assert sorted(sorted(part) for part in spanning_trees(told)) == [[0, 1], [2, 3]]


def test_two_components_are_two_objects():
    told = Told(worlds(5), {(0, 2): 0.6, (1, 3): 0.5, (3, 4): 0.4})
    assert sorted(sorted(part) for part in spanning_trees(told)) == [[0, 2], [1, 3, 4]]
    assert sorted(sorted(part) for part in connected_graphs(told)) == [[0, 2], [1, 3, 4]]


def test_the_connected_graph_begins_with_the_largest_and_asks_node_by_node():
    told = Told(
        worlds(5), {(0, 1): 0.6, (1, 2): 0.5, (2, 3): 0.4}, areas=[1, 1, 3, 1, 1])
    part, = connected_graphs(told)
    assert list(part) == [2, 1, 3, 0]
    assert_right(part, told.world)
    # 2 asks 0, 1, 3, 4; 1 asks 0, 4; then 3 and 0 ask 4, which nobody knows.
    assert told.asked == [(0, 2), (1, 2), (2, 3), (2, 4), (0, 1), (1, 4), (3, 4), (0, 4)]


def test_a_view_that_contradicts_the_graph_waits_for_another_node():
    told = Told(
        worlds(3), {(0, 1): 0.6, (0, 2): 0.5, (1, 2): 0.5}, areas=[3, 2, 1], lies=[(0, 2)])
    part, = connected_graphs(told)
    assert list(part) == [0, 1, 2]
    assert_right(part, told.world)


def test_the_area_is_that_of_the_triangles():
    mesh = SimpleNamespace(
        vertices=np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [2, 3, 0]], float),
        faces=np.array([[0, 1, 2], [1, 3, 2]]))
    assert surface_area(mesh) == pytest.approx(6.0)


@pytest.fixture(scope='module')
def job():
    """Four views of one object, 20 degrees apart, and one of another."""
    blob, bracket = read_models(['procedural:blob', 'procedural:bracket'])
    sets = (
        rendered_set(blob, views=4, step_deg=20.0, pixels=90),
        rendered_set(bracket, views=2, step_deg=20.0, pixels=90))
    views = [*named_views(sets[:1]), named_views(sets[1:])[0]]
    known = known_views(sets)
    return Job(
        ('blob', 'bracket'), 'given', tuple(views), {v.name: known[v.name] for v in views},
        Config(), 1)


def test_both_find_the_exact_poses_and_leave_the_stranger_out(job):
    book, attempts = Book(), {}
    for strategy in (SPANNING_TREE, CONNECTED_GRAPH):
        case = run_job(
            job, lambda given, one=strategy: one.open_session(given, book), residuals=False)
        assert (case['placed'], case['wrong_placements'], case['wrong_merges']) == (4, 0, 0)
        assert case['max_rotation_deg'] < 0.2
        assert case['max_translation_dres'] < 0.2
        attempts[strategy.name] = case['attempts']
    assert attempts['spanning tree'] == 10 == len(book.results)
    assert attempts['connected graph'] < 10


def test_coarse_poses_are_those_before_the_fine_registration(job):
    case, plain = run_job(job, coarse=True, residuals=False), run_job(job, residuals=False)
    # Looking in between changes nothing.
    for key in ('placed', 'attempts', 'max_rotation_deg', 'max_translation_dres'):
        assert case[key] == plain[key]
    assert case['placed'] == case['coarse']['placed'] == 4
    assert case['mean_rotation_deg'] < case['coarse']['mean_rotation_deg'] < 1.0
    assert 'coarse' not in plain
