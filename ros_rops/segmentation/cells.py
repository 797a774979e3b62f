# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Connected parts of an unorganized cloud: points in neighbouring cubic cells belong together."""

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.segmentation.patches import cell_side
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

REACH = 3.0
"""Points within so many spacings of the cloud are connected, about."""


def spacing_of(points: Floats) -> float:
    """Return the spacing of points (M, 3) on their surface; 0 for fewer than two."""
    if len(points) < 2:
        return 0.0
    pick = np.linspace(0, len(points) - 1, min(len(points), 500)).astype(np.int64)
    near, _ = cKDTree(points).query(points[pick], k=min(len(points), 5))
    return float(np.median(near[:, -1]))


def parts_of_cloud(points: Floats, mask: Bools, spacing: float) -> tuple[Ints, int]:
    """
    Return the connected parts of the masked points, numbered, 0 outside; and how many.

    Parameters
    ----------
    points : (M, 3) float64
        The masked points.
    mask : (N,) bool
    spacing : float
        As `spacing_of` tells.
    """
    numbers = np.zeros(len(mask), np.int32)
    if not len(points):
        return numbers, 0
    side = REACH / 2 * spacing or cell_side(points, 1000)
    steps = np.floor((points - points.min(axis=0)) / side).astype(np.int64)
    span = steps.max(axis=0) + 3  # a free layer around: neighbours never wrap
    keys = ((steps[:, 0] + 1) * span[1] + steps[:, 1] + 1) * span[2] + steps[:, 2] + 1
    cells, cell = np.unique(keys, return_inverse=True)
    links = []
    for shift in _half_neighbours(span):
        at = np.minimum(np.searchsorted(cells, cells + shift), len(cells) - 1)
        hit = np.flatnonzero(cells[at] == cells + shift)
        links.append(np.stack([hit, at[hit]]))
    i, j = np.concatenate(links, axis=1)
    graph = coo_array((np.ones(len(i), bool), (i, j)), shape=(len(cells), len(cells)))
    count, part = connected_components(graph, directed=False)
    numbers[mask] = part[cell.ravel()] + 1
    return numbers, int(count)


def _half_neighbours(span: Ints) -> list[int]:
    """Return the key differences to the 13 of the 26 neighbours that come after a cell."""
    shifts = [
        (dx * int(span[1]) + dy) * int(span[2]) + dz
        for dx in (-1, 0, 1) for dy in (-1, 0, 1) for dz in (-1, 0, 1)]
    return [shift for shift in shifts if shift > 0]


def grow_in_cloud(
    numbers: Ints, points: Floats, into: NDArray, seeds: NDArray, reach: float
) -> None:
    """
    Let parts spread to the points of `into` within `reach` of their nearest seed.

    Parameters
    ----------
    numbers : (N,) int32
        Changed in place.
    points : (N, 3) float64
    into, seeds : (A,), (B,) int
        Indices of points.
    reach : float
    """
    if not len(into) or not len(seeds):
        return
    distance, nearest = cKDTree(points[seeds]).query(points[into], distance_upper_bound=reach)
    hit = np.isfinite(distance)
    numbers[into[hit]] = numbers[seeds[nearest[hit]]]
