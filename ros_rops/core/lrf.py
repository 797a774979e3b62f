# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Local reference frames (Guo et al., IJCV 105(1), 2013; METHOD 3)."""

from ros_rops.core.config import LrfConfig
from ros_rops.core.types import Floats, Ints, RangeMesh
from ros_rops.kernels.features import features


def compute_lrfs(
    mesh: RangeMesh,
    indices: Ints,
    config: LrfConfig,
    radius: float,
    *,
    resolution: float | None = None,
    threads: int = 0,
) -> tuple[Floats, Floats]:
    """
    Local reference frames of vertices.

    Method `rops` (the paper): eigenvectors v1, v2, v3 of the support's weighted covariance, v1
    and v3 turned to the heavier side, v2 = v3 x v1. Method `toldi`: z is the normal of a
    smaller support, turned to the sensor, x a weighted projection (Yang et al. 2017).

    Parameters
    ----------
    mesh : RangeMesh
    indices : (K,) int32
        Vertices of the mesh.
    config : LrfConfig
    radius : float
        Of the support, in the mesh's units.
    resolution : float, optional
        What `mr` means; the mesh's own by default.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    lrfs : (K, 3, 3) float64
        Rows x, y, z; zero where a vertex has no frame.
    eigenvalues : (K, 3) float64
        Of the weighted covariance, falling.

    Raises
    ------
    ShapeError
        If `indices` is no vector of vertices or `radius` is not positive.
    """
    result = features(
        mesh.vertices, mesh.faces, mesh.normals, indices, radius,
        normal_radius=normal_radius(config, resolution or mesh.resolution),
        touching=config.triangles == 'pcl', threads=threads,
    )
    return result.lrfs, result.eigenvalues


def normal_radius(config: LrfConfig, resolution: float) -> float:
    """Radius of the normal for the kernel: 0 asks for the covariance's own frame."""
    return config.normal_radius_mr * resolution if config.method == 'toldi' else 0.0
