# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
KISS-Matcher on pairs of views, refined by small_gicp or by Open3D's ICP.

Lim et al., KISS-Matcher (2025), and Koide's small_gicp (2024), both of scans in metres:
KISS-Matcher refuses voxels under 5 mm and clamps its noise bounds at 1 m. Lengths are scaled so
that its voxel, 2.5 dres as everybody's (EVALUATION), is 0.3, its own default; everything else is
at its defaults. It voxelizes and describes both clouds anew in every call, which is its
interface: nothing of it can be prepared once for each view.

Its verdict is that of its examples: a valid solution with at least five final inliers.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.contest import Answer, Contestant
from ros_rops.bench.peers.open3d_pairs import ICP_DRES, refine, VOXEL_DRES
from ros_rops.core.types import Floats, RangeView, Status

VOXEL = 0.3
LEAST_INLIERS = 5
# small_gicp: points thinned to the spacing that a scan has anyhow, covariances of 20 neighbours.
THINNED_DRES = 1.0
NEIGHBOURS = 20
ITERATIONS = 30


@dataclass(frozen=True, slots=True)
class ScaledView:
    """A view in KISS-Matcher's lengths, and as the refinement wants it."""

    points: NDArray[np.float32]
    fine: Any


Refine = Callable[[Any, Any, Floats], tuple[Floats, float]]


def scale_of(dres: float) -> float:
    """Return the factor from the data's lengths to KISS-Matcher's."""
    return VOXEL / (VOXEL_DRES * dres)


def scaled(T: Floats, factor: float) -> Floats:
    """Return a transform (4, 4) of points that were multiplied by `factor`."""
    result = np.array(T, dtype=np.float64)
    result[:3, 3] *= factor
    return result


def match(source: ScaledView, target: ScaledView) -> tuple[Floats, bool, int]:
    """Return KISS-Matcher's transform in its lengths, whether it is valid, its final inliers."""
    import kiss_matcher

    matcher = kiss_matcher.KISSMatcher(kiss_matcher.KISSMatcherConfig(VOXEL))
    found = matcher.estimate(source.points, target.points)
    T = np.eye(4)
    T[:3, :3] = found.rotation
    T[:3, 3] = np.ravel(found.translation)
    return T, bool(found.valid), int(matcher.get_num_final_inliers())


def register(source: ScaledView, target: ScaledView, scale: float, fine: Refine) -> Answer:
    """Match a pair and refine it; `fine` works in KISS-Matcher's lengths."""
    T, valid, inliers = match(source, target)
    numbers = {'inliers': float(inliers)}
    if not valid or inliers < LEAST_INLIERS:
        return Answer(Status.REFUSED, None, 'fewer final inliers than five', numbers)
    T, fitness = fine(source.fine, target.fine, T)
    return Answer(Status.PLACED, scaled(T, 1.0 / scale), '', {**numbers, 'fitness': fitness})


def with_small_gicp(name: str, dres: float, threads: int) -> Contestant:
    """Return KISS-Matcher refined by two rounds of small_gicp's GICP, as far as EVALUATION's."""
    import small_gicp

    scale = scale_of(dres)

    def prepare(view: RangeView) -> ScaledView:
        points = view.points * scale
        return ScaledView(points.astype(np.float32), small_gicp.preprocess_points(
            points, downsampling_resolution=THINNED_DRES * dres * scale,
            num_neighbors=NEIGHBOURS, num_threads=threads))

    def fine(source: Any, target: Any, T: Floats) -> tuple[Floats, float]:
        share = 0.0
        for reach in ICP_DRES:
            found = small_gicp.align(
                target[0], source[0], target[1], T, registration_type='GICP',
                max_correspondence_distance=reach * dres * scale, num_threads=threads,
                max_iterations=ITERATIONS)
            T, share = np.array(found.T_target_source), found.num_inliers / source[0].size()
        return T, share

    return Contestant(name, prepare, lambda i, j: register(i, j, scale, fine))


def with_open3d_icp(name: str, dres: float) -> Contestant:
    """Return KISS-Matcher refined by the ICP that Open3D's columns have too."""
    scale = scale_of(dres)

    def prepare(view: RangeView) -> ScaledView:
        import open3d as o3d

        points = view.points * scale
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
        return ScaledView(points.astype(np.float32), _Points(cloud))

    def fine(source: Any, target: Any, T: Floats) -> tuple[Floats, float]:
        found = refine(source, target, T, dres * scale)
        return np.array(found.transformation), float(found.fitness)

    return Contestant(name, prepare, lambda i, j: register(i, j, scale, fine))


@dataclass(frozen=True, slots=True)
class _Points:
    """What Open3D's ICP needs of a view."""

    points: Any
