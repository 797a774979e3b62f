# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""RoPS descriptors (Guo et al. 2014, III-A, eqs. 1-4; METHOD 4)."""

import math

import numpy as np
from ros_rops.core.config import Config, LrfConfig, RopsConfig
from ros_rops.core.keypoints import candidate_keypoints, distinct
from ros_rops.core.lrf import normal_radius
from ros_rops.core.types import Features, Floats, frozen, Ints, RangeMesh
from ros_rops.kernels.features import FeatureArrays, features, Projections


def compute_features(
    mesh: RangeMesh,
    config: Config,
    *,
    resolution: float | None = None,
    threads: int = 0,
) -> Features:
    """
    Keypoints, frames and descriptors of a mesh, one neighbour search for all.

    Parameters
    ----------
    mesh : RangeMesh
    config : Config
        Groups `keypoints`, `lrf` and `rops`.
    resolution : float, optional
        What `mr` means; the mesh's own by default. Views to be matched should share one.
    threads : int
        0 takes all cores; the result does not depend on it, byte for byte.

    Returns
    -------
    Features
        D = 45 `rotations`. Keypoints without a frame or with too symmetric a support
        (`keypoints.eigen_ratio`) are left out; there may be none.
    """
    unit = resolution or mesh.resolution
    indices = candidate_keypoints(mesh, config.keypoints, resolution=unit)
    found = describe(mesh, indices, config.lrf, config.rops, resolution=unit, threads=threads)
    keep = found.lrfs.any(axis=(1, 2))
    if config.keypoints.eigen_ratio > 1.0:
        keep &= distinct(found.eigenvalues, config.keypoints.eigen_ratio)
    indices = indices[keep]
    return Features(
        indices=frozen(indices, np.int32),
        positions=frozen(mesh.vertices[indices], np.float64),
        lrfs=frozen(found.lrfs[keep], np.float64),
        descriptors=frozen(found.descriptors[keep], np.float32),
    )


def describe(
    mesh: RangeMesh,
    indices: Ints,
    lrf: LrfConfig,
    rops: RopsConfig,
    *,
    lrfs: Floats | None = None,
    resolution: float | None = None,
    threads: int = 0,
) -> FeatureArrays:
    """
    Frames and descriptors of given vertices.

    Parameters
    ----------
    mesh : RangeMesh
    indices : (K,) int32
        Vertices of the mesh.
    lrf : LrfConfig
    rops : RopsConfig
    lrfs : (K, 3, 3) float64, optional
        Frames to use instead of computing them.
    resolution : float, optional
        What `mr` means; the mesh's own by default.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    FeatureArrays
        `lrfs` (K, 3, 3), `eigenvalues` (K, 3), `descriptors` (K, 45 `rotations`); rows of zeros
        for vertices without a frame.

    Raises
    ------
    ShapeError
        If `indices` or `lrfs` do not fit the mesh.
    """
    unit = resolution or mesh.resolution
    return features(
        mesh.vertices, mesh.faces, mesh.normals, indices, rops.radius_mr * unit,
        normal_radius=normal_radius(lrf, unit), touching=lrf.triangles == 'pcl',
        loose=rops.loose_vertices, lrfs=lrfs, projections=projections(rops), threads=threads,
    )


def projections(config: RopsConfig) -> Projections:
    """
    Spell out the conventions of the toolbox that `config` follows (METHOD 4).

    Parameters
    ----------
    config : RopsConfig
        `author`: T = 3 gives 15, 45, 75 degrees; axes z, y, x; bits; keypoint left out; plain
        sum. `pcl`: 22.5, 45, 67.5 degrees; axes x, y, z; nats; L1 norm.

    Returns
    -------
    Projections
    """
    author = config.convention == 'author'
    axes = (2, 1, 0) if author else (0, 1, 2)
    parts, shift = (config.rotations, 0.5) if author else (config.rotations + 1, 1.0)
    angles = [math.radians(90.0 * (k + shift) / parts) for k in range(config.rotations)]
    # PCL turns by the right-hand rule, the author's toolbox clockwise about x and z.
    signs = {0: 1, 1: 1, 2: 1} if author else {0: -1, 1: 1, 2: -1}
    return Projections(
        axes=tuple(axis for axis in axes for _ in angles),
        angles=tuple(signs[axis] * angle for axis in axes for angle in angles),
        bins=config.bins,
        log_unit=1.0 / math.log(2.0) if author else 1.0,
        skip_keypoint=author,
        absolute_norm=not author,
    )
