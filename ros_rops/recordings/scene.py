# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a camera sees of a station: objects on a turntable, and the table."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.types import Bytes, Floats
from ros_rops.recordings.depth_noise import cosines, DepthNoise, disturb
from ros_rops.recordings.raycast import Camera, cast
from ros_rops.recordings.synthetic import Model

TABLE_COLOR = (58, 58, 62)


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A model and where it stands, `T_turntable_object` (4, 4)."""

    model: Model
    T_turntable_object: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """
    What one look of the camera gives.

    Parameters
    ----------
    depth : (H, W) float64
        Along the optical axis; NaN where nothing was measured.
    colors : (H, W, 3) uint8 or None
        Black where nothing is.
    """

    depth: Floats
    colors: Bytes | None


def look(
    objects: Sequence[Placed], T_camera_turntable: Floats, camera: Camera, *,
    table_radius: float = 0.0, noise: DepthNoise | None = None,
    rng: np.random.Generator | None = None,
) -> Picture:
    """
    Render objects that stand on a turntable.

    Parameters
    ----------
    objects : sequence of Placed
        Those that are there.
    T_camera_turntable : (4, 4) float64
        The turntable's frame lies on its surface, z up.
    camera : Camera
    table_radius : float
        Of a flat disc around the turntable's origin; 0 for no table.
    noise : DepthNoise or None
        None for exact depths.
    rng : Generator or None
        Source of the errors; none are made without it.
    """
    rays = camera.rays()
    vertices, faces, tints = _one_mesh(objects)
    local = vertices @ T_camera_turntable[:3, :3].T + T_camera_turntable[:3, 3]
    depth, face = cast(local, faces, camera)
    cosine = cosines(face, local, faces, rays) if len(faces) else np.ones(depth.shape)
    colors = None
    if tints is not None:
        colors = np.where((face >= 0)[..., None], tints[faces[face, 0]], 0).astype(np.uint8)
    if table_radius > 0:
        flat, slope = _table(T_camera_turntable, rays, table_radius)
        nearer = ~(flat >= depth) & np.isfinite(flat)
        depth = np.where(nearer, flat, depth)
        cosine = np.where(nearer, slope, cosine)
        if colors is not None:
            colors[nearer] = TABLE_COLOR
    if noise is not None and rng is not None:
        depth = disturb(depth, cosine, noise, rng)
    return Picture(depth, colors)


def _one_mesh(objects: Sequence[Placed]) -> tuple[Floats, NDArray[np.int32], Bytes | None]:
    vertices, faces, tints, start = [np.zeros((0, 3))], [np.zeros((0, 3), np.int32)], [], 0
    for one in objects:
        T = one.T_turntable_object
        vertices.append(one.model.vertices @ T[:3, :3].T + T[:3, 3])
        faces.append(one.model.faces + start)
        start += len(one.model.vertices)
        if one.model.colors is not None:
            tints.append(one.model.colors)
    painted = len(tints) == len(objects) and bool(tints)
    return (np.concatenate(vertices), np.concatenate(faces).astype(np.int32),
            np.concatenate(tints) if painted else None)


def _table(T_camera_turntable: Floats, rays: Floats, radius: float) -> tuple[Floats, Floats]:
    """Depth of the disc behind every pixel, NaN where none, and the cosine of incidence."""
    normal, middle = T_camera_turntable[:3, 2], T_camera_turntable[:3, 3]
    along = rays @ normal
    with np.errstate(divide='ignore', invalid='ignore'):
        depth = (middle @ normal) / along
    off = depth[..., None] * rays - middle
    on = (depth > 0) & ((off**2).sum(axis=-1) <= radius**2)
    cosine = np.abs(along) / np.linalg.norm(rays, axis=-1)
    return np.where(on, depth, np.nan), cosine
