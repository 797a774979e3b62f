# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""In which frame a model is compared: what is the frame's error, and what is the shape's."""

from collections.abc import Mapping

import numpy as np
from ros_rops.bench.judgement import best_alignment, Placement, ViewTruth
from ros_rops.bench.model_distance import Triangles
from ros_rops.core.se3 import move
from ros_rops.core.types import Floats
from scipy.spatial.transform import Rotation

SAMPLES = 20_000
ROUNDS = 30
REACH_DRES = 3.0
SLIDING = 1e-3
"""A motion stiffer than none by less than this share slides along the surface: not made."""
STILL = 1e-4
"""A step that moves nothing by so many dres ends it."""


def aligned_poses(
    T_object_view: Mapping[str, Floats], T_world_view: Mapping[str, Floats],
    centroids: Mapping[str, Floats], dres: float,
) -> dict[str, Floats]:
    """
    Carry estimated poses to the reference's world as a whole (EVALUATION: multi-view).

    Parameters
    ----------
    T_object_view : mapping of str to (4, 4) float64
        Of the views placed.
    T_world_view : mapping of str to (4, 4) float64
        The reference, of these at least.
    centroids : mapping of str to (3,) float64
        Mean of each view's points, in its own frame.
    dres : float

    Returns
    -------
    mapping of str to (4, 4) float64
        `T_world_view` of each view placed, as estimated.
    """
    names = list(T_object_view)
    T_world_object = best_alignment(
        [Placement('0', T_object_view[name]) for name in names],
        [ViewTruth('0', T_world_view[name], centroids[name], dres) for name in names])
    return {name: T_world_object @ T_object_view[name] for name in names}


def settled(
    vertices: Floats, faces: Floats, reference: Triangles, dres: float, seed: int = 0
) -> Floats:
    """
    Lay a model onto its reference by point-to-plane ICP; returns the rigid motion, (4, 4).

    Even samples of the model against the nearest places of the reference, those within 3 dres
    that are not on an open edge's far side: what is left after it is shape, not frame.
    """
    points = Triangles(vertices, faces).samples(SAMPLES, seed)[0]
    total = np.eye(4)
    for _ in range(ROUNDS):
        moved = move(total, points)
        closest = reference.closest(moved)
        near = closest.distance < REACH_DRES * dres
        if near.sum() < 6:
            break
        step = _step(moved[near], closest.foot[near], reference.normals_at(closest)[near])
        total = step @ total
        if np.abs(move(step, moved[near]) - moved[near]).max() < STILL * dres:
            break
    return total


def _step(points: Floats, feet: Floats, normals: Floats) -> Floats:
    middle = points.mean(axis=0)
    lever = float(np.linalg.norm(points - middle, axis=1).mean())
    rows = np.concatenate([np.cross(points - middle, normals) / lever, normals], axis=1)
    gaps = np.einsum('nd,nd->n', feet - points, normals)
    motion = np.linalg.lstsq(rows.T @ rows, rows.T @ gaps, rcond=SLIDING)[0]
    motion[:3] /= lever
    result = np.eye(4)
    result[:3, :3] = Rotation.from_rotvec(motion[:3]).as_matrix()
    result[:3, 3] = middle + motion[3:] - result[:3, :3] @ middle
    return result
