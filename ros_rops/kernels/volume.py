# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the volume kernel: signed distances to what all views saw, near it only."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Floats, frozen, Ints
from ros_rops.kernels import _kernels
from ros_rops.kernels.meshes import check_mesh
from ros_rops.kernels.sight import Sight

BRICK = 8
"""Voxels along a side of a brick."""
BRICK_BYTES = 12 * BRICK**3
"""Memory of a brick: its sums, and the distances made of them."""


class Distances(NamedTuple):
    """
    What a volume knows.

    Parameters
    ----------
    bricks : (B, 3) int32
        Numbers of the bricks along the axes: voxel (i, j, k) of a brick stands at
        origin + voxel (8 brick + (i, j, k)).
    values : (B, 8, 8, 8) float32
        Signed distance in voxels, positive outside, never zero; NaN where nothing is known.
    """

    bricks: Ints
    values: NDArray[np.float32]


class Volume:
    """
    Signed distances along the lines of sight of all views (Curless and Levoy 1996, 3).

    Voxels are kept in bricks of 8 x 8 x 8 near the surface; views are weighed in one after the
    other, in an order that the caller keeps to.

    Parameters
    ----------
    origin : (3,) float64
        Of the lattice, in the object's frame; near the middle of the object.
    voxel : float
        Edge of a voxel.
    band : float
        Distance from the surface within which voxels count.

    Raises
    ------
    ShapeError
        If `origin` is no point, or a length is not positive.
    """

    def __init__(self, origin: Floats, voxel: float, band: float) -> None:
        if np.shape(origin) != (3,) or not np.isfinite(origin).all():
            raise ShapeError(f'origin: expected a point (3,), got {origin}')
        if not (0 < voxel < np.inf and 0 < band < np.inf):
            raise ShapeError(f'voxel, band: expected positive lengths, got {voxel}, {band}')
        self._kernel = _kernels._Volume(list(origin), voxel, band)

    def touch(self, vertices: Floats, faces: Ints, *, longest: float, most: int) -> bool:
        """
        Keep the bricks within the band of a mesh; return False once there are more than `most`.

        Parameters
        ----------
        vertices : (N, 3) float64
            In the object's frame.
        faces : (F, 3) int32
        longest : float
            Faces that extend farther along an axis are no surface and left out, like such as lie
            more than eight million voxels from the origin.
        most : int
            The volume is of no use after that.

        Raises
        ------
        ShapeError
            If an array has the wrong shape, or a face names no vertex.
        """
        check_mesh(vertices, faces)
        return bool(self._kernel.touch(vertices, faces, longest, most))

    @property
    def bricks(self) -> int:
        """Return how many bricks are kept."""
        return len(self._kernel.bricks())

    def integrate(self, sight: Sight, *, threads: int = 0) -> None:
        """
        Weigh in what a view says.

        Its distance counts across the surface (along the ray, times the cosine), up to the band
        in front of it, also where the ray goes on to a surface farther away: that is what carves
        stray points off. Behind its surface it counts in full for 0.4 of the band along the ray,
        falls to a hundredth at most at 0.8, and ends at 0.8 of the band across: the other side of
        a thin part must not be outvoted by this one.

        Parameters
        ----------
        sight : Sight
        threads : int
            0 takes all cores; no influence on the result.
        """
        self._kernel.integrate(sight.kernel, threads)

    def distances(self, *, threads: int = 0) -> Distances:
        """
        Return the weighted means, continued by one voxel beyond what was seen.

        Parameters
        ----------
        threads : int
            0 takes all cores; no influence on the result.
        """
        return Distances(
            frozen(self._kernel.bricks(), np.int32),
            frozen(self._kernel.distances(threads), np.float32))
