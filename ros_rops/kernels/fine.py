# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Matches between the views of a shape and the sums of their joint registration (IV-B)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.kernels import _kernels


class PairSums(NamedTuple):
    """
    What each of P ordered pairs (i, j) adds to the joint problem.

    Parameters
    ----------
    hessian : (P, 6, 6) float64
        Sum of w g g^T, g the gradient of a match's distance r by the motion (rotation vector,
        translation) of view i about the centre handed in; view j's is -g.
    gradient : (P, 6) float64
        Sum of w r g.
    tried, near, used : (P,) float64
        Samples of i; those with a point of j within the radius; those matched.
    absolute : (P,) float64
        Sum of |r| over the matches, in the units of the points.
    weight : (P,) float64
        Sum of w.
    """

    hessian: Floats
    gradient: Floats
    tried: Floats
    near: Floats
    used: Floats
    absolute: Floats
    weight: Floats


class Planes(NamedTuple):
    """
    The planes fitted at the N points of a view.

    Parameters
    ----------
    normals : (N, 3) float64
        Unit, on the side of the normals handed in; zero where no plane fits.
    thickness : (N,) float64
        Standard deviation of the neighbours across the plane.
    usable : (N,) bool
        Whether the point may be sampled and matched: not on the rim, with a plane.
    """

    normals: Floats
    thickness: Floats
    usable: Bools


class Surfaces:
    """
    Views ready to be matched with each other: points by cell, smoothed normals, rims.

    Parameters
    ----------
    points, normals : sequences of (N, 3) arrays
        Each view in its own frame; the normals only say which side is outside.
    boundary : sequence of (N,) bool arrays
        Vertices on the boundary of the view's mesh. One that its neighbours surround all the
        same (a small hole, a face lost to noise) stays usable.
    cell : float
        Edge of the cells; about the radius of the searches to come.
    support : float
        Radius of the neighbourhood that a plane is fitted to.
    threads : int
        0: as many as the machine has. The result does not depend on it.

    Raises
    ------
    ShapeError
        If the arrays of a view do not fit together or a length is not positive.
    """

    def __init__(
        self,
        points: Sequence[Floats],
        normals: Sequence[Floats],
        boundary: Sequence[Bools],
        *,
        cell: float,
        support: float,
        threads: int = 0,
    ) -> None:
        if not (cell > 0 and support > 0):
            raise ShapeError(f'cell, support: expected positive lengths, got {cell}, {support}')
        if not len(points) == len(normals) == len(boundary):
            raise ShapeError(
                f'views: {len(points)} points, {len(normals)} normals, {len(boundary)} boundary')
        for v, (p, n, b) in enumerate(zip(points, normals, boundary, strict=True)):
            if p.ndim != 2 or p.shape[1:] != (3,) or n.shape != p.shape or b.shape != p.shape[:1]:
                raise ShapeError(
                    f'view {v}: expected points (N, 3), normals (N, 3), boundary (N,), '
                    f'got {p.shape}, {n.shape}, {b.shape}')
        self._sizes = [len(p) for p in points]
        self._native = _kernels.Surfaces(
            list(points), list(normals), list(boundary), cell, support, threads)

    def __len__(self) -> int:
        """Return the number of views."""
        return len(self._sizes)

    def planes(self, view: int) -> Planes:
        """Return the planes fitted to a view, in the order of its points."""
        self._check_view(view)
        return Planes(*self._native.planes(view))

    def match(
        self, i: int, j: int, samples: Ints, pose_i: Floats, pose_j: Floats,
        *, radius: float, min_cos: float,
    ) -> tuple[Ints, Ints]:
        """
        Match samples of view i with their nearest points of view j.

        Parameters
        ----------
        samples : (S,) int32
            Points of view i.
        pose_i, pose_j : (4, 4) float64
            `T_common_view` of both.
        radius : float
            A nearest point farther away does not count.
        min_cos : float
            Nor does one whose normal makes an angle of smaller cosine.

        Returns
        -------
        source, target : (M,) int32
            Points of i and of j, in the order of the samples.

        Raises
        ------
        ShapeError
            If an index or a shape is wrong.
        """
        self._check_view(i)
        self._check_view(j)
        self._check_samples(i, samples)
        if np.shape(pose_i) != (4, 4) or np.shape(pose_j) != (4, 4):
            raise ShapeError('pose_i, pose_j: expected (4, 4)')
        source, target = self._native.match(i, j, samples, pose_i, pose_j, radius, min_cos)
        return source, target

    def normal_equations(
        self, pairs: Ints, samples: Sequence[Ints], poses: Floats, centre: Floats,
        *, radius: float, min_cos: float, soft: float, threads: int = 0,
    ) -> PairSums:
        """
        Return the sums of every ordered pair for a symmetric point-to-plane step.

        Parameters
        ----------
        pairs : (P, 2) int32
            Views i and j: samples of i against the surface of j.
        samples : sequence of (S,) int32
            Points taken of each view.
        poses : (V, 4, 4) float64
            `T_common_view`.
        centre : (3,) float64
            Motions are about this point of the common frame.
        radius, min_cos : float
            See `match`.
        soft : float
            A match's weight is (1 - d^2/radius^2)^2 / sqrt(1 + r^2/soft^2): absolute beyond
            `soft`, squared below.

        Raises
        ------
        ShapeError
            If an index or a shape is wrong.
        """
        pairs = np.asarray(pairs, dtype=np.int32).reshape(-1, 2)
        if pairs.size and not (pairs.min() >= 0 and pairs.max() < len(self)):
            raise ShapeError(f'pairs: expected indices of {len(self)} views')
        if np.shape(poses) != (len(self), 4, 4) or len(samples) != len(self):
            raise ShapeError(
                f'poses, samples: expected {len(self)}, got {np.shape(poses)}, {len(samples)}')
        for view, chosen in enumerate(samples):
            self._check_samples(view, chosen)
        hessian, gradient, stats = self._native.normal_equations(
            pairs, list(samples), poses, np.asarray(centre, dtype=np.float64).reshape(3),
            radius, min_cos, soft, threads)
        return PairSums(hessian, gradient, *stats.T)

    def _check_view(self, view: int) -> None:
        if not 0 <= view < len(self):
            raise ShapeError(f'view: expected an index below {len(self)}, got {view}')

    def _check_samples(self, view: int, samples: Ints) -> None:
        if samples.size and not (samples.min() >= 0 and samples.max() < self._sizes[view]):
            raise ShapeError(f'samples of view {view}: index out of range')
