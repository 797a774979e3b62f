# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Open3D on pairs of views: FPFH with RANSAC or fast global registration, then ICP.

The protocol is EVALUATION's: voxels of 2.5 dres, FPFH radius 15 dres, then two rounds of ICP on
all points. Open3D has no verdict of its own: it accepts every pair.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from ros_rops.bench.contest import Answer, Contestant
from ros_rops.core.types import Floats, RangeView, Status

VOXEL_DRES = 2.5
NORMAL_DRES = 5.0
FEATURE_DRES = 15.0
# Of Open3D's global registration tutorial, in voxels.
RANSAC_VOXELS = 1.5
FGR_VOXELS = 0.5
ICP_DRES = (6.0, 2.5)
SEED = 0

Coarse = Callable[['PeerView', 'PeerView', float], Any]


@dataclass(frozen=True, slots=True)
class PeerView:
    """A view as Open3D wants it: all points, the thinned cloud and its FPFH features."""

    points: Any
    thinned: Any
    features: Any


def open3d_contestant(name: str, dres: float, coarse: Coarse, *, plane: bool) -> Contestant:
    """Return Open3D as a contestant: `coarse`, then ICP, point to plane where asked for."""
    return Contestant(
        name, lambda view: prepare_view(view, dres, plane=plane),
        lambda source, target: register(source, target, dres, coarse, plane=plane))


def prepare_view(view: RangeView, dres: float, *, plane: bool = False) -> PeerView:
    """
    Thin a view, estimate normals that face the sensor, and compute FPFH.

    Where `plane` is set, all points get normals too, for point-to-plane ICP.
    """
    import open3d as o3d

    # Open3D refuses read-only arrays.
    points = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(view.points.copy()))
    thinned = points.voxel_down_sample(VOXEL_DRES * dres)
    search = o3d.geometry.KDTreeSearchParamHybrid
    for cloud in (thinned, points) if plane else (thinned,):
        cloud.estimate_normals(search(NORMAL_DRES * dres, 30))
    if view.sensor.kind == 'pinhole':
        thinned.orient_normals_towards_camera_location(np.asarray(view.sensor.origin))
    else:
        thinned.orient_normals_to_align_with_direction(-np.asarray(view.sensor.direction))
    features = o3d.pipelines.registration.compute_fpfh_feature(
        thinned, search(FEATURE_DRES * dres, 100))
    return PeerView(points, thinned, features)


def ransac(source: PeerView, target: PeerView, dres: float) -> Any:
    """Register by RANSAC on mutual FPFH matches."""
    import open3d as o3d

    registration = o3d.pipelines.registration
    o3d.utility.random.seed(SEED)
    distance = RANSAC_VOXELS * VOXEL_DRES * dres
    return registration.registration_ransac_based_on_feature_matching(
        source.thinned, target.thinned, source.features, target.features, True, distance,
        registration.TransformationEstimationPointToPoint(False), 3,
        [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9),
         registration.CorrespondenceCheckerBasedOnDistance(distance)],
        registration.RANSACConvergenceCriteria(100000, 0.999))


def fast_global(source: PeerView, target: PeerView, dres: float) -> Any:
    """Register by fast global registration of FPFH matches."""
    import open3d as o3d

    registration = o3d.pipelines.registration
    o3d.utility.random.seed(SEED)
    option = registration.FastGlobalRegistrationOption(
        maximum_correspondence_distance=FGR_VOXELS * VOXEL_DRES * dres)
    return registration.registration_fgr_based_on_feature_matching(
        source.thinned, target.thinned, source.features, target.features, option)


def refine(
    source: PeerView, target: PeerView, T: Floats, dres: float, *, plane: bool = False
) -> Any:
    """Refine a transform by two rounds of ICP, reaching 6 and 2.5 dres, on all points."""
    import open3d as o3d

    registration = o3d.pipelines.registration
    kind = registration.TransformationEstimationPointToPlane if plane \
        else registration.TransformationEstimationPointToPoint
    result = None
    for distance in ICP_DRES:
        result = registration.registration_icp(
            source.points, target.points, distance * dres, T, kind())
        T = result.transformation
    return result


def register(
    source: PeerView, target: PeerView, dres: float, coarse: Coarse, *, plane: bool = False
) -> Answer:
    """Register a pair: `coarse` (ransac or fast_global), then two rounds of ICP."""
    start = coarse(source, target, dres)
    fine = refine(source, target, start.transformation, dres, plane=plane)
    return Answer(
        Status.PLACED, np.array(fine.transformation),
        numbers={'fitness': fine.fitness, 'inlier_rmse': fine.inlier_rmse})
