# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Frames and RoPS in NumPy, one line per formula of METHOD 3 and 4; slow and plain."""

import math

import numpy as np


def frame(vertices, faces, point, radius, touching=False):
    """Return (lrf (3, 3), eigenvalues (3,)) by the paper's sums over triangle corners."""
    offsets = vertices[faces] - point
    inside = np.linalg.norm(offsets, axis=2) <= radius
    d = offsets[inside.any(axis=1) if touching else inside.all(axis=1)]
    area = np.linalg.norm(np.cross(d[:, 1] - d[:, 0], d[:, 2] - d[:, 0]), axis=1)
    weight = area * (radius - np.linalg.norm(d.mean(axis=1), axis=1)) ** 2
    pairs = np.einsum('fja,fkb->fab', d, d) + np.einsum('fja,fjb->fab', d, d)
    values, vectors = np.linalg.eigh(np.einsum('f,fab->ab', weight, pairs / 12))
    heavier = np.einsum('f,fja->a', weight, d) / 6
    v1, v3 = (v if v @ heavier >= 0 else -v for v in (vectors[:, 2], vectors[:, 0]))
    return np.array([v1, np.cross(v3, v1), v3]), values[::-1]


def toldi_frame(vertices, point, normal, radius, normal_radius):
    """Return the (3, 3) frame of a smaller support's normal and a weighted projection."""
    offsets = vertices - point
    distance = np.linalg.norm(offsets, axis=1)
    z = np.linalg.eigh(np.cov(offsets[distance <= normal_radius].T))[1][:, 0]
    z = z if z @ normal >= 0 else -z
    d, distance = offsets[distance <= radius], distance[distance <= radius]
    x = ((radius - distance) ** 2 * (d @ z) ** 2) @ (d - np.outer(d @ z, z))
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


def descriptor(vertices, point, lrf, radius, how):
    """Return the (15 R,) RoPS vector of the support, `how` being a `Projections`."""
    d = vertices - point
    distance = np.linalg.norm(d, axis=1)
    support = distance <= radius
    if how.skip_keypoint:
        support &= distance > 0
    local = d[support] @ lrf.T
    values = []
    for axis, angle in zip(how.axes, how.angles, strict=True):
        turned = _turn(local, axis, angle)
        for row, column in ((0, 1), (0, 2), (1, 2)):
            values += _statistics(_distribution(turned, row, column, how.bins), how.log_unit)
    values = np.array(values)
    return values / (np.abs(values).sum() if how.absolute_norm else values.sum())


def _turn(points, axis, angle):
    first, second = ((1, 2), (0, 2), (0, 1))[axis]
    turned = points.copy()
    cosine, sine = math.cos(angle), math.sin(angle)
    turned[:, first] = cosine * points[:, first] + sine * points[:, second]
    turned[:, second] = cosine * points[:, second] - sine * points[:, first]
    return turned


def _distribution(points, row, column, bins):
    low, high = points.min(axis=0), points.max(axis=0)
    place = np.minimum(((points - low) / (high - low) * bins).astype(int), bins - 1)
    matrix = np.zeros((bins, bins))
    np.add.at(matrix, (place[:, row], place[:, column]), 1 / len(points))
    return matrix


def _statistics(matrix, log_unit):
    index = np.arange(1.0, len(matrix) + 1)
    u = (index - matrix.sum(axis=1) @ index)[:, None]
    v = (index - matrix.sum(axis=0) @ index)[None, :]
    filled = matrix[matrix > 0]
    moments = [(u**m * v**n * matrix).sum() for m, n in ((1, 1), (2, 1), (1, 2), (2, 2))]
    return [*moments, -(filled * np.log(filled)).sum() * log_unit]
