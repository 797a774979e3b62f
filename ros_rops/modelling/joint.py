# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The views of an object as one point-to-plane problem at the poses they have: how they fit."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from ros_rops.core import fine_system
from ros_rops.core.config import FineConfig
from ros_rops.core.fine_problem import Problem
from ros_rops.core.fine_report import edges_of
from ros_rops.core.fine_types import EdgeFit, FineView
from ros_rops.core.types import Bools, Floats
from ros_rops.kernels.fine import PairSums
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.residuals import thinned

POINTS = 12_000
"""Most points of a view, taken evenly."""


@dataclass(frozen=True, slots=True)
class Joint:
    """
    The matches of all pairs of views within the first radius of the fine registration (IV-B).

    Parameters
    ----------
    problem : Problem
        Its mesh resolution is that of the points as thinned.
    sums : PairSums
    keep : (P,) bool
        Pairs with enough matches to hold each other.
    """

    problem: Problem
    sums: PairSums
    keep: Bools

    @classmethod
    def of(
        cls, views: Sequence[PosedView], resolution: float, config: FineConfig, *,
        threads: int = 0,
    ) -> 'Joint':
        """Match the samples of every view with the surface of every other (two views or more)."""
        chosen = [thinned(one, POINTS) for one in views]
        coarser = [
            np.sqrt(max(1.0, np.count_nonzero(one.mesh.normals.any(axis=1)) / max(len(kept), 1)))
            for one, kept in zip(views, chosen, strict=True)]
        fine = [
            FineView(one.mesh.vertices[kept], one.mesh.normals[kept], one.mesh.boundary[kept])
            for one, kept in zip(views, chosen, strict=True)]
        problem = Problem(
            fine, np.array([one.T_object_view for one in views]),
            resolution * float(np.mean(coarser)), config, threads)
        wide = max(config.radius_start_mr, config.radius_mr)
        sums = problem.sums(problem.few, wide, wide)
        return cls(problem, sums, problem.holding(sums))

    @property
    def edges(self) -> tuple[EdgeFit, ...]:
        """Return how the pairs that hold each other fit; residuals in the problem's unit."""
        return edges_of(self.problem, self.sums, self.keep)

    @property
    def roughness(self) -> float:
        """Median standard deviation of the points across their own view's surface, a length."""
        planes = [self.problem.surfaces.planes(v) for v in range(len(self.problem.surfaces))]
        together = np.concatenate([one.thickness[one.usable] for one in planes])
        return float(np.median(together)) if len(together) else 0.0

    def system(self, without: Collection[int] = ()) -> fine_system.System:
        """Return the linear system of a step; views in `without` take no part."""
        gone = np.isin(self.problem.pairs, list(without)).any(axis=1)
        return fine_system.assemble(
            self.problem.pairs, self.sums, self.keep & ~gone, self.problem.frames(),
            self.problem.centre)

    def pulls(self, without: Collection[int] = ()) -> Floats:
        """
        Return how far, as a length (V,), the others would move each view, were they fixed.

        One Gauss-Newton step of each view alone, along motions that are held; the root mean
        square motion of its points. It tells a view that has not settled from one whose data
        are poor.
        """
        system = self.system(without)
        stiffness = fine_system.stiffness_of(system)
        held = stiffness.values >= self.problem.config.least_stiffness
        weight = np.where(system.weight > 0, system.weight, 1.0)[:, None]
        amount = np.einsum('vab,va->vb', stiffness.motions, system.right)
        step = np.where(held, amount / (weight * np.where(held, stiffness.values, 1.0)), 0.0)
        length: Floats = np.linalg.norm(step, axis=1)
        return length
