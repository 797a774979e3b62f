# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Exact distances from points to a triangle mesh: the ruler that models are measured with.

It shares no code with what makes models.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Floats, Ints
from scipy.spatial import cKDTree

FIRST, MORE = 8, 4
"""So many pieces are looked at first, and so many times more wherever these do not suffice."""
CHUNK = 100_000
PIECES = 4.0
"""About as many pieces for each triangle, at most, when large triangles are cut up."""

Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Closest:
    """
    The nearest place of a surface to each of N points.

    Parameters
    ----------
    distance : (N,) float64
    foot : (N, 3) float64
    face : (N,) int
    weights : (N, 3) float64
        Barycentric: foot = sum of weights times the face's corners.
    """

    distance: Floats
    foot: Floats
    face: Indices
    weights: Floats


class Triangles:
    """
    A triangle mesh that tells the nearest place of its surface, exactly.

    A tree of the centres of its triangles (large ones cut into pieces) gives candidates; a point
    is done when no piece that was not looked at can be nearer, since no piece reaches further
    from its centre than the largest.

    Parameters
    ----------
    vertices : (V, 3) float64
        Those without a face are left out: they are no surface (bun_zipper has 1113 of them).
    faces : (F, 3) int

    Raises
    ------
    ShapeError
        If there is no triangle, or an index without a vertex.
    """

    def __init__(self, vertices: Floats, faces: Ints | Indices) -> None:
        faces = np.asarray(faces)
        if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces):
            raise ShapeError(f'faces: expected (F, 3), at least one, got {faces.shape}')
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise ShapeError(f'faces: indices must lie in 0 .. {len(vertices) - 1}')
        used, compact = np.unique(faces, return_inverse=True)
        self.vertices = np.asarray(vertices, dtype=np.float64)[used]
        self.faces = compact.reshape(-1, 3)
        self.corners = self.vertices[self.faces]
        crosses = np.cross(
            self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        lengths = np.linalg.norm(crosses, axis=1, keepdims=True)
        self.areas: Floats = lengths[:, 0] / 2
        self.normals: Floats = crosses / np.where(lengths > 0, lengths, 1.0)
        self.vertex_normals = _vertex_normals(self.corners, self.faces, self.normals,
                                              len(self.vertices))
        centres, self._radii, self._owners = _pieces(self.corners, float(self.areas.sum()))
        self._tree = cKDTree(centres)

    def closest(self, points: Floats) -> Closest:
        """Return the nearest place of the surface to each point, (N, 3) finite."""
        parts = [self._closest(part) for part in np.array_split(
            np.asarray(points, dtype=np.float64), len(points) // CHUNK + 1)]
        return Closest(*(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ('distance', 'foot', 'face', 'weights')))

    def _closest(self, points: Floats) -> Closest:
        best = Closest(
            np.full(len(points), np.inf), np.zeros((len(points), 3)),
            np.zeros(len(points), np.intp), np.zeros((len(points), 3)))
        open_, most, reach = np.arange(len(points)), len(self._radii), float(self._radii.max())
        count = min(FIRST, most)
        while len(open_):
            away, found = self._tree.query(points[open_], k=np.arange(1, count + 1))
            for k in range(count):
                near = away[:, k] - self._radii[found[:, k]] < best.distance[open_]
                self._improve(best, points, open_[near], self._owners[found[near, k]])
            if count == most:
                break
            open_ = open_[away[:, -1] - reach < best.distance[open_]]
            count = min(count * MORE, most)
        return best

    def _improve(self, best: Closest, points: Floats, rows: Indices, faces: Indices) -> None:
        weights = nearest_weights(points[rows], self.corners[faces])
        foot = np.einsum('nk,nkd->nd', weights, self.corners[faces])
        distance = np.linalg.norm(points[rows] - foot, axis=1)
        nearer = distance < best.distance[rows]
        changed = rows[nearer]
        best.distance[changed] = distance[nearer]
        best.foot[changed] = foot[nearer]
        best.face[changed] = faces[nearer]
        best.weights[changed] = weights[nearer]

    def normals_at(self, closest: Closest) -> Floats:
        """Return unit normals interpolated between the vertices, (N, 3)."""
        normals = np.einsum(
            'nk,nkd->nd', closest.weights, self.vertex_normals[self.faces[closest.face]])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        result: Floats = normals / np.where(lengths > 0, lengths, 1.0)
        return result

    def samples(self, count: int, seed: int = 0) -> tuple[Floats, Indices]:
        """Return points spread evenly over the area, (count, 3), and their faces, (count,)."""
        rng = np.random.default_rng(seed)
        up_to = np.cumsum(self.areas)
        # One in each of so many equal shares of the area: less chance than drawing freely.
        drawn = (np.arange(count) + rng.random(count)) / count * up_to[-1]
        faces = np.minimum(np.searchsorted(up_to, drawn, side='right'), len(self.faces) - 1)
        root, second = np.sqrt(rng.random(count)), rng.random(count)
        weights = np.stack([1 - root, root * (1 - second), root * second], axis=1)
        return np.einsum('nk,nkd->nd', weights, self.corners[faces]), faces


def nearest_weights(points: Floats, corners: Floats) -> Floats:
    """
    Return where in each triangle the nearest place to a point lies.

    Parameters
    ----------
    points : (N, 3) float64
    corners : (N, 3, 3) float64
        One triangle a point; may be degenerate.

    Returns
    -------
    (N, 3) float64
        Barycentric weights, none negative.
    """
    weights, inside = _above(points, corners)
    rest = np.flatnonzero(~inside)
    nearest = np.full(len(rest), np.inf)
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start = corners[rest, first]
        along = corners[rest, second] - start
        square = np.einsum('nd,nd->n', along, along)
        offset = points[rest] - start
        t = np.clip(
            np.einsum('nd,nd->n', offset, along) / np.where(square > 0, square, 1.0), 0.0, 1.0)
        gap = offset - t[:, None] * along
        distance = np.einsum('nd,nd->n', gap, gap)
        nearer = distance < nearest
        nearest[nearer] = distance[nearer]
        chosen = rest[nearer]
        weights[chosen] = 0.0
        weights[chosen, first], weights[chosen, second] = 1 - t[nearer], t[nearer]
    return weights


def _above(points: Floats, corners: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return barycentric weights of the points' projections, and which lie inside."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = points - corners[:, 0]
    aa, ab, bb = (np.einsum('nd,nd->n', x, y) for x, y in ((a, a), (a, b), (b, b)))
    ap, bp = np.einsum('nd,nd->n', a, p), np.einsum('nd,nd->n', b, p)
    total = aa * bb - ab * ab
    flat = ~(total > 1e-14 * aa * bb)
    safe = np.where(flat, 1.0, total)
    v, w = (bb * ap - ab * bp) / safe, (aa * bp - ab * ap) / safe
    weights = np.stack([1 - v - w, v, w], axis=1)
    return weights, (weights >= 0).all(axis=1) & ~flat


def _vertex_normals(
    corners: Floats, faces: Indices, normals: Floats, count: int
) -> Floats:
    """Return normals weighted by angle: their sign tells the side, at edges and corners too."""
    result = np.zeros((count, 3))
    for k in range(3):
        one = corners[:, (k + 1) % 3] - corners[:, k]
        two = corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(
            np.linalg.norm(np.cross(one, two), axis=1), np.einsum('nd,nd->n', one, two))
        for axis in range(3):
            result[:, axis] += np.bincount(
                faces[:, k], angle * normals[:, axis], minlength=count)
    lengths = np.linalg.norm(result, axis=1, keepdims=True)
    unit: Floats = result / np.where(lengths > 0, lengths, 1.0)
    return unit


def _pieces(corners: Floats, area: float) -> tuple[Floats, Floats, Indices]:
    """Cut large triangles up; return centres, radii about these and the triangles they are of."""
    owners = np.arange(len(corners))
    radii = _radii(corners)
    limit = max(2 * float(np.median(radii)), np.sqrt(area / (PIECES * len(corners))))
    done: list[tuple[Floats, Indices]] = []
    while len(corners):
        large = _radii(corners) > limit if limit > 0 else np.zeros(len(corners), bool)
        done.append((corners[~large], owners[~large]))
        corners, owners = _quarters(corners[large]), np.repeat(owners[large], 4)
    every = np.concatenate([piece for piece, _ in done])
    return every.mean(axis=1), _radii(every), np.concatenate([owner for _, owner in done])


def _radii(corners: Floats) -> Floats:
    radii: Floats = np.linalg.norm(
        corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1, initial=0.0)
    return radii


def _quarters(corners: Floats) -> Floats:
    a, b, c = (corners[:, k] for k in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    quarters = np.stack([
        np.stack(one, axis=1)
        for one in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))], axis=1)
    return quarters.reshape(-1, 3, 3)
