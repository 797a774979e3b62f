# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Which views of a shape are matched with each other (IV-B).

Of N views around one object nearly every two overlap: matching them all takes N^2. A few partners
hold a view as well, if some lie near and some far, so that no error adds up along a chain.
"""

from collections.abc import Sequence

import numpy as np
from ros_rops.core.types import Bools, Floats, Ints
from scipy.sparse import csr_array
from scipy.sparse.csgraph import minimum_spanning_tree

# Two views overlap as far as they share cells of this part of a view's size: fine enough to tell
# their parts apart, coarse enough to be met by few samples at poses that are to be refined yet.
CELL = 1.0 / 6.0
# Of the partners that are not the nearest, each shares at least this part of a view's cells.
LEAST_SHARE = 0.1


def pairs_to_match(
    points: Sequence[Floats], normals: Sequence[Floats], size: float, partners: int
) -> Ints:
    """
    Choose the ordered pairs of views that are matched.

    Parameters
    ----------
    points, normals : sequences of (S, 3) arrays
        Samples of each view, in the common frame.
    size : float
        Of a view: root mean square distance of its points from their middle.
    partners : int
        Up to so many others, each view is matched with all of them. Of more, it asks for half as
        many: those that it shares most with, and some of the rest, spread over all of that; so
        that with those who ask for it, it has about `partners` in the mean.

    Returns
    -------
    (P, 2) int32
        Both orders of each pair; rising. Views that overlap stay connected.
    """
    count = len(points)
    if count <= partners + 1:
        return np.argwhere(~np.eye(count, dtype=bool)).astype(np.int32)
    shared = _shared_cells(points, normals, CELL * size)
    own = np.diag(shared).copy()
    np.fill_diagonal(shared, 0)
    chosen = _strongest_tree(shared)
    for view in range(count):
        order = np.argsort(-shared[view], kind='stable')
        order = order[shared[view, order] > 0]
        near, rest = order[:partners // 4], order[partners // 4:]
        rest = rest[shared[view, rest] >= LEAST_SHARE * own[view]]
        chosen[view, near] = True
        chosen[view, _spread(rest, partners // 2 - len(near))] = True
    return np.argwhere(chosen | chosen.T).astype(np.int32)


def _shared_cells(points: Sequence[Floats], normals: Sequence[Floats], cell: float) -> Ints:
    """Count the cells (V, V) that two views both have points in, on the same side of a wall."""
    cells = []
    for where, normal in zip(points, normals, strict=True):
        axis = np.abs(normal).argmax(axis=1)
        side = 2 * axis + (normal[np.arange(len(normal)), axis] > 0)
        cells.append(np.unique(
            np.column_stack([np.floor(where / cell), side]).astype(np.int64), axis=0))
    _, number = np.unique(np.concatenate(cells), axis=0, return_inverse=True)
    owner = np.repeat(np.arange(len(cells)), [len(own) for own in cells])
    seen = csr_array((np.ones(len(owner), dtype=np.int32), (owner, number.reshape(-1))))
    shared: Ints = (seen @ seen.T).toarray()
    return shared


def _spread(order: Ints, most: int) -> Ints:
    """Take at most `most`, evenly."""
    if len(order) <= most:
        return order
    return order[np.arange(most) * len(order) // max(most, 1)]


def _strongest_tree(shared: Ints) -> Bools:
    """Pairs (V, V) that connect all that overlaps, by the most that is shared."""
    cost = np.divide(1.0, shared, out=np.zeros(shared.shape), where=shared > 0)
    tree: Bools = minimum_spanning_tree(csr_array(cost)).toarray() > 0
    return tree
