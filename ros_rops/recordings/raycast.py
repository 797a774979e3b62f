# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a pinhole camera sees of a triangle mesh: depth and triangle behind every pixel."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.types import Floats, Ints

CHUNK = 2_000_000
"""Most (triangle, pixel) candidates held at once."""


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera, z forward, x right, y down; lengths in pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def rays(self) -> Floats:
        """Return the point at depth 1 behind every pixel, (H, W, 3)."""
        v, u = np.mgrid[:self.height, :self.width]
        x, y = (u - self.cx) / self.fx, (v - self.cy) / self.fy
        return np.stack([x, y, np.ones(x.shape)], axis=-1)


def cast(vertices: Floats, faces: Ints, camera: Camera) -> tuple[Floats, Ints]:
    """
    Return the depth (H, W; NaN where nothing) and the nearest face (H, W; -1).

    Rays pass the pixels' centres exactly; the depth is that of the triangle on the ray.

    Parameters
    ----------
    vertices : (N, 3) float64
        In the camera's frame.
    faces : (F, 3) int
    camera : Camera
        Triangles that reach behind it are not seen.
    """
    z = vertices[:, 2]
    safe = np.where(z > 0, z, 1.0)
    pixels = np.stack([
        camera.fx * vertices[:, 0] / safe + camera.cx,
        camera.fy * vertices[:, 1] / safe + camera.cy], axis=1)
    depth = np.full(camera.height * camera.width, np.inf)
    owner = np.full(depth.shape, -1, np.int32)
    low, size = _boxes(pixels[faces], z[faces], camera)
    area = size.prod(axis=1)
    seen = np.flatnonzero(area > 0)
    parts = np.cumsum(area[seen]) // CHUNK
    for part in np.unique(parts):
        chunk = seen[parts == part]
        _draw(chunk, low, size, pixels[faces[chunk]], z[faces[chunk]], camera, depth, owner)
    shape = (camera.height, camera.width)
    return np.where(owner < 0, np.nan, depth).reshape(shape), owner.reshape(shape)


def _boxes(
    corners: Floats, z: Floats, camera: Camera
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Lowest pixel and number of pixels (u, v) of each triangle's bounding box in the image."""
    limit = np.array([camera.width, camera.height])
    low = np.ceil(np.clip(corners.min(axis=1), 0, limit)).astype(np.int64)
    high = np.floor(np.clip(corners.max(axis=1), -1, limit - 1)).astype(np.int64)
    size = np.maximum(high - low + 1, 0)
    size[(z <= 0).any(axis=1)] = 0
    return low, size


def _draw(
    chunk: NDArray[np.int64], low: NDArray[np.int64], size: NDArray[np.int64],
    corners: Floats, z: Floats, camera: Camera, depth: Floats, owner: Ints,
) -> None:
    """Test every candidate pixel of the triangles in `chunk` and keep the nearest hits."""
    count = size[chunk].prod(axis=1)
    which = np.repeat(np.arange(len(chunk)), count)
    inner = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    wide = size[chunk[which], 0]
    u = low[chunk[which], 0] + inner % wide
    v = low[chunk[which], 1] + inner // wide
    (x0, y0), (x1, y1), (x2, y2) = (corners[which, k].T for k in range(3))
    w0 = (x1 - u) * (y2 - v) - (x2 - u) * (y1 - v)
    w1 = (x2 - u) * (y0 - v) - (x0 - u) * (y2 - v)
    w2 = (x0 - u) * (y1 - v) - (x1 - u) * (y0 - v)
    total = w0 + w1 + w2
    hit = ((w0 >= 0) & (w1 >= 0) & (w2 >= 0)) | ((w0 <= 0) & (w1 <= 0) & (w2 <= 0))
    hit &= total != 0
    weights = np.stack([w0, w1, w2], axis=1)[hit] / total[hit, None]
    found = 1.0 / (weights / z[which[hit]]).sum(axis=1)  # 1/z is linear in the image
    pixel = v[hit] * camera.width + u[hit]
    order = np.lexsort((chunk[which[hit]], found, pixel))
    first = np.unique(pixel[order], return_index=True)[1]
    best = order[first]
    nearer = found[best] < depth[pixel[best]]
    depth[pixel[best[nearer]]] = found[best[nearer]]
    owner[pixel[best[nearer]]] = chunk[which[hit][best[nearer]]]
