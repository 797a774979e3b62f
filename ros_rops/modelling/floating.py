# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The pieces that a surface consists of: which way is out, and which of them are none."""

import math

import numpy as np
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.kernels.winding import Winding
from ros_rops.modelling.products import Fact
from ros_rops.modelling.topology import (
    areas, face_components, face_vectors, Longs, six_volumes, turned)
from ros_rops.modelling.weights import RAMP_MR
from scipy.spatial import cKDTree

_INSIDE = 0.5
"""Winding number from which a point lies within a closed piece."""
_PROBES = 8
"""Vertices of a piece that are asked whether they lie within another."""


def turned_outwards(
    vertices: Floats, faces: Ints, mates: Longs, normals: Floats
) -> tuple[Ints, Longs, Bools]:
    """
    Turn every piece outwards.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int32
        Neighbours turn the same way round.
    mates : (3F,) int64
    normals : (V, 3) float64
        Towards the sensors, zero where nothing is known; what an open piece goes by.

    Returns
    -------
    faces : (F, 3) int32
    mates : (3F,) int64
    cavity : (F,) bool
        Faces of closed pieces whose normals all the same point into them: the wall of a hollow.
    """
    count, piece = face_components(mates)
    volume = np.bincount(piece, six_volumes(vertices, faces), minlength=count)
    agreement = np.bincount(piece, np.einsum(
        'ij,ij->i', face_vectors(vertices, faces), normals[faces].sum(axis=1)), minlength=count)
    closed = _closed(piece, mates, count)
    turn = np.where(closed, volume < 0, agreement < 0)
    cavity = turn & closed & (agreement > 0)
    if count:
        # The largest piece holds no hollow: it was handed in inside out.
        cavity[np.argmax(np.bincount(piece, areas(vertices, faces)))] = False
    turn &= ~cavity
    return *turned(faces, mates, turn[piece]), cavity[piece]


def sound_pieces(
    vertices: Floats, faces: Ints, mates: Longs, cavity: Bools, resolution: float
) -> tuple[Bools, dict[str, Fact]]:
    """
    Tell which faces belong to pieces that are parts of the object.

    Parameters
    ----------
    vertices, faces, mates
        As `turned_outwards` returns and takes them.
    cavity : (F,) bool
    resolution : float

    Returns
    -------
    kept : (F,) bool
    facts : dict
        `floating_removed`, `floating_share` of the area, `hidden_removed`.
    """
    count, piece = face_components(mates)
    if not count:
        return np.zeros(0, bool), {
            'floating_removed': 0, 'floating_share': 0.0, 'hidden_removed': 0}
    area = np.bincount(piece, areas(vertices, faces), minlength=count).astype(np.float64)
    closed = _closed(piece, mates, count)
    floating = _floating(vertices, faces, mates, piece, area, closed, RAMP_MR * resolution)
    hidden = np.bincount(piece, cavity, minlength=count) > 0
    hidden &= ~floating
    hidden |= _enclosed(vertices, faces, piece, area, closed & ~hidden, floating | hidden)
    return ~(floating | hidden)[piece], {
        'floating_removed': int(floating.sum()),
        'floating_share': float(area[floating].sum() / max(area.sum(), np.finfo(float).tiny)),
        'hidden_removed': int(hidden.sum())}


def _closed(piece: Ints, mates: Longs, count: int) -> Bools:
    open_pieces = piece[np.flatnonzero(mates < 0) // 3]
    closed: Bools = np.bincount(open_pieces, minlength=count) == 0
    return closed


def _floating(
    vertices: Floats, faces: Ints, mates: Longs, piece: Ints, area: Floats, closed: Bools,
    reach: float,
) -> Bools:
    """
    Tell which pieces have no face farther than `reach` from their border; never the largest.

    What has less area than a disc of that radius has none; a closed piece has no border, and
    counts as if it were a ball.
    """
    floating = area < np.where(closed, 4.0, 1.0) * math.pi * reach ** 2
    largest = int(np.argmax(area))
    floating[largest] = False
    doubtful = ~closed & ~floating
    doubtful[largest] = False
    order = np.argsort(piece, kind='stable')
    first = np.searchsorted(piece[order], np.arange(len(area) + 1))
    rim = mates.reshape(-1, 3) < 0
    for number in np.flatnonzero(doubtful):
        own = order[first[number]:first[number + 1]]
        face, side = np.nonzero(rim[own])
        border = np.unique(np.concatenate([
            faces[own[face], side], faces[own[face], (side + 1) % 3]]))
        distance, _ = cKDTree(vertices[border]).query(
            vertices[np.unique(faces[own])], distance_upper_bound=reach)
        floating[number] = bool(np.isfinite(distance).all())
    return floating


def _enclosed(
    vertices: Floats, faces: Ints, piece: Ints, area: Floats, closed: Bools, gone: Bools
) -> Bools:
    """Tell which pieces lie within a larger closed one, where no line of sight ends."""
    enclosed = np.zeros(len(area), dtype=bool)
    if len(area) == 1 or not closed.any():
        return enclosed
    order = np.argsort(piece, kind='stable')
    first = np.searchsorted(piece[order], np.arange(len(area) + 1))
    corners = vertices[faces[order]]
    low = np.minimum.reduceat(corners.min(axis=1), first[:-1])
    high = np.maximum.reduceat(corners.max(axis=1), first[:-1])
    for number in np.flatnonzero(~gone):
        around = closed & ~gone & (area > area[number])
        around &= (low <= low[number]).all(axis=1) & (high >= high[number]).all(axis=1)
        for outer in np.flatnonzero(around):
            probes = np.unique(faces[order[first[number]:first[number + 1]]])
            probes = probes[np.linspace(0, len(probes) - 1, _PROBES).astype(int)]
            walls = faces[order[first[outer]:first[outer + 1]]]
            turns = Winding.of(vertices, walls).at(vertices[probes], threads=1)
            enclosed[number] |= bool(turns.min() > _INSIDE)
    return enclosed
