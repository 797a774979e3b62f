# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Errors of depth cameras: noise that grows with depth, steps, missing and flying pixels."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.types import Floats, Ints

NEIGHBOURS = ((0, 1), (2, 1), (1, 0), (1, 2))


@dataclass(frozen=True, slots=True)
class DepthNoise:
    """
    Errors of a depth camera; the defaults resemble a stereo camera at arm's length.

    Parameters
    ----------
    axial : float
        Standard deviation of the depth is this times its square (1 / unit of length).
    quantum : float
        Step of the depth is this times the square of its median (1 / unit of length).
    grazing_deg : float
        Pixels seen at more than this angle from the surface's normal are missing.
    edge : float
        Pixels whose depth jumps by more than this share to a neighbour are missing, every
        other one on average.
    lost : float
        Share of the other pixels that are missing.
    disparity : float
        Step of one over the depth, as a stereo camera has it: the depth's step is this times
        its square (1 / unit of length).
    flying : float
        Share of the pixels at a jump, of those not missing, that lie between both depths.
    """

    axial: float = 0.002
    quantum: float = 0.001
    grazing_deg: float = 78.0
    edge: float = 0.02
    lost: float = 0.005
    disparity: float = 0.0
    flying: float = 0.0


PRESETS: dict[str, DepthNoise | None] = {
    'none': None,
    # 0.08 px of disparity at 385 px and 50 mm; Intel's steps of 1/32 px.
    'd435': DepthNoise(0.0042, 0.0, 75.0, 0.02, 0.005, 0.0016, 0.05),
    # Khoshelham and Oude Elberink (2012): noise of half a step, 2.85 mm at 1 m.
    'kinect': DepthNoise(0.001425, 0.0, 70.0, 0.02, 0.01, 0.00285, 0.10),
    # Phase-shift projectors: 0.05 mm at 0.5 m.
    'structured-light': DepthNoise(0.0002, 0.0, 80.0, 0.02, 0.002),
}
"""Errors by kind of sensor, lengths in metres."""


def cosines(face: Ints, local: Floats, faces: Ints, rays: Floats) -> Floats:
    """
    Return the cosine (H, W) between each ray and the normal of the face that it hits.

    Parameters
    ----------
    face : (H, W) int32
        What each ray hits; where it is -1 the value means nothing.
    local : (N, 3) float64
        Vertices in the camera's frame.
    faces : (F, 3) int
    rays : (H, W, 3) float64
    """
    corners = local[faces[face]]
    normals = np.cross(corners[..., 1, :] - corners[..., 0, :],
                       corners[..., 2, :] - corners[..., 0, :])
    length = np.linalg.norm(normals, axis=-1) * np.linalg.norm(rays, axis=-1)
    result: Floats = np.abs((normals * rays).sum(axis=-1)) / np.where(length > 0, length, 1.0)
    return result


def disturb(
    depth: Floats, cosine: Floats, noise: DepthNoise, rng: np.random.Generator
) -> Floats:
    """
    Return the depth (H, W) as the camera tells it; NaN where it tells nothing.

    Parameters
    ----------
    depth : (H, W) float64
        Exact; NaN where nothing is.
    cosine : (H, W) float64
        Between ray and surface normal.
    noise : DepthNoise
    rng : Generator
    """
    jumps = _jumps(depth, noise.edge)
    lost = rng.random(depth.shape) < noise.lost
    lost |= jumps & (rng.random(depth.shape) < 0.5)
    lost |= cosine < np.cos(np.deg2rad(noise.grazing_deg))
    if noise.flying > 0:
        between = rng.random(depth.shape) * (rng.random(depth.shape) < noise.flying)
        depth = np.where(jumps, depth + between * (_farthest(depth) - depth), depth)
    noisy = depth + rng.normal(0.0, 1.0, depth.shape) * noise.axial * depth**2
    seen = np.isfinite(depth).any()
    step = noise.quantum * np.nanmedian(depth) ** 2 if noise.quantum > 0 and seen else 0.0
    if step > 0:
        noisy = np.rint(noisy / step) * step
    if noise.disparity > 0:
        counts = np.rint(1.0 / (noisy * noise.disparity))
        noisy = 1.0 / (np.maximum(counts, 1.0) * noise.disparity)
    return np.where(lost, np.nan, noisy)


def _neighbours(depth: Floats) -> list[Floats]:
    padded = np.pad(depth, 1, constant_values=np.nan)
    height, width = depth.shape
    return [padded[dv:dv + height, du:du + width] for dv, du in NEIGHBOURS]


def _jumps(depth: Floats, share: float) -> NDArray[np.bool_]:
    """Return which pixels have a neighbour at a much different depth, or none."""
    result = np.zeros(depth.shape, dtype=bool)
    for other in _neighbours(depth):
        result |= ~(np.abs(other - depth) <= share * depth)
    return result


def _farthest(depth: Floats) -> Floats:
    """Return the largest depth among each pixel and its neighbours."""
    result = depth
    for other in _neighbours(depth):
        result = np.fmax(result, other)
    return result
