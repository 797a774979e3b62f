# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What rival descriptors of ours look at: supports, normals of windows, curvatures, histograms."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Floats, Ints, RangeMesh
from scipy.spatial import cKDTree

# Vertices whose surfaces are fitted together, to bound the memory.
BATCH = 8192


@dataclass(frozen=True, slots=True)
class Supports:
    """
    Neighbours of keypoints, as pairs.

    Parameters
    ----------
    owner : (P,) int64
        Row of the keypoint, rising.
    member : (P,) int64
        Row of a neighbour among the points asked for.
    distance : (P,) float64
    """

    owner: NDArray[np.int64]
    member: NDArray[np.int64]
    distance: Floats


def supports_of(points: Floats, centres: Floats, radius: float, *, threads: int) -> Supports:
    """
    Find the points (N, 3) within `radius` of each centre (K, 3), the centre itself left out.

    Parameters
    ----------
    points, centres : (N, 3), (K, 3) float64
    radius : float
    threads : int
        0 takes all cores; no influence on the result.
    """
    lists = cKDTree(points).query_ball_point(
        centres, radius, workers=threads or -1, return_sorted=True)
    owner = np.repeat(np.arange(len(centres)), [len(one) for one in lists])
    member = np.concatenate([np.asarray(one, np.int64) for one in lists] or [owner])
    distance = np.linalg.norm(points[member] - centres[owner], axis=1)
    others = distance > 0
    return Supports(owner[others], member[others], distance[others])


def surface_of(mesh: RangeMesh, indices: Ints) -> tuple[Floats, Floats, Ints]:
    """Return points and normals (N, 3) of the vertices with a face, and `indices` among them."""
    used = mesh.normals.any(axis=1)
    rank = np.cumsum(used) - 1
    return mesh.vertices[used], mesh.normals[used], rank[indices]


def shape_indices(points: Floats, normals: Floats, nearest: int, *, threads: int) -> Floats:
    """
    Return the shape index at every point, from a quadratic surface fitted to its `nearest` points.

    Parameters
    ----------
    points, normals : (N, 3) float64
    nearest : int
    threads : int

    Returns
    -------
    (N,) float64
        1/2 - 1/pi atan((k1 + k2) / (k1 - k2)), k1 >= k2, curvatures positive where the surface
        bends towards its normal: 0 in a cup, 1/2 on a saddle, 1 on a cap.
    """
    low, high = curvatures(points, normals, nearest, threads=threads).T
    return 0.5 - np.arctan2(low + high, high - low) / np.pi


def curvatures(points: Floats, normals: Floats, nearest: int, *, threads: int) -> Floats:
    """
    Fit quadratic surfaces and return their principal curvatures, the lower first.

    Parameters and sign as for `shape_indices`; (N, 2) float64.
    """
    distance, neighbours = cKDTree(points).query(
        points, k=min(nearest, len(points)), workers=threads or -1)
    found = np.empty((len(points), 2))
    for begin in range(0, len(points), BATCH):
        rows = slice(begin, begin + BATCH)
        scale = distance[rows, -1]
        offsets = points[neighbours[rows]] - points[rows, None]
        found[rows] = _fitted(offsets / scale[:, None, None], normals[rows]) / scale[:, None]
    return found


def _fitted(offsets: Floats, normals: Floats) -> Floats:
    """Return principal curvatures (B, 2) of z = a + b x + c y + d x^2 + e x y + f y^2."""
    x_axis = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
    x_axis /= np.linalg.norm(x_axis, axis=1, keepdims=True)
    axes = np.stack([x_axis, np.cross(normals, x_axis), normals], axis=2)
    x, y, z = np.moveaxis(offsets @ axes, 2, 0)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)
    across = np.swapaxes(terms, 1, 2)
    # The ridge settles degenerate neighbourhoods (points in a line) as flat.
    matrix = across @ terms + 1e-9 * np.eye(6)
    fit = np.linalg.solve(matrix, across @ z[:, :, None])[:, :, 0]
    b, c, d, e, f = fit[:, 1:].T
    second = np.stack([2 * d, e, e, 2 * f], axis=1).reshape(-1, 2, 2)
    first = np.stack([1 + b * b, b * c, b * c, 1 + c * c], axis=1).reshape(-1, 2, 2)
    # Curvatures are the eigenvalues of first^-1 second / sqrt(det first).
    shape = np.linalg.solve(first, second) / np.sqrt(1 + b * b + c * c)[:, None, None]
    half = 0.5 * np.trace(shape, axis1=1, axis2=2)
    spread = np.sqrt(np.maximum(half * half - np.linalg.det(shape), 0.0))
    return np.stack([half - spread, half + spread], axis=1)


def window_normals(points: Floats, normals: Floats, centres: Ints, radius: float, *,
                   threads: int) -> Floats:
    """
    Return the normals of planes fitted to all points within `radius` (least squares).

    Parameters
    ----------
    points, normals : (N, 3) float64
    centres : (K,) int
        Rows of `points`.
    radius : float
    threads : int

    Returns
    -------
    (K, 3) float64
        Unit, on the side of the centre's own normal.
    """
    found = supports_of(points, points[centres], radius, threads=threads)
    offsets = points[found.member] - points[centres][found.owner]
    count = np.bincount(found.owner, minlength=len(centres)) + 1.0  # the centre is one of them
    mean = summed(found.owner, offsets, len(centres)) / count[:, None]
    products = (offsets[:, :, None] * offsets[:, None, :]).reshape(-1, 9)
    moments = summed(found.owner, products, len(centres)).reshape(-1, 3, 3)
    spread = moments / count[:, None, None] - mean[:, :, None] * mean[:, None, :]
    plane = np.linalg.eigh(spread)[1][:, :, 0]
    side = np.einsum('kd,kd->k', plane, normals[centres])
    turned: Floats = np.where(side < 0, -1.0, 1.0)[:, None] * plane
    return turned


def summed(owner: NDArray[np.int64], values: Floats, rows: int) -> Floats:
    """Return the sum of the values (P, D) of each owner, (rows, D)."""
    return np.stack([
        np.bincount(owner, weights=column, minlength=rows) for column in values.T], axis=1)


def histograms(
    owner: NDArray[np.int64], values: Floats, weights: Floats, rows: int, bins: tuple[int, ...]
) -> NDArray[np.float32]:
    """
    Make histograms of values in 0..1, shared linearly between neighbouring bins; each sums to 1.

    Parameters
    ----------
    owner : (P,) int64
        The histogram that a value goes into.
    values : (P, A) float64
        One column an axis.
    weights : (P,) float64
    rows : int
    bins : tuple of int
        Of each axis.

    Returns
    -------
    (rows, product of bins) float32
        Zeros where nothing goes in.
    """
    shape = np.asarray(bins)
    # The centre of the first bin is 0, that of the last 1.
    place = np.clip(values, 0.0, 1.0) * (shape - 1)
    low = np.minimum(place.astype(np.int64), np.maximum(shape - 2, 0))
    part = place - low
    table = np.zeros(rows * int(shape.prod()))
    for corner in np.ndindex(*(2,) * len(bins)):
        at = np.ravel_multi_index(tuple(np.minimum(low + corner, shape - 1).T), bins)
        share = np.where(corner, part, 1.0 - part).prod(axis=1) * weights
        table += np.bincount(owner * int(shape.prod()) + at, share, minlength=len(table))
    table = table.reshape(rows, -1)
    total = table.sum(axis=1, keepdims=True)
    return (table / np.where(total > 0, total, 1.0)).astype(np.float32)
