# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The truth of the pairs of a data set: overlap, reference transform, what is evaluated."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.types import Floats
from scipy.spatial import cKDTree

OVERLAP_DRES = 2.0
EVALUATED_OVERLAP = 0.10
OVERLAP_BINS = {'0.1-0.3': (0.1, 0.3), '0.3-0.6': (0.3, 0.6), '0.6-1.0': (0.6, 1.0)}


@dataclass(frozen=True, slots=True)
class PairTruth:
    """
    What is known about an ordered pair of views.

    Parameters
    ----------
    name_i, name_j : str
        The source view and the target view.
    overlap : float
        Share of the points of both that have a neighbour in the other within 2 dres.
    T_j_i : (4, 4) float64 or None
        Reference transform of i's points into j's frame; None for views of two objects.
    """

    name_i: str
    name_j: str
    overlap: float
    T_j_i: Floats | None

    def __iter__(self) -> Iterator[object]:
        """Unpack as name_i, name_j, overlap, T_j_i."""
        return iter((self.name_i, self.name_j, self.overlap, self.T_j_i))

    @property
    def evaluated(self) -> bool:
        """Whether the overlap is at least 0.10."""
        return self.overlap >= EVALUATED_OVERLAP


def overlap_bin(overlap: float) -> str | None:
    """Return the key of `OVERLAP_BINS` that holds `overlap` (lower bound in), None below 0.1."""
    for key, (low, high) in OVERLAP_BINS.items():
        if low <= overlap < high or (overlap >= low and high == 1.0):
            return key
    return None


def count_close(points: Floats, tree: cKDTree, radius: float, *, threads: int = 2) -> int:
    """
    Count the `points` (N, 3) that have a neighbour in `tree` within `radius`.

    Points outside the tree's bounding box grown by the radius cannot have one and are not
    asked for, which leaves the count as it is.
    """
    low, high = tree.mins - radius, tree.maxes + radius
    inside = ((points >= low) & (points <= high)).all(axis=1)
    if not inside.any():
        return 0
    # The bound is exclusive in SciPy, the definition says within.
    bound = np.nextafter(radius, np.inf)
    distance, _ = tree.query(points[inside], distance_upper_bound=bound, workers=threads)
    return int(np.isfinite(distance).sum())


def overlap(
    tree_i: cKDTree, tree_j: cKDTree, T_j_i: Floats, radius: float, *, threads: int = 2
) -> float:
    """
    Overlap of two views under `T_j_i` (4, 4), on all points.

    Parameters
    ----------
    tree_i, tree_j : cKDTree
        All points of either view in its own frame.
    T_j_i : (4, 4) float64
        Maps i's points into j's frame.
    radius : float
        2 dres.
    threads : int
        Threads of the neighbour search; the result does not depend on them.

    Returns
    -------
    float
        (points of i near j + points of j near i) / (n_i + n_j), 0 for two empty views.
    """
    rotation, shift = T_j_i[:3, :3], T_j_i[:3, 3]
    i_in_j = tree_i.data @ rotation.T + shift
    j_in_i = (tree_j.data - shift) @ rotation
    close = count_close(i_in_j, tree_j, radius, threads=threads)
    close += count_close(j_in_i, tree_i, radius, threads=threads)
    return close / max(1, int(tree_i.n) + int(tree_j.n))


def evaluate_pairs(dataset: ReferenceSet, *, threads: int = 2) -> list[PairTruth]:
    """
    Overlap and reference transform of all pairs i < j of a data set, in the order of its views.

    Those with `evaluated` count for the recall, all of them for the precision.
    """
    trees = {name: cKDTree(view.points) for name, view in dataset.views.items()}
    radius = OVERLAP_DRES * dataset.dres
    pairs = []
    for i, j in combinations(dataset.views, 2):
        T_j_i = dataset.reference(i, j)
        shared = 0.0
        if T_j_i is not None:
            shared = overlap(trees[i], trees[j], T_j_i, radius, threads=threads)
        pairs.append(PairTruth(i, j, shared, T_j_i))
    return pairs
