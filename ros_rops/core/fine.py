# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Multi-view fine registration: all views of a shape together (Guo et al. 2014, IV-B).

`simultaneous` minimises the symmetric point-to-plane distance between all overlapping views at
once by Gauss-Newton; `williams` is the paper's choice, the registration of corresponding point
sets (Williams and Bennamoun 2001). Matches are renewed in every round. The first view of each
connected group of views keeps its pose: the common frame stays where it was.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import itertools
import math

import numpy as np

from ros_rops.core import fine_system, williams
from ros_rops.core.config import FineConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Bools, Floats, frozen, Ints, RangeMesh
from ros_rops.kernels.fine import PairSums, Surfaces

# From one round to the next the radius shrinks to this share at most, so that views that start
# farther off than the others are not left behind.
SHRINK = 0.5
# The poses have settled for the few samples: time for the many.
SETTLED_MR = 0.05
# Distances below this multiple of the mean residual weigh as squares (efficient under noise),
# larger ones as absolute values (robust).
SOFT = 1.5
CELL_MR = 2.0


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


class _Problem:
    """The views, their samples and the state of the rounds."""

    def __init__(
        self, views: Sequence[FineView], poses: Floats, resolution: float, config: FineConfig,
        threads: int,
    ) -> None:
        self.config, self.resolution, self.threads = config, resolution, threads
        self.poses = poses
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

    def frames(self) -> fine_system.Frames:
        return fine_system.frames_of(self.middles, self.sizes, self.poses)

    def sums(self, samples: Sequence[Ints], radius_mr: float, soft_mr: float) -> PairSums:
        return self.surfaces.normal_equations(
            self.pairs, samples, self.poses, self.centre,
            radius=radius_mr * self.resolution, soft=soft_mr * self.resolution,
            min_cos=math.cos(math.radians(self.config.normal_angle_deg)), threads=self.threads)

    def holding(self, sums: PairSums) -> Bools:
        """Whether each ordered pair has enough matches, counted both ways."""
        count = len(self.poses)
        table = np.zeros((count, count))
        table[self.pairs[:, 0], self.pairs[:, 1]] = sums.used
        both = table + table.T
        held: Bools = both[self.pairs[:, 0], self.pairs[:, 1]] >= self.config.least_matches
        return held

    def step(self, sums: PairSums, samples: Sequence[Ints], radius_mr: float) -> float:
        """Move the views once; return the largest motion in mesh resolutions."""
        keep, frames = self.holding(sums), self.frames()
        components = fine_system.components_of(len(self.poses), self.pairs, keep)
        if self.config.method == 'williams':
            poses = williams.step(
                self.surfaces, self.points, self.pairs[keep], samples, self.poses, components,
                radius=radius_mr * self.resolution,
                min_cos=math.cos(math.radians(self.config.normal_angle_deg)))
            motions = _motions(self.poses, poses, frames)
        else:
            system = fine_system.assemble(self.pairs, sums, keep, frames, self.centre)
            stiffness = fine_system.stiffness_of(system)
            motions = fine_system.solve(
                system, components, stiffness, self.config.least_stiffness)
            poses = fine_system.move(self.poses, motions, frames)
        self.poses = poses
        return float(np.abs(motions).max() / self.resolution)


def refine_shape(
    views: Sequence[FineView],
    poses: Sequence[Floats],
    resolution: float,
    config: FineConfig,
    *,
    threads: int = 0,
) -> FineResult:
    """
    Refine the poses of all views of a shape together (IV-B).

    Parameters
    ----------
    views : sequence of FineView
    poses : sequence of (4, 4) float64
        `T_object_view` of each view, good to about `radius_start_mr`.
    resolution : float
        Mesh resolution of the shape, in the units of the points.
    config : FineConfig
    threads : int
        0: as many as the machine has. The result is the same, byte for byte, for any number.

    Returns
    -------
    FineResult
        Views that nothing holds (no overlap, or along an unconstrained motion) keep their
        poses and are reported so.

    Raises
    ------
    ShapeError
        If there is no view, the poses are not rigid or not one for each view, or the
        resolution is not a positive length.
    """
    start = _checked(views, poses, resolution)
    problem = _Problem(views, start, resolution, config, threads)
    radius, mean, iterations, converged = _rounds(problem)
    return _report(problem, radius, mean, iterations, converged)


def _rounds(problem: _Problem) -> tuple[float, float, int, bool]:
    """Run the rounds; return last radius and mean residual (mr), their number, convergence."""
    config = problem.config
    radius, mean = max(config.radius_start_mr, config.radius_mr), math.nan
    samples, soft = problem.few, radius
    for done in range(config.iterations):
        sums = problem.sums(samples, radius, soft)
        if done == 0:
            _drop_far_pairs(problem, sums)
            sums = problem.sums(samples, radius, soft)
        mean = _ratio(sums.absolute.sum(), sums.used.sum()) / problem.resolution
        moved = problem.step(sums, samples, radius)
        wanted = max(config.radius_mr, config.noise_factor * (0.0 if math.isnan(mean) else mean))
        shrunk = min(radius, max(wanted, SHRINK * radius))
        settled = shrunk > 0.9 * radius
        if settled and samples is problem.many and moved <= config.tolerance_mr:
            return radius, mean, done + 1, True
        if settled and moved <= SETTLED_MR:
            samples = problem.many
        radius, soft = shrunk, SOFT * max(0.0 if math.isnan(mean) else mean, 1e-3)
    return radius, mean, config.iterations, False


def _drop_far_pairs(problem: _Problem, sums: PairSums) -> None:
    """Forget the pairs of views that are nowhere near each other."""
    count = len(problem.poses)
    near = np.zeros((count, count))
    near[problem.pairs[:, 0], problem.pairs[:, 1]] = sums.near
    both = near + near.T
    problem.pairs = problem.pairs[both[problem.pairs[:, 0], problem.pairs[:, 1]] > 0]


def _report(
    problem: _Problem, radius: float, mean: float, iterations: int, converged: bool
) -> FineResult:
    wide = max(problem.config.radius_start_mr, problem.config.radius_mr)
    sums = problem.sums(problem.few, wide, wide)
    keep = problem.holding(sums)
    components = fine_system.components_of(len(problem.poses), problem.pairs, keep)
    system = fine_system.assemble(problem.pairs, sums, keep, problem.frames(), problem.centre)
    stiffness = fine_system.stiffness_of(system)
    return FineResult(
        poses=tuple(frozen(pose, np.float64) for pose in problem.poses),
        views=tuple(
            _view_fit(problem, sums, stiffness, components, v)
            for v in range(len(problem.poses))),
        edges=_edges(problem, sums, keep),
        residual_mr=mean,
        radius_mr=radius,
        iterations=iterations,
        converged=converged,
    )


def _view_fit(
    problem: _Problem, sums: PairSums, stiffness: fine_system.Stiffness, components: Ints, v: int
) -> ViewFit:
    mine = (problem.pairs == v).any(axis=1)
    used, near = sums.used[mine].sum(), sums.near[mine].sum()
    least = float(stiffness.values[v, 0])
    return ViewFit(
        residual_mr=_ratio(sums.absolute[mine].sum(), used) / problem.resolution,
        agreement=_ratio(used, near),
        stiffness=least,
        weakest=frozen(stiffness.motions[v, :, 0], np.float64),
        constrained=least > 0.0 and least >= problem.config.least_stiffness,
        component=int(components[v]),
    )


def _edges(problem: _Problem, sums: PairSums, keep: Bools) -> tuple[EdgeFit, ...]:
    row = {(int(i), int(j)): p for p, (i, j) in enumerate(problem.pairs)}
    edges = []
    for (i, j), p in row.items():
        if i > j or not keep[p]:
            continue
        back = row[j, i]
        used = sums.used[p] + sums.used[back]
        edges.append(EdgeFit(
            source=i, target=j, matches=int(used),
            overlap=float(_ratio(used, sums.tried[p] + sums.tried[back])),
            residual_mr=_ratio(sums.absolute[p] + sums.absolute[back], used)
            / problem.resolution))
    return tuple(edges)


def _checked(views: Sequence[FineView], poses: Sequence[Floats], resolution: float) -> Floats:
    if len(views) == 0 or len(views) != len(poses):
        raise ShapeError(
            f'poses: expected one for each of at least one view, '
            f'got {len(poses)} for {len(views)}')
    if not (math.isfinite(resolution) and resolution > 0):
        raise ShapeError(f'resolution: expected a positive length, got {resolution!r}')
    for index, pose in enumerate(poses):
        if np.shape(pose) != (4, 4) or not np.isfinite(pose).all():
            raise ShapeError(f'poses[{index}]: expected a finite (4, 4), got {np.shape(pose)}')
        turn = np.asarray(pose)[:3, :3]
        if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-3 or np.linalg.det(turn) < 0:
            raise ShapeError(f'poses[{index}]: not a rigid transform')
    return np.array(poses, dtype=np.float64)


def _motions(before: Floats, after: Floats, frames: fine_system.Frames) -> Floats:
    """Bound how far the points of each view went (V, 2): by rotation and at the middle."""
    change = after[:, :3, :3] - before[:, :3, :3]
    own = np.einsum('vji,vj->vi', before[:, :3, :3], frames.middles - before[:, :3, 3])
    went = np.einsum('vij,vj->vi', change, own) + after[:, :3, 3] - before[:, :3, 3]
    turned = np.linalg.norm(change, axis=(1, 2)) / math.sqrt(2.0) * frames.sizes
    result: Floats = np.stack([turned, np.linalg.norm(went, axis=1)], axis=1)
    return result


def _spread(indices: Ints, most: int) -> Ints:
    """Take at most `most` of the indices, evenly."""
    if len(indices) > most:
        indices = indices[(np.arange(most) * len(indices)) // most]
    return np.ascontiguousarray(indices, dtype=np.int32)


def _middle(points: Floats) -> Floats:
    middle: Floats = points.mean(axis=0) if len(points) else np.zeros(3)
    return middle


def _size(points: Floats, middle: Floats) -> float:
    return float(np.sqrt(((points - middle) ** 2).sum(axis=1).mean())) if len(points) else 0.0


def _ratio(part: float, whole: float) -> float:
    return float(part / whole) if whole > 0 else math.nan
