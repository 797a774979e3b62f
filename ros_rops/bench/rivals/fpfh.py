# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""FPFH (Rusu et al. 2009) of Open3D as a descriptor."""

from functools import partial

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.peers.extras import open3d_missing
from ros_rops.bench.rivals.descriptor import Descriptor
from ros_rops.core.types import Floats, Ints, RangeMesh


def fpfh(radius_mr: float) -> Descriptor:
    """Compute FPFH on all points of the mesh, with its normals: three parts, each of sum 100."""
    return Descriptor(
        'FPFH', 'Rusu et al. 2009; Open3D', partial(_describe, radius_mr), open3d_missing)


def _describe(
    radius_mr: float, mesh: RangeMesh, indices: Ints, lrfs: Floats, unit: float, threads: int
) -> NDArray[np.float32]:
    import open3d as o3d

    used = mesh.normals.any(axis=1)
    # Open3D refuses read-only arrays.
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(mesh.vertices[used].copy()))
    cloud.normals = o3d.utility.Vector3dVector(mesh.normals[used].copy())
    found = o3d.pipelines.registration.compute_fpfh_feature(
        cloud, o3d.geometry.KDTreeSearchParamRadius(radius_mr * unit))
    rank = np.cumsum(used) - 1
    rows: NDArray[np.float32] = np.asarray(found.data).T[rank[indices]].astype(np.float32)
    return rows
