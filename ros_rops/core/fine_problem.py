# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The views of one shape, their samples, and one joint step (IV-B)."""

from collections.abc import Sequence
import itertools
import math

import numpy as np
from numpy.typing import NDArray
from ros_rops.core import fine_system, williams
from ros_rops.core.config import FineConfig
from ros_rops.core.fine_prior import FinePrior, PriorTerms
from ros_rops.core.fine_types import FineView
from ros_rops.core.types import Bools, Floats, Ints
from ros_rops.kernels.fine import PairSums, Surfaces

CELL_MR = 3.0


class Problem:
    """The views, their samples and the state of the rounds."""

    def __init__(
        self, views: Sequence[FineView], poses: Floats, resolution: float, config: FineConfig,
        threads: int, prior: FinePrior | None = None,
    ) -> None:
        self.config, self.resolution, self.threads = config, resolution, threads
        self.start = self.poses = poses
        self.components = np.arange(len(views), dtype=np.int32)
        self.points = [v.points for v in views]
        self.surfaces = Surfaces(
            self.points, [v.normals for v in views], [v.boundary for v in views],
            cell=CELL_MR * resolution, support=config.normal_support_mr * resolution,
            threads=threads)
        usable = [np.flatnonzero(self.surfaces.planes(v).usable) for v in range(len(views))]
        self.few = [_spread(u, config.samples) for u in usable]
        self.many = [_spread(u, config.samples_last) for u in usable]
        self.pairs = np.array(
            list(itertools.permutations(range(len(views)), 2)), dtype=np.int32).reshape(-1, 2)
        self.middles = np.array([_middle(v.points) for v in views])
        self.sizes = np.array([
            max(_size(v.points, m), resolution)
            for v, m in zip(views, self.middles, strict=True)])
        self.centre = self.frames().middles.mean(axis=0)
        self.terms = PriorTerms(prior, poses, self.frames()) if prior else None

    def frames(self) -> fine_system.Frames:
        """Return the middles of the views as placed now."""
        return fine_system.frames_of(self.middles, self.sizes, self.poses)

    def placed_samples(self) -> tuple[list[Floats], list[Floats]]:
        """Return the points and normals of the few samples of each view, where they are now."""
        points, normals = [], []
        for view, (rows, pose) in enumerate(zip(self.few, self.poses, strict=True)):
            points.append(self.points[view][rows] @ pose[:3, :3].T + pose[:3, 3])
            normals.append(self.surfaces.planes(view).normals[rows] @ pose[:3, :3].T)
        return points, normals

    def sums(self, samples: Sequence[Ints], radius_mr: float, soft_mr: float) -> PairSums:
        """Match `samples` at the present poses and sum every pair."""
        return self.surfaces.normal_equations(
            self.pairs, samples, self.poses, self.centre,
            radius=radius_mr * self.resolution, soft=soft_mr * self.resolution,
            min_cos=math.cos(math.radians(self.config.normal_angle_deg)), threads=self.threads)

    def both_ways(self, counts: Floats) -> Floats:
        """Add to the count (P,) of each ordered pair that of its opposite."""
        table = np.zeros((len(self.poses), len(self.poses)))
        table[self.pairs[:, 0], self.pairs[:, 1]] = counts
        both: Floats = (table + table.T)[self.pairs[:, 0], self.pairs[:, 1]]
        return both

    def holding(self, sums: PairSums) -> Bools:
        """Whether each ordered pair has enough matches, counted both ways."""
        held: Bools = self.both_ways(sums.used) >= self.config.least_matches
        return held

    def step(self, sums: PairSums, samples: Sequence[Ints], radius_mr: float) -> float:
        """Move the views once; return the largest motion in mesh resolutions."""
        keep, frames = self.holding(sums), self.frames()
        self.components = fine_system.components_of(len(self.poses), self.pairs, keep)
        if self.config.method == 'williams':
            poses = williams.step(
                self.surfaces, self.points, self.pairs[keep], samples, self.poses, self.components,
                radius=radius_mr * self.resolution,
                min_cos=math.cos(math.radians(self.config.normal_angle_deg)))
            motions = _motions(self.poses, poses, frames)
        else:
            system = fine_system.assemble(self.pairs, sums, keep, frames, self.centre)
            motions = self._solved(system, frames)
            poses = fine_system.move(self.poses, motions, frames)
        self.poses = poses
        return float(np.abs(motions).max() / self.resolution)

    def _solved(self, system: fine_system.System, frames: fine_system.Frames) -> Floats:
        components = self.components
        if self.terms is not None:
            system, components = self.terms.extend(system, self.poses, frames, components)
        motions = fine_system.solve(
            system, components, fine_system.stiffness_of(system), self.config.least_stiffness)
        if self.terms is not None:
            self.terms.update(motions[-1])
        return motions[:len(self.poses)]

    def put_back(self) -> None:
        """
        Give the first view of each component the pose it came with, and carry the others along.

        In the first rounds, while the radius is wide, the components may have been fewer.
        """
        poses = self.poses.copy()
        for label in np.unique(self.components):
            members = np.flatnonzero(self.components == label)
            first = members[0]
            common = self.start[first] @ np.linalg.inv(self.poses[first])
            poses[members] = np.einsum('ij,vjk->vik', common, self.poses[members])
            poses[first] = self.start[first]
        self.poses = poses


def _motions(before: Floats, after: Floats, frames: fine_system.Frames) -> Floats:
    """Bound how far the points of each view went (V, 2): by rotation and at the middle."""
    change = after[:, :3, :3] - before[:, :3, :3]
    own = np.einsum('vji,vj->vi', before[:, :3, :3], frames.middles - before[:, :3, 3])
    went = np.einsum('vij,vj->vi', change, own) + after[:, :3, 3] - before[:, :3, 3]
    turned = np.linalg.norm(change, axis=(1, 2)) / math.sqrt(2.0) * frames.sizes
    result: Floats = np.stack([turned, np.linalg.norm(went, axis=1)], axis=1)
    return result


def _spread(indices: NDArray[np.intp], most: int) -> Ints:
    """Take at most `most` of the indices, evenly."""
    if len(indices) > most:
        indices = indices[(np.arange(most) * len(indices)) // most]
    return np.ascontiguousarray(indices, dtype=np.int32)


def _middle(points: Floats) -> Floats:
    middle: Floats = points.mean(axis=0) if len(points) else np.zeros(3)
    return middle


def _size(points: Floats, middle: Floats) -> float:
    return float(np.sqrt(((points - middle) ** 2).sum(axis=1).mean())) if len(points) else 0.0
