# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Holes of a volume's surface closed.

What no view saw counts as matter where the surface that was seen surrounds it, in more than half
of all directions (its winding number, Jacobson et al. 2013), and as empty elsewhere. What a view
saw to be empty stays so (Curless and Levoy 1996, 4).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.kernels.sight import Sight
from ros_rops.kernels.volume import Distances
from ros_rops.kernels.winding import Winding
from ros_rops.modelling.lattice import CORNERS, Lattice
from ros_rops.modelling.topology import grouped_sides, Longs, simple_mates

HALF = 0.5
_STEPS = np.concatenate([np.eye(3, dtype=np.int64), -np.eye(3, dtype=np.int64)])
_WALLS = np.array([
    [k for k, corner in enumerate(CORNERS) if corner[axis] == side]
    for side in (1, 0) for axis in range(3)])
"""Corners of the wall towards each of `_STEPS`, (6, 4)."""


class Frame(NamedTuple):
    """
    Where a volume's voxels are.

    Parameters
    ----------
    origin : (3,) float64
    voxel : float
    band : float
        Distance from the surface within which voxels count.
    """

    origin: Floats
    voxel: float
    band: float


def filled_volume(
    distances: Distances, vertices: Floats, faces: Ints, sights: Sequence[Sight], frame: Frame,
    *, threads: int = 0,
) -> Distances:
    """
    Return the volume with values wherever the surface needs them to close.

    From the border of the surface on, cube by cube: the corners of a cube that nobody knows get
    a value, and the surface goes on through the walls whose corners differ. It ends nowhere, and
    is inside of the convex hull of what was seen.

    Parameters
    ----------
    distances : Distances
        NaN where nothing is known.
    vertices : (V, 3) float64
    faces : (F, 3) int32
        Of the surface extracted from it, outwards, without floating pieces.
    sights : sequence of Sight
        Of all views.
    frame : Frame
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    Distances
        The known values, and new ones.
    """
    lattice = Lattice(distances)
    around = _Around(Winding.of(vertices, faces), sights, frame, threads)
    homes = _cubes((vertices - frame.origin) / frame.voxel, faces)
    done = set_of(homes)
    rim = np.flatnonzero(simple_mates(faces, *grouped_sides(faces)) < 0) // 3
    front = np.unique(homes[rim], axis=0)
    while len(front):
        corners = lattice.corners(front)
        missing = corners[np.isnan(lattice.values[corners])]
        if len(missing):
            voxels = (front[:, None] + CORNERS)[np.isnan(lattice.values[corners])]
            slots, first = np.unique(missing, return_index=True)
            lattice.values[slots] = around.values(voxels[first])
        inside = lattice.values[corners] < 0
        walls = inside[:, _WALLS]
        cube, step = np.nonzero(walls.any(axis=2) & ~walls.all(axis=2))
        front, done = fresh(front[cube] + _STEPS[step], done)
    return lattice.distances()


def filled_faces(
    distances: Distances, vertices: Floats, faces: Ints, steepest: float = np.inf
) -> Bools:
    """
    Tell which faces (F,) of a surface lie in cubes where `extract` made none.

    Parameters
    ----------
    distances : Distances
        Before filling.
    vertices : (V, 3) float64
        In voxels from the volume's origin.
    faces : (F, 3) int32
    steepest : float
        As `extract` took it.
    """
    return ~Lattice(distances).complete(_cubes(vertices, faces), steepest)


class _Around(NamedTuple):
    """What is known of a voxel that no view measured."""

    winding: Winding
    sights: Sequence[Sight]
    frame: Frame
    threads: int

    def values(self, voxels: Longs) -> NDArray[np.float32]:
        """Return signed distances in voxels, (M,), of a kind: zero in the right place."""
        points = self.frame.origin + self.frame.voxel * voxels
        band = self.frame.band / self.frame.voxel
        turns = self.winding.at(points, threads=self.threads)
        value = 2 * band * (HALF - turns)
        for sight in self.sights:
            look = sight.look(points, reach=self.frame.band, threads=self.threads)
            clear = np.where(
                np.isposinf(look.distance), np.inf, look.distance * look.cosine)
            clear = np.minimum(clear / self.frame.voxel, band)
            value = np.where(clear > 1.0, np.maximum(value, clear), value)
        least = np.where(value < 0, -1e-3, 1e-3)
        return np.where(np.abs(value) < 1e-3, least, value).astype(np.float32)


def _cubes(places: Floats, faces: Ints) -> Longs:
    """Return the cube that each face lies in, (F, 3)."""
    cubes: Longs = np.floor(places[faces].mean(axis=1)).astype(np.int64)
    return cubes


def _key(cubes: Longs) -> Longs:
    shifted = cubes + (1 << 20)
    keys: Longs = (shifted[:, 0] << 42) | (shifted[:, 1] << 21) | shifted[:, 2]
    return keys


def set_of(cubes: Longs) -> Longs:
    """Return the cubes as a sorted set of keys."""
    return np.unique(_key(cubes))


def fresh(cubes: Longs, done: Longs) -> tuple[Longs, Longs]:
    """Return those of `cubes` that are not in `done`, each once, and `done` with them."""
    keys, first = np.unique(_key(cubes), return_index=True)
    at = np.minimum(np.searchsorted(done, keys), len(done) - 1)
    new = done[at] != keys
    return cubes[first[new]], np.insert(done, np.searchsorted(done, keys[new]), keys[new])
