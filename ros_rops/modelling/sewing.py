# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Faces of any kind sewn to a manifold: consistent turns, two faces an edge, one fan a vertex."""

from typing import NamedTuple

import numpy as np
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.modelling.topology import (
    areas, ends, fans, following, grouped_sides, linked, Longs, simple_mates)

_MOST_ROUNDS = 16


class Sewn(NamedTuple):
    """
    A manifold mesh, made of another.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int32
    mates : (3F,) int64
        Side sewn to each side, -1 at the border.
    sources : (V,) int64
        Vertex of the other mesh that each vertex is, or is next to.
    origins : (F,) int64
        Face of the other mesh of which each one is (part).
    crowded_edges : int
        Edges of more than two faces that were taken apart.
    split_vertices : int
        Vertices added where several fans met in one.
    """

    vertices: Floats
    faces: Ints
    mates: Longs
    sources: Longs
    origins: Longs
    crowded_edges: int
    split_vertices: int


def true_faces(vertices: Floats, faces: Ints) -> tuple[Ints, Longs]:
    """
    Leave out faces that are none: without extent, or covering each other.

    Vertices at the two ends of an edge without length become one. Of faces with the same three
    vertices one is left if most turn its way, none if as many turn either way (a fold): what
    was closed stays so.

    Returns
    -------
    faces : (F', 3) int32
    origins : (F',) int64
        Which of `faces` they are.
    """
    begin, end = ends(faces)
    null = (vertices[begin] == vertices[end]).all(axis=1) & (begin != end)
    if null.any():
        _, group = linked(len(vertices), begin[null], end[null])
        least = np.full(int(group.max()) + 1, len(vertices), dtype=np.int64)
        np.minimum.at(least, group, np.arange(len(vertices)))
        faces = least[group].astype(np.int32)[faces]
    a, b, c = faces.T
    origins = np.flatnonzero((a != b) & (b != c) & (c != a))
    kept = origins[_net(faces[origins])]
    return faces[kept], kept


def _net(faces: Ints) -> Longs:
    """Return which faces are left when those with the same vertices are set off."""
    ordered = np.sort(faces, axis=1).astype(np.int64)
    base = int(ordered.max(initial=0)) + 1
    first = np.argmin(faces, axis=1)
    rows = np.arange(len(faces))
    even = faces[rows, (first + 1) % 3] < faces[rows, (first + 2) % 3]
    turn = np.where(even, 1, -1)
    # Two numbers tell three vertices: 64 bits do not hold three.
    order = np.lexsort((ordered[:, 2], ordered[:, 0] * base + ordered[:, 1]))
    same = (ordered[order[1:]] == ordered[order[:-1]]).all(axis=1)
    group = np.concatenate([[0], np.cumsum(~same)]) if len(faces) else np.zeros(0, np.int64)
    if not same.any():
        return rows
    balance = np.bincount(group, turn[order])[group]
    wanted = order[np.sign(balance) == turn[order]]
    _, at = np.unique(group[np.sign(balance) == turn[order]], return_index=True)
    return np.sort(wanted[at])


def sewn(vertices: Floats, faces: Ints) -> Sewn:
    """
    Make a manifold of faces (F, 3): whatever they are, without moving or leaving out any.

    Neighbours turn the same way round; where a piece has no two sides (a Moebius strip) it is
    cut. Where more than two faces share an edge, those that enclose matter between them stay
    together. Vertices in which only points of fans touch are doubled.
    """
    order, first = grouped_sides(faces)
    flip = consistent_flips(vertices, faces, simple_mates(faces, order, first))
    if flip.any():
        faces = np.where(flip[:, None], faces[:, ::-1], faces)
        order, first = grouped_sides(faces)
    sources, origins = np.arange(len(vertices)), np.arange(len(faces))
    crowded, split = int(np.count_nonzero(np.diff(first) > 2)), 0
    for _ in range(_MOST_ROUNDS):
        mates = _mates(vertices, faces, order, first)
        faces, origin = _parted(faces, mates)
        split += int(np.count_nonzero(origin[1:] == origin[:-1]))
        vertices, sources = vertices[origin], sources[origin]
        units = _surplus(*grouped_sides(faces), mates) if crowded else np.zeros(0, np.int64)
        if not len(units):
            break
        vertices, faces, sources, added = _halved(vertices, faces, sources, units, mates)
        origins = np.concatenate([origins, origins[added]])
        order, first = grouped_sides(faces)
    return Sewn(vertices, faces, mates, sources, origins, crowded, split)


def consistent_flips(vertices: Floats, faces: Ints, mates: Longs) -> Bools:
    """
    Tell which faces (F,) to turn round so that neighbours agree; of two ways the less area.

    Every face is taken twice, as it is and turned; neighbours that agree are linked as they are,
    others crosswise. What hangs together then agrees.
    """
    count = len(faces)
    begin, _ = ends(faces)
    sides = np.flatnonzero(mates > np.arange(len(mates)))
    one, other = sides // 3, mates[sides] // 3
    clash = begin[sides] == begin[mates[sides]]
    if not clash.any():
        return np.zeros(count, dtype=bool)
    shift = np.where(clash, count, 0)
    _, labels = linked(
        2 * count, np.concatenate([one, one + count]),
        np.concatenate([other + shift, other + count - shift]))
    upright, turned = labels[:count], labels[count:]
    area = np.bincount(upright, areas(vertices, faces), minlength=int(labels.max()) + 1)
    mine, theirs = area[upright], area[turned]
    flip: Bools = (mine < theirs) | ((mine == theirs) & (upright > turned))
    return flip


def _mates(vertices: Floats, faces: Ints, order: Longs, first: Longs) -> Longs:
    """Pair the sides of every edge: at most one partner each, turned the other way."""
    mates = simple_mates(faces, order, first)
    begin, end = ends(faces)
    sides = np.flatnonzero(mates >= 0)
    mates[sides[begin[sides] == begin[mates[sides]]]] = -1
    for at in np.flatnonzero(np.diff(first) > 2):
        group = order[first[at]:first[at + 1]]
        one, other = _around(vertices, faces, group, begin, end)
        mates[one], mates[other] = other, one
    return mates


def _around(
    vertices: Floats, faces: Ints, group: Longs, begin: Longs, end: Longs
) -> tuple[Longs, Longs]:
    """
    Pair the sides on one edge so that matter lies between the two of a pair.

    Seen along the edge, a face that runs with it has its inside at smaller angles, one that runs
    against it at larger ones: the two match like brackets on a ring.
    """
    low, high = min(begin[group[0]], end[group[0]]), max(begin[group[0]], end[group[0]])
    axis = vertices[high] - vertices[low]
    apex = vertices[faces.ravel()[following(following(group))]] - vertices[low]
    x = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    y = np.cross(axis, x) / max(float(np.linalg.norm(axis)), np.finfo(float).tiny)
    ring = group[np.argsort(np.arctan2(apex @ y, apex @ x), kind='stable')]
    waiting: list[int] = []
    pairs: dict[int, int] = {}
    for side in (*ring, *ring):
        if side in pairs or side in pairs.values():
            continue
        if begin[side] != low:
            if side not in waiting:
                waiting.append(int(side))
        elif waiting:
            pairs[waiting.pop()] = int(side)
    return np.array(list(pairs), np.int64), np.array(list(pairs.values()), np.int64)


def _parted(faces: Ints, mates: Longs) -> tuple[Ints, Longs]:
    """Give every fan a vertex of its own; return the faces and which vertex each was."""
    _, labels = fans(mates)
    _, corner = np.unique(labels, return_index=True)
    origin = faces.ravel()[corner].astype(np.int64)
    order = np.lexsort((corner, origin))
    number = np.empty(len(order), dtype=np.int32)
    number[order] = np.arange(len(order), dtype=np.int32)
    return number[labels].reshape(-1, 3), origin[order]


def _surplus(order: Longs, first: Longs, mates: Longs) -> Longs:
    """Return sides, one of each pair, that still share both vertices with another pair."""
    surplus: list[int] = []
    for at in np.flatnonzero(np.diff(first) > 2):
        units = [side for side in order[first[at]:first[at + 1]] if mates[side] < side]
        surplus.extend(units[1:])
    return np.array(surplus, np.int64)


def _halved(
    vertices: Floats, faces: Ints, sources: Longs, units: Longs, mates: Longs
) -> tuple[Floats, Ints, Longs, Longs]:
    """Put a vertex into the middle of each edge in `units`, once a face at most."""
    taken, cut = set[int](), []
    for side in units:
        pair = [int(s) for s in (side, mates[side]) if s >= 0]
        if not taken & {s // 3 for s in pair}:
            taken |= {s // 3 for s in pair}
            cut.append(pair)
    begin, end = ends(faces)
    one, other = np.array([(begin[pair[0]], end[pair[0]]) for pair in cut]).T
    sides = np.array([side for pair in cut for side in pair])
    middle = len(vertices) + np.repeat(np.arange(len(cut)), [len(pair) for pair in cut])
    halves = np.stack([middle, end[sides], begin[following(following(sides))]], axis=1)
    faces = faces.copy()
    faces.ravel()[following(sides)] = middle
    return (
        np.concatenate([vertices, (vertices[one] + vertices[other]) / 2]),
        np.concatenate([faces, halves.astype(np.int32)]),
        np.concatenate([sources, sources[one]]), sides // 3)
