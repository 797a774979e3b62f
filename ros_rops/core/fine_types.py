# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What goes into the multi-view fine registration and what comes out of it."""

from dataclasses import dataclass

import numpy as np
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Bools, Floats, frozen, RangeMesh


@dataclass(frozen=True, slots=True)
class FineView:
    """
    A view to be refined, in its own frame.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float64
        Towards the sensor; only the side counts, zero where unknown.
    boundary : (N,) bool
        Vertices on the boundary of the view's mesh.

    Raises
    ------
    ShapeError
        If the arrays do not fit together or are not finite.
    """

    points: Floats
    normals: Floats
    boundary: Bools

    def __post_init__(self) -> None:
        """Check shapes and make the arrays read-only."""
        points, normals = frozen(self.points, np.float64), frozen(self.normals, np.float64)
        boundary = frozen(self.boundary, np.bool_)
        if points.shape[1:] != (3,) or normals.shape != points.shape:
            raise ShapeError(
                f'points, normals: expected (N, 3) both, got {points.shape}, {normals.shape}')
        if boundary.shape != points.shape[:1]:
            raise ShapeError(f'boundary: expected ({len(points)},), got {boundary.shape}')
        if not (np.isfinite(points).all() and np.isfinite(normals).all()):
            raise ShapeError('points, normals: not finite (drop such points first)')
        object.__setattr__(self, 'points', points)
        object.__setattr__(self, 'normals', normals)
        object.__setattr__(self, 'boundary', boundary)

    @classmethod
    def of(cls, mesh: RangeMesh) -> 'FineView':
        """Take the vertices of a view's mesh."""
        return cls(mesh.vertices, mesh.normals, mesh.boundary)


@dataclass(frozen=True, slots=True)
class EdgeFit:
    """
    How two overlapping views fit, both directions together.

    Parameters
    ----------
    source, target : int
        Indices of the views, source < target.
    matches : int
        Samples matched within the first radius.
    overlap : float
        Matches / samples of the two views.
    residual_mr : float
        Mean |point-to-plane distance| of the matches.
    """

    source: int
    target: int
    matches: int
    overlap: float
    residual_mr: float


@dataclass(frozen=True, slots=True)
class ViewFit:
    """
    How one view fits all others, to find a wrong one.

    Parameters
    ----------
    residual_mr : float
        Mean |point-to-plane distance| of all its matches within the first radius; NaN if none.
    agreement : float
        Of the points of its pairs that come near each other, the share that match (normals
        agree, no rim): a wrong view cuts through the others. NaN if none.
    stiffness : float
        Mean squared change of distance for the unit motion that is held least; 0 if unmatched.
    weakest : (6,) float64
        That motion: rotation vector times the view's size, translation; in the frame of the
        poses, about the view's middle.
    constrained : bool
        Whether `stiffness` reaches the parameter `least_stiffness`.
    component : int
        Number of its connected group.
    """

    residual_mr: float
    agreement: float
    stiffness: float
    weakest: Floats
    constrained: bool
    component: int


@dataclass(frozen=True, slots=True)
class FineResult:
    """
    Refined poses and how they fit.

    Parameters
    ----------
    poses : tuple of (4, 4) float64
        `T_object_view`; the first view of each component has the pose it came with.
    views : tuple of ViewFit
    edges : tuple of EdgeFit
        Pairs with at least `least_matches`, ordered.
    residual_mr : float
        Mean |point-to-plane distance| of all matches within the last radius; NaN if none.
    radius_mr : float
        That radius.
    iterations : int
    converged : bool
        Whether the last round moved no view by more than the tolerance.
    """

    poses: tuple[Floats, ...]
    views: tuple[ViewFit, ...]
    edges: tuple[EdgeFit, ...]
    residual_mr: float
    radius_mr: float
    iterations: int
    converged: bool
