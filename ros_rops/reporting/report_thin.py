# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Less of a cloud or of a surface, evenly: what a report that fits into a mail can show."""

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Floats, Ints

BITS = 16
"""Of each coordinate along the curve; so many has a position in the report, too."""
TRIES = 6
CLOSE_ENOUGH = 0.9
"""A surface is thin enough if it has so much of the vertices it may have, or more."""


def every_so_many(points: Floats, most: int) -> NDArray[np.int64]:
    """
    Return which points to keep: evenly along a curve that fills space (Morton's).

    Parameters
    ----------
    points : (N, 3) float64
    most : int

    Returns
    -------
    (min(N, most),) int64
        In the order of the curve, so that neighbours in space lie together in the file.
    """
    order = np.argsort(_along_curve(points), kind='stable')
    if len(order) <= most:
        return order
    return order[np.arange(most) * len(order) // most]


def _along_curve(points: Floats) -> NDArray[np.uint64]:
    """Return the place of each point on Morton's curve: the bits of its coordinates in turn."""
    if not len(points):
        return np.zeros(0, np.uint64)
    low = points.min(axis=0)
    edge = max(float((points.max(axis=0) - low).max()), np.finfo(float).tiny)
    cells = ((points - low) * ((2 ** BITS - 1) / edge)).astype(np.uint64)
    place = np.zeros(len(points), np.uint64)
    for axis in range(3):
        place |= _spread(cells[:, axis]) << np.uint64(axis)
    return place


def _spread(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Put two zeros before each of the lowest 21 bits."""
    for shift, mask in (
        (32, 0x1F00000000FFFF), (16, 0x1F0000FF0000FF), (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3), (2, 0x1249249249249249),
    ):
        values = (values | (values << np.uint64(shift))) & np.uint64(mask)
    return values


def cluster_vertices(
    vertices: Floats, faces: Ints, most: int
) -> tuple[NDArray[np.int64], Ints, NDArray[np.int64], float]:
    """
    Decimate a surface by vertex clustering (Rossignac and Borrel 1993).

    The vertices in a cell of a grid become one; faces that shrink to an edge go.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int32
    most : int
        Vertices that may remain.

    Returns
    -------
    groups : (V,) int64
        New vertex of each vertex, 0 to the number of new vertices less one.
    faces : (G, 3) int32
        Of the new vertices, each triangle once.
    kept : (G,) int64
        The face that each of them was.
    cell : float
        Edge of the grid's cells; 0 if all vertices remain.
    """
    if len(vertices) <= most:
        return np.arange(len(vertices)), faces, np.arange(len(faces)), 0.0
    groups, cell = _fitting_grid(vertices, most)
    merged = groups[faces]
    whole = (
        (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2])
        & (merged[:, 2] != merged[:, 0]))
    kept, merged = np.flatnonzero(whole), merged[whole]
    merged, once = np.unique(smallest_first(merged), axis=0, return_index=True)
    return groups, merged.astype(np.int32), kept[once], cell


def smallest_first(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return triangles (F, 3) with their smallest corner first, their sense of rotation kept."""
    first = faces.argmin(axis=1)
    turned: NDArray[np.int64] = faces[
        np.arange(len(faces))[:, None], (first[:, None] + np.arange(3)) % 3]
    return turned


def _fitting_grid(vertices: Floats, most: int) -> tuple[NDArray[np.int64], float]:
    """Return the cell of each vertex, in a grid of at most `most` cells that are not empty."""
    low = vertices.min(axis=0)
    extent = float((vertices.max(axis=0) - low).max())
    cell = extent / max(np.sqrt(most / 4.0), 1.0)
    best: tuple[NDArray[np.int64], float] | None = None
    for k in range(64):
        groups, count = _cells(vertices, low, cell)
        if count <= most and (best is None or cell < best[1]):
            best = groups, cell
        if best is not None and (count >= CLOSE_ENOUGH * most or k >= TRIES):
            break
        # A surface has as many cells as its area holds, so their edge goes with the root.
        cell *= min(max(np.sqrt(count / (0.96 * most)), 0.5), 2.0)
        if best is None and k >= TRIES:
            cell *= 1.2
    if best is None:  # not so many bits in a number that this could happen
        return np.zeros(len(vertices), np.int64), extent
    return best


def _cells(
    vertices: Floats, low: Floats, cell: float
) -> tuple[NDArray[np.int64], int]:
    at = ((vertices - low) / cell).astype(np.int64)
    width = at.max(axis=0) + 1
    keys = (at[:, 0] * width[1] + at[:, 1]) * width[2] + at[:, 2]
    found, groups = np.unique(keys, return_inverse=True)
    return groups.reshape(-1), len(found)


def means(values: NDArray, groups: NDArray[np.int64]) -> Floats:
    """Return the mean of the values (N, C) of each group."""
    count = np.bincount(groups)
    return np.stack([
        np.bincount(groups, column) / count for column in values.astype(np.float64).T], axis=1)


def spacing(points: Floats) -> float:
    """Return how far apart points on a surface lie: the median distance to the fourth nearest."""
    from scipy.spatial import cKDTree

    if len(points) < 5:
        return float(np.ptp(points, axis=0).max()) / 4 if len(points) else 0.0
    some = points[::max(1, len(points) // 2000)]
    distances, _ = cKDTree(points).query(some, k=5)
    return float(np.median(distances[:, 4]))
