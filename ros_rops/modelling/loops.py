# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
How well the views close round loops: pairs measured alone, composed, against the identity.

A joint registration spreads an error over all views, where it no longer shows in residuals. So
every pair of overlapping views is refined alone, point to plane from its final pose, and these
relative poses are composed round the cycles of a basis (those that close a spanning tree of the
best overlaps) and, where the object was turned, round the full ring. What is left beside the
identity is drift (Pulli 1999, Multiview registration for large data sets, 3).
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
import math
import os
from typing import Any

import numpy as np
from ros_rops.core import fine_system
from ros_rops.core.fine_types import EdgeFit
from ros_rops.core.types import Floats, Ints
from ros_rops.modelling.joint import Joint
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.transform import Rotation

LEAST_OVERLAP = 0.1
"""Pairs that overlap less (share of the samples of both) are not measured: they slide."""
_ROUNDS = 8
_TOLERANCE_MR = 0.01
# Matches of a pair lie nearer than this from the third round on.
_RADIUS_MR = 2.0
_WIDE_ROUNDS = 2


@dataclass(frozen=True, slots=True)
class Loop:
    """
    A cycle of views and what its relative poses come to beside the identity.

    Parameters
    ----------
    views : tuple of int
    rotation_deg : float
    translation : float
        How far the middle of the object is moved.
    """

    views: tuple[int, ...]
    rotation_deg: float
    translation: float


@dataclass(frozen=True, slots=True)
class Loops:
    """The loops of an object, the worst (by translation) first; at least one."""

    loops: tuple[Loop, ...]

    def document(self, names: Sequence[str]) -> dict[str, Any]:
        """Return the numbers of `quality.json`; `names` are those of the views."""
        turns = [one.rotation_deg for one in self.loops]
        shifts = [one.translation for one in self.loops]
        worst = self.loops[0]
        return {
            'count': len(self.loops),
            'rotation_deg': {'mean': float(np.mean(turns)), 'max': max(turns)},
            'translation': {'mean': float(np.mean(shifts)), 'max': max(shifts)},
            'worst': {
                'views': [names[k] for k in worst.views],
                'rotation_deg': worst.rotation_deg, 'translation': worst.translation}}


Edges = Mapping[tuple[int, int], Floats]
"""(i, j), i < j, to the motion (4, 4) by which view i, in the object's frame, fits j better."""


def loops_of(joint: Joint, ring: Sequence[int] = (), *, threads: int = 0) -> Loops | None:
    """
    Measure the loops of an object.

    Parameters
    ----------
    joint : Joint
    ring : sequence of int
        Views in the order in which a turntable brought them round, if it did.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    Loops or None
        None if the views form no loop.
    """
    fits = [one for one in joint.edges if one.overlap >= LEAST_OVERLAP]
    cycles = cycle_basis(len(joint.problem.poses), fits)
    pairs = {(one.source, one.target) for one in fits}
    whole = len(ring) > 2 and all(_ordered(pair) in pairs for pair in _steps(ring))
    closed = [tuple(ring)] if whole else []
    cycles = closed + [one for one in cycles if not closed or set(one) != set(ring)]
    if not cycles:
        return None
    needed = sorted({_ordered(pair) for one in cycles for pair in _steps(one)})
    edges = measure_edges(joint, needed, threads=threads)
    found = [close(one, edges, joint.problem.centre) for one in cycles]
    return Loops(tuple(sorted(found, key=lambda one: -one.translation)))


def measure_edges(
    joint: Joint, pairs: Sequence[tuple[int, int]], *, threads: int = 0
) -> dict[tuple[int, int], Floats]:
    """Refine each pair (i, j) of views alone from the final poses: the motion (4, 4) of i."""
    workers = threads or os.cpu_count() or 1
    with ThreadPoolExecutor(workers) as pool:
        motions = pool.map(lambda pair: _refine(joint, *pair), pairs)
        return dict(zip(pairs, motions, strict=True))


def _refine(joint: Joint, i: int, j: int) -> Floats:
    problem = joint.problem
    unit, both = problem.resolution, np.array([[i, j], [j, i]], dtype=np.int32)
    poses = problem.poses.copy()
    for turn in range(_ROUNDS):
        wide = problem.config.radius_start_mr if turn < _WIDE_ROUNDS else _RADIUS_MR
        frames = fine_system.frames_of(problem.middles, problem.sizes, poses)
        sums = problem.surfaces.normal_equations(
            both, problem.few, poses, frames.middles[i], radius=wide * unit, soft=unit,
            min_cos=math.cos(math.radians(problem.config.normal_angle_deg)), threads=1)
        motion = _step(
            sums.hessian.sum(axis=0), sums.gradient[0] - sums.gradient[1],
            float(sums.weight.sum()), frames.sizes[i], problem.config.least_stiffness)
        motions = np.zeros((len(poses), 6))
        motions[i] = motion
        poses = fine_system.move(poses, motions, frames)
        if np.abs(motion).max() < _TOLERANCE_MR * unit:
            break
    moved: Floats = poses[i] @ np.linalg.inv(problem.poses[i])
    return moved


def _step(
    hessian: Floats, gradient: Floats, weight: float, size: float, least: float
) -> Floats:
    """Return the motion (6,), the turn times `size`, along what is held; gradient about middle."""
    if weight <= 0:
        return np.zeros(6)
    scale = np.repeat([1.0 / size, 1.0], 3)
    values, vectors = np.linalg.eigh(hessian * np.multiply.outer(scale, scale) / weight)
    amount = -np.einsum('ab,a->b', vectors, gradient * scale) / weight
    held = values >= least
    motion: Floats = np.einsum(
        'ab,b->a', vectors, np.where(held, amount / np.where(held, values, 1.0), 0.0))
    return motion


def close(cycle: Sequence[int], edges: Edges, middle: Floats) -> Loop:
    """
    Compose the measured relative poses round a cycle.

    All motions are in the object's frame, where the final poses themselves compose to the
    identity: with T_j_i = P_j^-1 M_ij P_i the product round the cycle is similar to that of the
    motions M_ij (or the inverse, going the other way).

    Parameters
    ----------
    cycle : sequence of int
    edges : mapping
        The motion M (4, 4) of view i for each pair i < j.
    middle : (3,) float64
        Point whose motion is told.
    """
    total = np.eye(4)
    for a, b in _steps(cycle):
        motion = edges[(a, b)] if a < b else np.linalg.inv(edges[(b, a)])
        total = motion @ total
    turned = float(np.degrees(Rotation.from_matrix(total[:3, :3]).magnitude()))
    shifted = float(np.linalg.norm(total[:3, :3] @ middle + total[:3, 3] - middle))
    return Loop(tuple(int(k) for k in cycle), turned, shifted)


def cycle_basis(count: int, fits: Sequence[EdgeFit]) -> list[tuple[int, ...]]:
    """
    Return the fundamental cycles of the graph of views: one for each edge beside a tree.

    Parameters
    ----------
    count : int
        Number of views.
    fits : sequence of EdgeFit
        Edges; the tree is that of the most matches.
    """
    if not fits:
        return []
    ends = np.array([(one.source, one.target) for one in fits])
    # Distinct weights, so that there is one tree only.
    order = np.argsort([-one.matches for one in fits], kind='stable')
    rank = np.empty(len(fits))
    rank[order] = np.arange(1, len(fits) + 1)
    graph = coo_array((rank, (ends[:, 0], ends[:, 1])), shape=(count, count))
    tree = minimum_spanning_tree(graph.tocsr()).tocoo()
    links = {(int(min(a, b)), int(max(a, b))) for a, b in zip(*tree.coords, strict=True)}
    parents, depth = _rooted(count, links)
    return [
        _round(int(a), int(b), parents, depth) for a, b in ends if (int(a), int(b)) not in links]


def _rooted(count: int, links: set[tuple[int, int]]) -> tuple[Ints, Ints]:
    """Return each view's parent (-1 for roots) and depth in the forest."""
    beside: list[list[int]] = [[] for _ in range(count)]
    for a, b in sorted(links):
        beside[a].append(b)
        beside[b].append(a)
    parents, depth = np.full(count, -1, np.int32), np.full(count, -1, np.int32)
    for root in range(count):
        queue = [root] if depth[root] < 0 else []
        depth[queue] = 0
        for a in queue:
            for b in beside[a]:
                if depth[b] < 0:
                    parents[b], depth[b] = a, depth[a] + 1
                    queue.append(b)
    return parents, depth


def _round(a: int, b: int, parents: Ints, depth: Ints) -> tuple[int, ...]:
    """Return the cycle of edge (a, b): up the tree from both to where they meet."""
    up, down = [a], [b]
    while up[-1] != down[-1]:
        longer = up if depth[up[-1]] >= depth[down[-1]] else down
        longer.append(int(parents[longer[-1]]))
    return (*up, *reversed(down[:-1]))


def _steps(cycle: Sequence[int]) -> list[tuple[int, int]]:
    return [(cycle[k], cycle[(k + 1) % len(cycle)]) for k in range(len(cycle))]


def _ordered(pair: tuple[int, int]) -> tuple[int, int]:
    return min(pair), max(pair)
