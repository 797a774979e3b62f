# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""NumPy twin of the kernel ros_rops/kernels/src/fine.cpp."""

import numpy as np
from scipy.spatial import cKDTree

RIM_OFFSET = 0.15
LEAST_NEIGHBOURS = 6


def planes(points, normals, boundary, support):
    """Return normals (N, 3), thickness (N,) and usable (N,) of the planes at all points."""
    tree = cKDTree(points)
    fitted, thickness = np.zeros_like(points), np.zeros(len(points))
    usable = np.zeros(len(points), dtype=bool)
    for i, point in enumerate(points):
        offsets = points[tree.query_ball_point(point, support)] - point
        weights = 1.0 - (offsets ** 2).sum(axis=1) / support ** 2
        offsets, weights = offsets[weights > 0], weights[weights > 0]
        mean = weights @ offsets / weights.sum()
        moment = (offsets * weights[:, None]).T @ offsets / weights.sum()
        values, vectors = np.linalg.eigh(moment - np.outer(mean, mean))
        normal = vectors[:, 0] * (-1.0 if vectors[:, 0] @ normals[i] < 0 else 1.0)
        aside = np.linalg.norm(mean - (mean @ normal) * normal)
        fitted[i], thickness[i] = normal, np.sqrt(max(values[0], 0.0))
        usable[i] = (
            len(weights) >= LEAST_NEIGHBOURS and normals[i] @ normal != 0
            and not (boundary[i] and aside > RIM_OFFSET * support))
    return fitted, thickness, usable


def placed(pose, points):
    return points @ pose[:3, :3].T + pose[:3, 3]


def match(source, target, samples, radius, min_cos):
    """
    Match samples of one placed view (points, normals, usable) with another.

    Returns the indices of the pairs and how many samples have a neighbour at all.
    """
    distance, found = cKDTree(target[0]).query(
        source[0][samples], distance_upper_bound=radius)
    near = np.isfinite(distance)
    from_, to = samples[near], found[near]
    cosines = np.einsum('ni,ni->n', source[1][from_], target[1][to])
    fits = target[2][to] & (cosines >= min_cos)
    return from_[fits], to[fits], int(near.sum())


def normal_equations(source, target, samples, centre, radius, min_cos, soft):
    """Return hessian (6, 6), gradient (6,), and tried, near, used, absolute, weight."""
    from_, to, near = match(source, target, samples, radius, min_cos)
    x, y = source[0][from_], target[0][to]
    normal = source[1][from_] + target[1][to]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    r = np.einsum('ni,ni->n', normal, x - y)
    taper = np.maximum(0.0, 1.0 - ((x - y) ** 2).sum(axis=1) / radius ** 2)
    weight = taper ** 2 / np.sqrt(1.0 + (r / soft) ** 2)
    rows = np.concatenate([np.cross((x + y) / 2 - centre, normal), normal], axis=1)
    return (
        (rows * weight[:, None]).T @ rows, rows.T @ (weight * r),
        [len(samples), near, len(from_), np.abs(r).sum(), weight.sum()])
