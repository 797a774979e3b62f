# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Symmetric positive definite systems of 6 x 6 blocks, most of them zero where there are many.

No BLAS: its sums may change with its number of threads.
"""

import numpy as np
from ros_rops.core.types import Floats
from scipy.sparse import bsr_array

# Up to so many unknowns of 6, elimination is quicker; beyond, its V^3 would outgrow all else.
FEW = 18
# Done when the residual has shrunk to this share: the next round begins from there anyway.
TOLERANCE = 1e-10
# Rounds of conjugate gradients, at most, for each unknown of 6: in exact arithmetic 6.
ROUNDS = 12


def between(left: Floats, blocks: Floats, right: Floats) -> Floats:
    """Return `left[i] @ blocks[i, j] @ right[j]` (V, V, 6, 6), zero where the block is."""
    rows, columns = np.nonzero(blocks.any(axis=(2, 3)))
    found = np.einsum('pab,pbc->pac', left[rows], blocks[rows, columns])
    result = np.zeros_like(blocks)
    result[rows, columns] = np.einsum('pab,pbc->pac', found, right[columns])
    return result


def solve_blocks(blocks: Floats, right: Floats) -> Floats:
    """
    Solve a symmetric positive definite block system (arguments are overwritten).

    Parameters
    ----------
    blocks : (V, V, 6, 6) float64
    right : (V, 6) float64

    Returns
    -------
    (V, 6) float64
    """
    return _eliminate(blocks, right) if len(right) <= FEW else _iterate(blocks, right)


def _eliminate(blocks: Floats, right: Floats) -> Floats:
    """Eliminate the blocks one by one."""
    count = len(right)
    inverses = np.zeros((count, 6, 6))
    for k in range(count):
        inverses[k] = np.linalg.inv(blocks[k, k])
        factor = np.einsum('iab,bc->iac', blocks[k + 1:, k], inverses[k])
        blocks[k + 1:, k + 1:] -= np.einsum('iab,jbc->ijac', factor, blocks[k, k + 1:])
        right[k + 1:] -= np.einsum('iab,b->ia', factor, right[k])
    result = np.zeros_like(right)
    for k in reversed(range(count)):
        rest = right[k] - np.einsum('jab,jb->a', blocks[k, k + 1:], result[k + 1:])
        result[k] = np.einsum('ab,b->a', inverses[k], rest)
    return result


def _iterate(blocks: Floats, right: Floats) -> Floats:
    """Run conjugate gradients, each diagonal block inverted beforehand."""
    count = len(right)
    rows, columns = np.nonzero(blocks.any(axis=(2, 3)))
    starts = np.searchsorted(rows, np.arange(count + 1))
    matrix = bsr_array(
        (blocks[rows, columns], columns, starts), shape=(6 * count, 6 * count))
    inverses = np.linalg.inv(blocks[np.arange(count), np.arange(count)])
    found, rest = np.zeros_like(right), right.copy()
    ahead = direction = np.einsum('vab,vb->va', inverses, rest)
    worth = goal = float((rest * ahead).sum())
    for _ in range(ROUNDS * count):
        if worth <= TOLERANCE**2 * goal:
            break
        changed = (matrix @ direction.reshape(-1)).reshape(count, 6)
        step = worth / float((direction * changed).sum())
        found += step * direction
        rest -= step * changed
        ahead = np.einsum('vab,vb->va', inverses, rest)
        worth, before = float((rest * ahead).sum()), worth
        direction = ahead + worth / before * direction
    return found
