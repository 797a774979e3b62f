# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the evidence kernel: what a view or a grown shape testifies of a surface."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import ShapeError, ViewError
from ros_rops.core.types import Bools, Floats, frozen, SensorModel
from ros_rops.kernels import _kernels

_SENSOR_KINDS = {'unknown': 0, 'orthographic': 1, 'pinhole': 2}


class Vertices(NamedTuple):
    """
    Vertices of a view or a grown shape, those of one cell together.

    Parameters
    ----------
    points : (N, 3) float64
        In the frame of the points that went in, in single precision about their centre.
    normals : (N, 3) float64
        Unit, of the surface around; zeros where that has none.
    rim : (N,) bool
        On the boundary of the mesh.
    """

    points: Floats
    normals: Floats
    rim: Bools


@dataclass(frozen=True, slots=True)
class Evidence:
    """
    What a view or a grown shape testifies: closest-cell field, samples, depth rasters.

    The kernel works in single precision about `centre`; poses go in and out in the frame of the
    points.

    Parameters
    ----------
    kernel : object
        The compiled part.
    centre : (3,) float64
    cell : float
        Edge of a cell.
    reach : int
        Cells that the field looks around a surface.
    beyond : bool
        Whether rays that passed by the object are among it.
    """

    kernel: '_kernels._Evidence'
    centre: Floats
    cell: float
    reach: int
    beyond: bool = False

    @classmethod
    def of(
        cls,
        points: Floats,
        normals: Floats,
        boundary: Bools,
        sensor: SensorModel,
        *,
        cell: float,
        reach: int,
        beyond: NDArray[np.float32] | None = None,
    ) -> 'Evidence':
        """
        Build the evidence of a view.

        Parameters
        ----------
        points, normals : (N, 3) float64
            Unit normals towards the sensor.
        boundary : (N,) bool
        sensor : SensorModel
        cell : float
        reach : int
        beyond : (M, 3) float32, optional
            Where rays ended that pass by the object.

        Raises
        ------
        ShapeError
            If the arrays do not fit together.
        ViewError
            If the extent is out of all proportion to `cell` (stray points).
        """
        if points.ndim != 2 or points.shape[1] != 3 or normals.shape != points.shape:
            raise ShapeError(f'points, normals: expected (N, 3), got {points.shape}, '
                             f'{normals.shape}')
        if boundary.shape != points.shape[:1]:
            raise ShapeError(f'boundary: expected ({len(points)},), got {boundary.shape}')
        centre = points.mean(axis=0)
        past = np.empty((0, 3)) if beyond is None else beyond.astype(np.float64) - centre
        try:
            kernel = _kernels._Evidence(
                points - centre, normals, boundary.astype(np.uint8), cell, reach,
                _SENSOR_KINDS[sensor.kind], list(np.asarray(sensor.origin) - centre),
                list(sensor.direction), past)
        except ValueError as error:
            extent = ' x '.join(f'{length:.3g}' for length in np.ptp(points, axis=0))
            raise ViewError(
                f'its extent of {extent} is out of proportion to the mesh resolution: '
                f'remove stray points') from error
        return cls(kernel, centre, cell, reach, len(past) > 0)

    @property
    def area(self) -> float:
        """Size of the surface, in squared units of the points, to some 10 %: its cells."""
        return float(self.kernel.sample_count) * self.cell**2

    @property
    def views(self) -> int:
        """Return the number of views whose rays testify; one of an unknown sensor has none."""
        return int(self.kernel.sensor_count)

    @property
    def noise(self) -> float:
        """Return the vertices' standard deviation across their surface, in the points' units."""
        return float(self.kernel.noise)

    def vertices(self) -> Vertices:
        """Return a read-only copy of the vertices."""
        points, normals, rim = self.kernel.vertices()
        return Vertices(
            frozen(points + self.centre, np.float64), frozen(normals, np.float64),
            frozen(rim, np.bool_))

    def grown(
        self, view: 'Evidence', T_self_view: Floats, near: float, *, threads: int = 0
    ) -> 'Evidence':
        """
        Add what `view` saw (IV-A): vertices farther than `near` from the shape, and its rays.

        Parameters
        ----------
        view : Evidence
        T_self_view : (4, 4) float64
        near : float
        threads : int
            0 takes all cores; no influence on the result.

        Returns
        -------
        Evidence
            In this shape's frame.

        Raises
        ------
        ViewError
            If both together extend too far for `cell` (stray points).
        """
        pose = about_centres(T_self_view, view.centre, self.centre)
        try:
            kernel = self.kernel.grown(view.kernel, pose, near, self.reach, threads)
        except ValueError as error:
            raise ViewError(
                'together they extend too far for the mesh resolution: remove stray points'
            ) from error
        return Evidence(kernel, self.centre, self.cell, self.reach, self.beyond or view.beyond)


def about_centres(poses: Floats, source_centre: Floats, target_centre: Floats) -> Floats:
    """Express `T_target_source` between frames moved to the two centres."""
    moved = np.array(poses, dtype=np.float64)
    moved[..., :3, 3] += poses[..., :3, :3] @ source_centre - target_centre
    return moved
