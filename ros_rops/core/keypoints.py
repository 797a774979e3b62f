# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Feature points of a range view's mesh (Guo et al. 2014, III-A; METHOD 2)."""

import numpy as np
from ros_rops.core.config import KeypointConfig, LrfConfig
from ros_rops.core.lrf import compute_lrfs
from ros_rops.core.simplify import simplify
from ros_rops.core.types import Bools, Floats, Ints, RangeMesh
from ros_rops.kernels.features import thin
from scipy.spatial import cKDTree


def detect_keypoints(
    mesh: RangeMesh,
    config: KeypointConfig,
    radius: float,
    *,
    resolution: float | None = None,
    threads: int = 0,
) -> Ints:
    """
    Detect feature points, the test of their supports included.

    Parameters
    ----------
    mesh : RangeMesh
    config : KeypointConfig
    radius : float
        Of the support that `eigen_ratio` judges, in the mesh's units.
    resolution : float, optional
        What `mr` means; the mesh's own by default.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    (K,) int32
        Vertices, rising.
    """
    candidates = candidate_keypoints(mesh, config, resolution=resolution)
    if config.eigen_ratio <= 1.0:
        return candidates
    _, values = compute_lrfs(mesh, candidates, LrfConfig(method='rops'), radius, threads=threads)
    return candidates[distinct(values, config.eigen_ratio)]


def candidate_keypoints(
    mesh: RangeMesh, config: KeypointConfig, *, resolution: float | None = None
) -> Ints:
    """
    Choose vertices by resolution control, away from the mesh's boundary.

    Method `uniform` chooses among all vertices; `paper` only among those nearest to the
    vertices of a simplified mesh (vertex clustering).

    Parameters
    ----------
    mesh : RangeMesh
    config : KeypointConfig
    resolution : float, optional
        What `mr` means; the mesh's own by default.

    Returns
    -------
    (K,) int32
        Vertices, rising; at most `config.most`.
    """
    unit = resolution or mesh.resolution
    wanted = np.flatnonzero(_interior(mesh, config.boundary_mr * unit)).astype(np.int32)
    if config.method == 'paper':
        wanted = np.intersect1d(wanted, _nearest_to_simplified(mesh, config.cluster_mr * unit))
    return np.sort(_at_most(mesh.vertices, wanted, config.spacing_mr * unit, config.most))


def distinct(eigenvalues: Floats, ratio: float) -> Bools:
    """Tell which supports have lambda1 / lambda2 > `ratio`, from eigenvalues (K, 3)."""
    keep: Bools = eigenvalues[:, 0] > ratio * eigenvalues[:, 1]
    return keep


def _interior(mesh: RangeMesh, margin: float) -> Bools:
    """Vertices of the surface that are farther than `margin` from its boundary."""
    inner = ~mesh.boundary
    candidates = np.flatnonzero(inner)
    if margin > 0 and len(candidates) < len(inner):
        # Vertices without a face bound nothing.
        rim = mesh.vertices[mesh.boundary & mesh.normals.any(axis=1)]
        distance, _ = cKDTree(rim).query(
            mesh.vertices[candidates], distance_upper_bound=margin
        )
        inner[candidates[distance <= margin]] = False
    return inner


def _nearest_to_simplified(mesh: RangeMesh, size: float) -> Ints:
    """Vertices nearest to those of the mesh simplified by clustering in cells of `size`."""
    _, nearest = cKDTree(mesh.vertices).query(simplify(mesh.vertices, size))
    return np.unique(nearest).astype(np.int32)


def _at_most(points: Floats, wanted: Ints, spacing: float, most: int) -> Ints:
    """Thin by `spacing`, by more where more than `most` would remain."""
    kept = thin(points, wanted, spacing)
    while len(kept) > most:
        # On a surface the number falls with the square of the spacing.
        spacing *= max((len(kept) / most) ** 0.5, 1.02)
        kept = thin(points, wanted, spacing)
    return kept
