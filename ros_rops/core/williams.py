# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Simultaneous registration of corresponding point sets (Williams and Bennamoun 2001).

Minimises sum |R_i p + t_i - R_j q - t_j|^2 over all matches (p of view i, q of view j) and all
views at once: rotations in turn, each by the singular value decomposition that is best while
the others stand, then all translations by one linear system; swept until nothing moves.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from ros_rops.core.types import Floats, Ints
from ros_rops.kernels.fine import Surfaces

SWEEPS = 50
# Relative to the spread of the points: sweeping on gains nothing.
STILL = 1e-5


class Moments(NamedTuple):
    """Of the matches of one pair: their number, sums of p and q (3,), sum of p q^T (3, 3)."""

    matches: int
    source: Floats
    target: Floats
    product: Floats


def moments_of(source: Floats, target: Floats) -> Moments:
    """Return the moments of matched points (M, 3), each side in its view's frame."""
    return Moments(
        len(source), source.sum(axis=0), target.sum(axis=0),
        np.einsum('ni,nj->ij', source, target))


def step(
    surfaces: Surfaces, points: Sequence[Floats], pairs: Ints, samples: Sequence[Ints],
    poses: Floats, components: Ints, *, radius: float, min_cos: float,
) -> Floats:
    """
    Match all pairs at `poses` and return the poses (V, 4, 4) that fit the matches best.

    The first view of each component keeps its pose.
    """
    table: dict[tuple[int, int], Moments] = {}
    for i, j in pairs:
        source, target = surfaces.match(
            i, j, samples[i], poses[i], poses[j], radius=radius, min_cos=min_cos)
        if len(source):
            table[int(i), int(j)] = moments_of(points[i][source], points[j][target])
    return fit(table, poses, components)


def fit(table: dict[tuple[int, int], Moments], poses: Floats, components: Ints) -> Floats:
    """Return the poses that minimise the sum over the `table` of matched pairs."""
    links: list[list[tuple[int, Moments]]] = [[] for _ in poses]
    for (i, j), m in table.items():
        links[i].append((j, m))
        links[j].append((i, Moments(m.matches, m.target, m.source, m.product.T)))
    anchors = set(np.unique(components, return_index=True)[1].tolist())
    free = [v for v in range(len(poses)) if v not in anchors and links[v]]
    poses = poses.copy()
    for _ in range(SWEEPS):
        before = poses.copy()
        for v in free:
            _turn(v, links[v], poses)
        _shift(free, links, poses)
        spread = max(float(np.abs(poses[:, :3, 3]).max()), 1e-300)
        change = np.abs(poses - before)
        if change[:, :3, :3].max() < STILL and change[:, :3, 3].max() < STILL * spread:
            break
    return poses


def _turn(v: int, links: list[tuple[int, Moments]], poses: Floats) -> None:
    """Give view v the pose that fits the partners of its points as they stand."""
    count, own, other, product = 0, np.zeros(3), np.zeros(3), np.zeros((3, 3))
    for u, m in links:
        turn, shift = poses[u, :3, :3], poses[u, :3, 3]
        count += m.matches
        own += m.source
        other += turn @ m.target + m.matches * shift
        product += m.product @ turn.T + np.outer(m.source, shift)
    left, _, right = np.linalg.svd(product - np.outer(own, other) / count)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left * sign @ right).T
    poses[v, :3, :3] = turn
    poses[v, :3, 3] = (other - turn @ own) / count


def _shift(free: list[int], links: list[list[tuple[int, Moments]]], poses: Floats) -> None:
    """Give all free views the translations that are best for the rotations as they stand."""
    if not free:
        return
    place = {v: k for k, v in enumerate(free)}
    matrix, right = np.zeros((len(free), len(free))), np.zeros((len(free), 3))
    for v in free:
        k = place[v]
        for u, m in links[v]:
            matrix[k, k] += m.matches
            right[k] += poses[u, :3, :3] @ m.target - poses[v, :3, :3] @ m.source
            if u in place:
                matrix[k, place[u]] -= m.matches
            else:
                right[k] += m.matches * poses[u, :3, 3]
    poses[free, :3, 3] = np.linalg.solve(matrix, right)
