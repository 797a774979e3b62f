# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The voxels of a volume by their place, and room for more of them."""

from itertools import product

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Ints
from ros_rops.kernels.volume import BRICK, Distances
from ros_rops.modelling.topology import Longs

_VOXELS = BRICK ** 3
_OFFSET, _BITS = 1 << 20, 21
CORNERS = np.array(list(product((0, 1), repeat=3)))
"""The eight corners of a cube of voxels, from its first; (8, 3)."""


class Lattice:
    """
    Values of voxels, of which bricks are added as they are asked for.

    Parameters
    ----------
    distances : Distances
        What is known to begin with.
    """

    def __init__(self, distances: Distances) -> None:
        self._bricks = np.asarray(distances.bricks, dtype=np.int64)
        self.values = distances.values.reshape(-1).copy()
        self.known = np.isfinite(self.values)
        self._index()

    def _index(self) -> None:
        keys = _packed(self._bricks)
        self._order = np.argsort(keys)
        self._keys = keys[self._order]

    def _brick_slots(self, bricks: Longs) -> Longs:
        keys = _packed(bricks)
        at = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        return np.where(self._keys[at] == keys, self._order[at], -1)

    def slots(self, voxels: Longs) -> Longs:
        """Return where the values of `voxels` (..., 3) are; bricks that lack are added, NaN."""
        bricks, places = np.divmod(voxels, BRICK)
        found = self._brick_slots(bricks)
        if (found < 0).any():
            fresh = np.unique(bricks[found < 0], axis=0)
            self._bricks = np.concatenate([self._bricks, fresh])
            room = len(fresh) * _VOXELS
            self.values = np.concatenate([self.values, np.full(room, np.nan, np.float32)])
            self.known = np.concatenate([self.known, np.zeros(room, dtype=bool)])
            self._index()
            found = self._brick_slots(bricks)
        slots: Longs = (
            (found * BRICK + places[..., 0]) * BRICK + places[..., 1]) * BRICK + places[..., 2]
        return slots

    def corners(self, cubes: Longs) -> Longs:
        """Return where the values at the corners of `cubes` (M, 3) are, (M, 8)."""
        return self.slots(cubes[:, None] + CORNERS)

    def complete(self, cubes: Longs, steepest: float = np.inf) -> Bools:
        """
        Tell of which `cubes` (M, 3) all corners were known to begin with.

        Of these only such as have no corners that differ by more than `steepest`.
        """
        corners = self.corners(cubes)  # first: it may make room
        known: Bools = np.all(self.known[corners], axis=1)
        known &= np.ptp(self.values[corners], axis=1) <= steepest
        return known

    def distances(self) -> Distances:
        """Return all of it as a volume has it."""
        values: NDArray[np.float32] = self.values.reshape(-1, BRICK, BRICK, BRICK)
        bricks: Ints = self._bricks.astype(np.int32)
        return Distances(bricks, values)


def _packed(bricks: Longs) -> Longs:
    shifted = bricks.astype(np.int64) + _OFFSET
    keys: Longs = (shifted[..., 0] << 2 * _BITS) | (shifted[..., 1] << _BITS) | shifted[..., 2]
    return keys
