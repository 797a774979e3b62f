# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
How the faces of a triangle mesh hang together.

The side k of face f, from its vertex k to the next, is number 3 f + k; two sides that are sewn
together are each other's mate.
"""

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Floats, Ints
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

Longs = NDArray[np.int64]

_NEXT = np.array([1, 2, 0])


def following(sides: Longs) -> Longs:
    """Return the side after each of `sides` in its face."""
    result: Longs = sides - sides % 3 + _NEXT[sides % 3]
    return result


def ends(faces: Ints) -> tuple[Longs, Longs]:
    """Return the vertices at which each side of `faces` (F, 3) begins and ends, (3F,) each."""
    begin = faces.astype(np.int64).ravel()
    return begin, faces[:, _NEXT].astype(np.int64).ravel()


def turned(faces: Ints, mates: Longs, which: Bools) -> tuple[Ints, Longs]:
    """Turn `which` (F,) of the faces round: their sides 0 and 1 change places."""
    if not which.any():
        return faces, mates
    sides = np.arange(faces.size)
    place = sides + np.where(np.repeat(which, 3), np.tile([1, -1, 0], len(faces)), 0)
    moved = np.empty_like(mates)
    moved[place] = np.where(mates < 0, -1, place[mates])
    return np.where(which[:, None], faces[:, ::-1], faces), moved


def grouped_sides(faces: Ints) -> tuple[Longs, Longs]:
    """
    Sort the sides of `faces` (F, 3) by the edge that they lie on.

    Returns
    -------
    order : (3F,) int64
        Sides, those of one edge together, in rising order.
    first : (E + 1,) int64
        Where each edge begins in `order`, and the end.
    """
    begin, end = ends(faces)
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    keys = low * (int(high.max(initial=0)) + 1) + high
    order = np.argsort(keys, kind='stable')
    keys = keys[order]
    new = np.flatnonzero(keys[1:] != keys[:-1]) + 1
    return order, np.concatenate([[0], new, [len(keys)]]) if len(keys) else np.zeros(1, np.int64)


def simple_mates(faces: Ints, order: Longs, first: Longs) -> Longs:
    """Return the mate of each side (3F,) where an edge has two faces, else -1."""
    mates = np.full(faces.size, -1, dtype=np.int64)
    twos = first[:-1][np.diff(first) == 2]
    one, other = order[twos], order[twos + 1]
    mates[one], mates[other] = other, one
    return mates


def linked(count: int, one: Longs, other: Longs) -> tuple[int, Ints]:
    """Return how many groups `count` things form by the links one-other, and each one's group."""
    graph = coo_matrix((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    number, labels = connected_components(graph, directed=False)
    return int(number), labels


def face_components(mates: Longs) -> tuple[int, Ints]:
    """Return how many pieces the faces form across their mates (3F,), and each one's piece."""
    sewn = np.flatnonzero(mates > np.arange(len(mates)))
    return linked(len(mates) // 3, sewn // 3, mates[sewn] // 3)


def fans(mates: Longs) -> tuple[int, Ints]:
    """
    Group the corners of faces that meet at one vertex, face by face across sewn sides.

    Returns
    -------
    count : int
    labels : (3F,) int32
        Of corner k of face f at 3 f + k. In a manifold every vertex is one fan.
    """
    sewn = np.flatnonzero(mates > np.arange(len(mates)))
    mate = mates[sewn]
    return linked(
        len(mates), np.concatenate([sewn, following(sewn)]),
        np.concatenate([following(mate), mate]))


def areas(vertices: Floats, faces: Ints) -> Floats:
    """Return the area of each face, (F,)."""
    length: Floats = np.linalg.norm(face_vectors(vertices, faces), axis=1)
    return length / 2


def face_vectors(vertices: Floats, faces: Ints) -> Floats:
    """Return each face's normal times twice its area, (F, 3)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    vectors: Floats = np.cross(b - a, c - a)
    return vectors


def vertex_normals(vertices: Floats, faces: Ints) -> Floats:
    """Return the area-weighted unit normal of each vertex, (V, 3); zero without a face."""
    vectors = face_vectors(vertices, faces)
    total = np.stack([
        np.bincount(faces.ravel(), np.repeat(vectors[:, k], 3), minlength=len(vertices))
        for k in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    normals: Floats = total / np.where(length > 0, length, 1.0)
    return normals


def six_volumes(vertices: Floats, faces: Ints) -> Floats:
    """Return six times each face's share of the volume enclosed, (F,)."""
    centred = vertices - vertices[:1]  # far from the origin rounding would eat the shares
    a, b, c = (centred[faces[:, k]] for k in range(3))
    shares: Floats = np.einsum('ij,ij->i', a, np.cross(b, c))
    return shares


def border_loops(faces: Ints, mates: Longs) -> tuple[int, Longs]:
    """
    Return how many loops the border of a manifold mesh forms, and its sides.

    Returns
    -------
    count : int
    sides : (B,) int64
        Those without a mate.
    """
    open_sides = np.flatnonzero(mates < 0)
    begin, end = ends(faces)
    begin, end = begin[open_sides], end[open_sides]
    used = np.unique(np.concatenate([begin, end]))
    count, _ = linked(len(used), np.searchsorted(used, begin), np.searchsorted(used, end))
    return count, open_sides


def compacted(faces: Ints, vertex_count: int) -> tuple[Ints, Longs]:
    """
    Leave out the vertices that no face uses.

    Returns
    -------
    faces : (F, 3) int32
    kept : (V',) int64
        Which of the vertices are left.
    """
    used: Bools = np.zeros(vertex_count, dtype=bool)
    used[faces.ravel()] = True
    number = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return number[faces], np.flatnonzero(used)
