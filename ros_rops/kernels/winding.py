# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the winding numbers: how often a mesh goes round a point."""

from dataclasses import dataclass

import numpy as np
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Floats, frozen, Ints
from ros_rops.kernels import _kernels
from ros_rops.kernels.meshes import check_mesh


@dataclass(frozen=True, slots=True)
class Winding:
    """
    The winding number of a mesh, open or closed (Jacobson et al. 2013; Barill et al. 2018).

    Parameters
    ----------
    kernel : object
        The compiled part: the triangles in a tree of clusters.
    """

    kernel: '_kernels._Winding'

    @classmethod
    def of(cls, vertices: Floats, faces: Ints) -> 'Winding':
        """
        Prepare the look-up of a mesh.

        Parameters
        ----------
        vertices : (V, 3) float64
        faces : (F, 3) int32
            Counter-clockwise seen from outside.

        Raises
        ------
        ShapeError
            If an array has the wrong shape or a face names no vertex.
        """
        check_mesh(vertices, faces)
        return cls(_kernels._Winding(vertices, faces))

    def at(self, points: Floats, *, threads: int = 0) -> Floats:
        """
        Return how often the mesh goes round each of `points` (M, 3).

        In the inside of a closed mesh 1, outside 0; of an open one the share of all directions
        in which its inner side is seen, less that in which its outer side is. Clusters far off
        count by their moments, which costs up to about 0.001.

        Parameters
        ----------
        points : (M, 3) float64
        threads : int
            0 takes all cores; no influence on the result.

        Returns
        -------
        (M,) float64

        Raises
        ------
        ShapeError
            If `points` has another shape.
        """
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError(f'points: expected (M, 3), got {points.shape}')
        turns: Floats = frozen(self.kernel.at(points, threads), np.float64)
        return turns
