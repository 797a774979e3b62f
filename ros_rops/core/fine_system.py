# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The linear system of a joint step over all views of a shape.

A motion of view i is (rotation vector times the view's size, translation) about the view's own
middle, both in the frame of the poses, so that a motion of length 1 moves the view's points by
about 1 unit whatever the units are. Blocks are (V, V, 6, 6).
"""

from typing import NamedTuple

import numpy as np
from ros_rops.core.block_system import between, solve_blocks
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.kernels.fine import PairSums
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

# Damping relative to the weight that holds a view: far below what holds the end of a long chain
# of views together, yet enough where two groups of views can slide along each other.
DAMPING = 1e-7


class Frames(NamedTuple):
    """Middle (V, 3) and size (V,) (root mean square distance from it) of the placed views."""

    middles: Floats
    sizes: Floats


class Stiffness(NamedTuple):
    """
    How well the neighbours of each view hold it, were they fixed.

    Parameters
    ----------
    values : (V, 6) float64
        Mean squared change of distance for a motion of unit size, ascending; 0 if unmatched.
    motions : (V, 6, 6) float64
        Columns: the motions they belong to.
    """

    values: Floats
    motions: Floats


class System(NamedTuple):
    """Blocks (V, V, 6, 6), right-hand sides (V, 6) and summed weights (V,) of a step."""

    blocks: Floats
    right: Floats
    weight: Floats


def skew(vector: Floats) -> Floats:
    """Return the matrix of the cross product with `vector` (3,)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def frames_of(middles: Floats, sizes: Floats, poses: Floats) -> Frames:
    """Place the views' own middles (V, 3) by `poses` (V, 4, 4)."""
    placed = np.einsum('vij,vj->vi', poses[:, :3, :3], middles) + poses[:, :3, 3]
    return Frames(placed, sizes)


def assemble(pairs: Ints, sums: PairSums, keep: Bools, frames: Frames, centre: Floats) -> System:
    """
    Sum the pairs into one system in the views' own motions.

    Parameters
    ----------
    pairs : (P, 2) int32
    sums : PairSums
        About `centre` (3,).
    keep : (P,) bool
        Pairs that count.
    """
    count = len(frames.sizes)
    changes = np.zeros((count, 6, 6))
    for v in range(count):
        changes[v, :3, :3] = np.eye(3) / frames.sizes[v]
        changes[v, :3, 3:] = -skew(frames.middles[v] - centre) / frames.sizes[v]
        changes[v, 3:, 3:] = np.eye(3)
    common = np.zeros((count, count, 6, 6))
    gradient = np.zeros((count, 6))
    weight = np.zeros(count)
    for p in np.flatnonzero(keep):
        i, j = pairs[p]
        common[i, i] += sums.hessian[p]
        common[j, j] += sums.hessian[p]
        common[i, j] -= sums.hessian[p]
        common[j, i] -= sums.hessian[p]
        gradient[i] += sums.gradient[p]
        gradient[j] -= sums.gradient[p]
        weight[i] += sums.weight[p]
        weight[j] += sums.weight[p]
    blocks = between(changes, common, np.swapaxes(changes, 1, 2))
    return System(blocks, -np.einsum('iab,ib->ia', changes, gradient), weight)


def stiffness_of(system: System) -> Stiffness:
    """Return how each view is held by its neighbours."""
    count = len(system.weight)
    own = system.blocks[np.arange(count), np.arange(count)]
    values, motions = np.linalg.eigh(own)
    scale = np.where(system.weight > 0, system.weight, 1.0)[:, None]
    return Stiffness(np.maximum(values / scale, 0.0), motions)


def components_of(count: int, pairs: Ints, keep: Bools) -> Ints:
    """Return the connected group of each view, numbered in the order of their first view."""
    kept = pairs[keep]
    graph = coo_array((np.ones(len(kept)), (kept[:, 0], kept[:, 1])), shape=(count, count))
    labels: Ints = connected_components(graph, directed=False)[1].astype(np.int32)
    return labels


def solve(
    system: System, components: Ints, stiffness: Stiffness, least_stiffness: float
) -> Floats:
    """
    Return the motions (V, 6) of a Gauss-Newton step.

    The first view of each component stays where it is; other views stay put along motions that
    nothing holds (`least_stiffness`).
    """
    count = len(system.weight)
    strong = (stiffness.values >= least_stiffness)[:, None, :]
    keep = np.einsum('vab,vcb->vac', stiffness.motions * strong, stiffness.motions)
    keep[np.unique(components, return_index=True)[1]] = 0.0
    blocks = between(keep, system.blocks, keep)
    right = np.einsum('iab,ib->ia', keep, system.right)
    held = np.maximum(system.weight, 1.0)[:, None, None]
    diagonal = np.arange(count)
    blocks[diagonal, diagonal] += held * (np.eye(6) - keep * (1.0 - DAMPING))
    motions: Floats = np.einsum('iab,ib->ia', keep, solve_blocks(blocks, right))
    return motions


def move(poses: Floats, motions: Floats, frames: Frames) -> Floats:
    """Apply `motions` (V, 6) to `poses` (V, 4, 4)."""
    turns = Rotation.from_rotvec(motions[:, :3] / frames.sizes[:, None]).as_matrix()
    moved = poses.copy()
    moved[:, :3, :3] = np.einsum('vij,vjk->vik', turns, poses[:, :3, :3])
    arms = poses[:, :3, 3] - frames.middles
    moved[:, :3, 3] = np.einsum('vij,vj->vi', turns, arms) + frames.middles + motions[:, 3:]
    still = ~motions.any(axis=1)
    moved[still] = poses[still]
    return moved
