# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The supporting plane: found among the patches, refined on the points.

Deterministic: the planes of evenly chosen patches are tried on all patches, the best is refined,
its patches are set aside, and so on. The supporting plane is the largest on which something
stands: patches rise from it within its own extent, which keeps walls behind the scene out.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Floats
from ros_rops.segmentation.footprint import Footprint, footprint_of
from ros_rops.segmentation.patches import Patches, towards_sensor
from ros_rops.segmentation.scan import dot, Image, Scan

SEEDS = 100
"""Patches whose planes are tried, at most, ..."""
VOTES = 1500
"""... on so many patches at most."""
SAMPLE = 10_000
"""Points that the first rounds of a fit and the noise are measured on, at most ..."""
LAST = 40_000
"""... and the last round of the fit."""
PLANES = 4
"""Planes looked for in a frame, at most."""
TOLERANCE = 0.008
"""A patch is of a plane within this share of its depth ..."""
LEAST_COSINE = float(np.cos(np.deg2rad(15.0)))
"""... and when its normal is the plane's within 15 degrees."""
LEAST_FOOT = 2
"""So many patches that rise from a plane are something that stands on it ..."""
STEEP = 0.25
"""... more surely if they are seen at more than this cosine: others may be of a depth edge."""
NEAR = 3.0
"""The plane is fitted to points within so many standard deviations of its noise."""
FLOOR = 1e-4
"""Least noise assumed, as a share of the depth: rounding and small waves of the plane."""
GAUSS = 1.4826
"""Standard deviation over the median absolute one."""


@dataclass(frozen=True, slots=True)
class Plane:
    """normal . p = offset, the normal (3,) unit and towards the sensor."""

    normal: Floats
    offset: float


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviation of the distances from the plane: base + growth * depth^2."""

    base: float
    growth: float

    def at(self, depth: Image) -> Image:
        """Return the standard deviation at each depth, never below `FLOOR` of it."""
        base, growth, floor = (depth.dtype.type(v) for v in (self.base, self.growth, FLOOR))
        result: Image = np.maximum(base + growth * depth * depth, floor * depth)
        return result


@dataclass(frozen=True, slots=True)
class Support:
    """
    A supporting plane.

    Parameters
    ----------
    plane : Plane
    noise : Noise
    extent : Footprint
    middle : (3,) float64
        Of the points it was fitted to.
    inliers : int
        Points it was fitted to.
    spread : float
        Their root mean square distance from it.
    patch : float
        Size of the patches it was found on.
    carries : bool
        Whether something seems to stand on it.
    """

    plane: Plane
    noise: Noise
    extent: Footprint
    middle: Floats
    inliers: int
    spread: float
    patch: float
    carries: bool

    @property
    def margin(self) -> float:
        """How far within the extent a point must lie to be over the plane."""
        return 2 * self.patch


def find_support(
    scan: Scan, patches: Patches, usable: Bools, least_share: float
) -> Support | None:
    """
    Return the supporting plane of a frame, None where there is no plane.

    Parameters
    ----------
    scan : Scan
    patches : Patches
        Of the usable points.
    usable : (N,) bool
    least_share : float
        Least share of the patched points that a plane holds.
    """
    largest = chosen = None
    steep = _steep(scan, patches)
    for candidate in _planes(patches, least_share):
        largest = largest or candidate
        feet = _feet(patches, *candidate)
        if np.count_nonzero(feet & ~steep) >= LEAST_FOOT:
            chosen = candidate
            break
        if chosen is None and np.count_nonzero(feet) >= LEAST_FOOT:
            chosen = candidate
    if largest is None:
        return None
    plane, members = chosen or largest
    near = np.append(members, False)[patches.owner] & usable
    patch = float(np.median(patches.size[members]))
    return _refined(scan, plane, np.flatnonzero(near), patch, chosen is not None)


def _heights(patches: Patches, plane: Plane) -> Floats:
    heights: Floats = dot(patches.centres, plane.normal) - plane.offset
    return heights


def _planes(patches: Patches, least_share: float) -> Iterator[tuple[Plane, Bools]]:
    """Yield planes with their patches: the largest first, then the largest of the rest."""
    known = (patches.normals != 0).any(axis=1)
    least = least_share * patches.weights.sum()
    free = known.copy()
    for _ in range(PLANES):
        if patches.weights[free].sum() < least or not free.any():
            return
        plane = _refit(patches, _best_seed(patches, free), free)
        members = free & _of_plane(patches, plane)
        if patches.weights[members].sum() < max(least, 1.0) or np.count_nonzero(members) < 3:
            return
        yield plane, members
        free &= ~members


def _of_plane(patches: Patches, plane: Plane, share: float = TOLERANCE) -> Bools:
    close = np.abs(_heights(patches, plane)) <= share * patches.depth
    members: Bools = close & (dot(patches.normals, plane.normal) >= LEAST_COSINE)
    return members


def _best_seed(patches: Patches, free: Bools) -> Plane:
    """Return the plane of the patch that most others lie on."""
    which = np.flatnonzero(free)
    seeds, votes = _some(which, SEEDS), _some(which, VOTES)
    offsets = (patches.centres[seeds] * patches.normals[seeds]).sum(axis=1)
    # Spelled out: a BLAS product may round differently with another number of threads.
    a, b, c = (patches.normals[seeds, k, None] for k in range(3))
    x, y, z = patches.centres[votes].T
    heights = a * x + b * y + c * z - offsets[:, None]
    x, y, z = patches.normals[votes].T
    fits = np.abs(heights) <= TOLERANCE * patches.depth[votes]
    fits &= a * x + b * y + c * z >= LEAST_COSINE
    best = int(np.argmax((fits * patches.weights[votes]).sum(axis=1)))
    return Plane(patches.normals[seeds[best]], float(offsets[best]))


def _some(which: NDArray, most: int) -> NDArray:
    """Return at most so many of the indices, evenly chosen."""
    return which[np.linspace(0, len(which) - 1, min(most, len(which))).astype(np.int64)]


def _refit(patches: Patches, plane: Plane, free: Bools) -> Plane:
    for share in (TOLERANCE, TOLERANCE, TOLERANCE / 2, TOLERANCE / 2):
        members = free & _of_plane(patches, plane, share)
        if np.count_nonzero(members) < 3:
            return plane
        plane = fit(patches.centres[members].T, patches.weights[members], plane)
    return plane


def fit(points: Floats, weights: Floats | None, before: Plane) -> Plane:
    """Return the plane of least squares through points (3, M), its normal as that of `before`."""
    total = points.shape[1] if weights is None else weights.sum()
    weighted = points if weights is None else points * weights
    middle = weighted.sum(axis=1) / total
    off = points - middle[:, None]
    weighted = off if weights is None else off * weights
    spread = np.empty((3, 3))
    for i in range(3):
        for j in range(i, 3):
            spread[i, j] = spread[j, i] = (weighted[i] * off[j]).sum()
    normal = np.linalg.eigh(spread)[1][:, 0]
    if normal @ before.normal < 0:
        normal = -normal
    return Plane(normal, float(normal @ middle))


def _feet(patches: Patches, plane: Plane, members: Bools) -> Bools:
    """Return which patches rise from the plane well within its extent."""
    heights = _heights(patches, plane)
    size = float(np.median(patches.size[members]))
    extent = footprint_of(patches.centres[members], plane.normal, 0.0)
    foot = (heights > TOLERANCE * patches.depth) & (heights < 3 * size) & (patches.weights > 0)
    foot &= (patches.normals != 0).any(axis=1)
    foot[foot] = extent.holds(patches.centres[foot], 2 * size)
    return foot


def _steep(scan: Scan, patches: Patches) -> Bools:
    """Return which patches are seen so flat that they may hang between two surfaces."""
    view = towards_sensor(scan, patches.centres)
    cosine = (view * patches.normals).sum(axis=1)
    result: Bools = cosine < STEEP * np.linalg.norm(view, axis=1)
    return result


def _refined(
    scan: Scan, plane: Plane, near: NDArray, patch: float, carries: bool
) -> Support:
    """Fit the plane to its points, the noise measured anew each round; the last takes most."""
    noise = None
    for which in (_some(near, SAMPLE), _some(near, SAMPLE), _some(near, LAST)):
        points, depth = scan.columns(which), scan.depth[which]
        limit = TOLERANCE * depth if noise is None else NEAR * noise.at(depth)
        inside = np.abs(height_of(points, plane)) <= limit
        if np.count_nonzero(inside) < 3:
            break
        points = points[:, inside]
        plane = fit(points, None, plane)
        heights = height_of(points, plane)
        few = slice(None, None, max(1, len(heights) // SAMPLE))
        noise = measure_noise(np.abs(heights[few]), depth[inside][few])
    # Patches at its rim have no normal: they took no part, yet are of the plane.
    extent = footprint_of(points.T, plane.normal, 0.001).wider(patch)
    return Support(
        plane, noise or Noise(0.0, 0.0), extent, points.mean(axis=1), points.shape[1],
        float(np.sqrt((height_of(points, plane)**2).mean())), patch, carries)


def height_of(points: Floats, plane: Plane) -> Floats:
    """Return the signed distance of points (3, M) from a plane."""
    a, b, c = plane.normal
    heights: Floats = points[0] * a + points[1] * b + points[2] * c - plane.offset
    return heights


def measure_noise(off: Floats, depth: Image) -> Noise:
    """Return the noise of distances `off` from a plane, as it grows with the depth."""
    near, far = np.quantile(depth, [0.25, 0.75]).astype(np.float64)
    low = GAUSS * float(np.median(off[depth <= near]))
    high = GAUSS * float(np.median(off[depth >= far]))
    a, b = float(np.mean(depth[depth <= near]**2)), float(np.mean(depth[depth >= far]**2))
    if high <= low or b <= 1.05 * a:
        return Noise(max(low, high) if high > low else (low + high) / 2, 0.0)
    growth = min((high - low) / (b - a), low / a)
    return Noise(low - growth * a, growth)
