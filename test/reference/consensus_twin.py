# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The kernel of the assembled cloud in NumPy."""

import numpy as np

LEAST_COSINE, FULL_COSINE, RIDGE, SLACK, STEPS = 0.2, 0.7, 0.01, 1.25, 2


def agree(samples, target, reach, move=True):
    """Return (point, normal, weight, view, directions, support, colour) of one target."""
    start = samples.points[target]
    normal = samples.normals[target].astype(np.float64)
    offsets = samples.points - start
    near = (np.square(offsets).sum(axis=1) < (SLACK * reach.radius)**2) & (
        samples.normals @ normal > 0)
    offsets, normals = offsets[near], samples.normals[near].astype(np.float64)
    weights, shift = samples.weights[near].astype(np.float64), np.zeros(3)
    if move:
        share, *_ = _look(offsets, normals, shift, normal, reach.radius)
        normal = _unit((weights * share) @ normals)
        for _ in range(STEPS):
            shift, normal = _step(offsets, normals, weights, shift, normal, reach.radius)
    share, _, across, _ = _look(offsets, normals, shift, normal, reach.radius)
    views, colors = samples.views[near], samples.colors
    heavy, total, directions = {}, 0.0, 0
    for view in np.unique(views[share > 0]):
        own = (views == view) & (share > 0)
        heavy[view] = float((weights * share)[own].sum())
        total += heavy[view] / share[own].sum()
        directions += bool((across[own] < reach.near**2).any())
    color = _color(colors[near], weights * share, across, reach) if len(colors) else np.zeros(3)
    return (start + shift, normal, total, max(heavy, key=heavy.get), directions,
            int((share > 0).sum()), color)


def _unit(vector):
    return vector / np.linalg.norm(vector)


def _look(offsets, normals, shift, normal, radius):
    away = offsets - shift
    along, cosine = away @ normal, normals @ normal
    across = np.square(away).sum(axis=1) - along**2
    like = np.clip((cosine - LEAST_COSINE) / (FULL_COSINE - LEAST_COSINE), 0, 1)
    flat, high = (np.maximum(1 - x / radius**2, 0)**2 for x in (across, along**2))
    return flat * high * like, along, across, cosine


def _step(offsets, normals, weights, shift, normal, radius):
    share, along, _, cosine = _look(offsets, normals, shift, normal, radius)
    away, w = offsets - shift, weights * share
    helper = np.array([1.0, 0, 0]) if abs(normal[0]) < 0.8 else np.array([0, 1.0, 0])
    e = _unit(np.cross(helper, normal))
    sides = np.stack([away @ e, away @ np.cross(normal, e)], axis=1)
    height = (along + np.einsum('ij,ij->i', away, normals)) / np.maximum(1 + cosine, 1)
    middle = w @ sides / w.sum()
    spread = (sides - middle).T @ ((sides - middle) * w[:, None]) + (
        RIDGE * w.sum() * radius**2 * np.eye(2))
    lean, tilt = (np.linalg.solve(spread, (sides - middle).T @ (w * h)) for h in (height, along))
    rise = w @ height / w.sum() - lean @ middle
    f = np.cross(normal, e)
    return shift + rise * normal, _unit(normal - tilt[0] * e - tilt[1] * f)


def _color(colors, weights, across, reach):
    weights = weights * (colors[:, 3] > 0)
    narrow = weights * np.maximum(1 - across / reach.paint**2, 0)**2
    some = narrow if narrow.sum() > 0 else weights
    return np.rint(some @ colors[:, :3] / some.sum()) if some.sum() > 0 else np.zeros(3)


def spread(points, normals, order, spacing):
    """Return the indices that `spread` chooses."""
    chosen = []
    for i in order:
        apart = np.square(points[chosen] - points[i]).sum(axis=1)
        if not ((apart < spacing**2) & (normals[chosen] @ normals[i] >= 0)).any():
            chosen.append(i)
    return np.sort(chosen)


def dents(vertices, faces, normals):
    """Return how far each vertex lies below the mean of its neighbours, NaN without faces."""
    sums, counts = np.zeros_like(vertices), np.zeros(len(vertices))
    for k in range(3):
        for other in (1, 2):
            np.add.at(sums, faces[:, k], vertices[faces[:, (k + other) % 3]])
            np.add.at(counts, faces[:, k], 1)
    with np.errstate(invalid='ignore'):
        return np.einsum('ij,ij->i', sums / counts[:, None] - vertices, normals)
