# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Lines of sight in NumPy: every point against every triangle, no look-up."""

import numpy as np


def look(points, vertices, faces, weights, sensor, T_object_view):
    """Return distance, weight and cosine (M,) of points in the object's frame."""
    local = (points - T_object_view[:3, 3]) @ T_object_view[:3, :3]
    if sensor.kind == 'pinhole':
        origins = np.broadcast_to(np.asarray(sensor.origin), local.shape)
        rays = local - origins
    else:
        rays = np.broadcast_to(np.asarray(sensor.direction), local.shape)
        origins = local - 1e3 * rays
    rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    return np.array([
        _one(p, o, r, vertices[faces], weights[faces])
        for p, o, r in zip(local, origins, rays, strict=True)]).T


def _one(point, origin, ray, corners, weights):
    """Moeller and Trumbore 1997."""
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(ray, ac)
    det = np.einsum('ij,ij->i', ab, across)
    with np.errstate(all='ignore'):
        y = np.einsum('ij,ij->i', origin - a, across) / det
        turned = np.cross(origin - a, ab)
        z = turned @ ray / det
        far = np.einsum('ij,ij->i', ac, turned) / det
    hit = (y >= -1e-9) & (z >= -1e-9) & (y + z <= 1 + 1e-9) & (far > 0)
    if not hit.any():
        return np.nan, 0.0, 0.0
    f = np.flatnonzero(hit)[np.argmin(far[hit])]
    normal = np.cross(ab[f], ac[f])
    return (
        far[f] - (point - origin) @ ray, weights[f] @ [1 - y[f] - z[f], y[f], z[f]],
        abs(normal @ ray) / np.linalg.norm(normal))
