# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The verification kernels in NumPy, by brute force.

The field's short cut (a cell hands its nearest surface cell on to its neighbours) is left out:
every look-up here compares with all surface cells.
"""

import numpy as np
from scipy.spatial.transform import Rotation

NONE, SEEN, IN_FRONT, EMPTY = range(4)


class EvidenceTwin:
    """What `Evidence.of` makes of a view, as plain arrays about the points' mean."""

    def __init__(self, points, normals, boundary, sensor, *, cell, reach, beyond=None):
        self.centre = points.mean(axis=0)
        self.cell = np.float32(cell)
        local = (points - self.centre).astype(np.float32)
        self.origin = local.min(axis=0) - np.float32((reach + 1) * self.cell)
        homes, at = np.unique(self.locate(local), axis=0, return_inverse=True)
        order = np.lexsort((homes[:, 0], homes[:, 1], homes[:, 2]))
        rank = np.empty(len(homes), int)
        rank[order] = np.arange(len(homes))
        self.homes, at = homes[order], rank[at.reshape(-1)]
        counts = np.bincount(at)
        total = np.stack([np.bincount(at, normals[:, a]) for a in range(3)], axis=1)
        self.means = np.stack([np.bincount(at, local[:, a]) for a in range(3)], axis=1)
        self.means /= counts[:, None]
        self.normals = _unit(total)
        self.border = np.bincount(at, boundary) > 0
        self.samples = _shuffled(len(counts))
        # Vertices sorted by cell, their normals evened out over 27 cells.
        by_cell = np.argsort(at, kind='stable')
        near = np.abs(self.homes[:, None] - self.homes[None]).max(axis=2) <= 1
        agree = self.normals @ self.normals.T > 0
        even = _unit((near & agree) @ (self.normals * counts[:, None]))
        self.vertices, self.rim = local[by_cell].astype(float), boundary[by_cell]
        self.vertex_normals = even[at[by_cell]]
        self.raster = None if sensor.kind == 'unknown' else RasterTwin(
            local, sensor, np.asarray(sensor.origin) - self.centre, self.cell,
            None if beyond is None else beyond - self.centre)

    def locate(self, points):
        return np.floor((points.astype(np.float32) - self.origin) / self.cell).astype(int)

    def closest(self, points):
        """Return for each point the surface cell nearest to the middle of the point's cell."""
        middle = self.origin + (self.locate(points) + 0.5) * self.cell
        return _distances(middle, self.means).argmin(axis=1)

    def closest_vertex(self, points):
        """Return for each point the nearest vertex within a cell's length, else -1."""
        distance = _distances(points, self.vertices)
        best = distance.argmin(axis=1)
        return np.where(distance.min(axis=1) < self.cell, best, -1)


class RasterTwin:
    """Least depth over pixels of about a cell."""

    def __init__(self, points, sensor, origin, pixel, beyond):
        self.pinhole = sensor.kind == 'pinhole'
        w = _unit(np.asarray(sensor.direction, float))
        u = _unit(np.cross([1.0, 0, 0] if abs(w[0]) < 0.8 else [0, 1.0, 0], w))
        self.axes = np.stack([u, np.cross(w, u), w])
        self.origin = origin if self.pinhole else np.zeros(3)
        seen = self.project(points)
        self.pixel = pixel / seen[:, 2].mean() if self.pinhole else pixel
        low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
        if beyond is not None:
            low, high = 2 * low - high, 2 * high - low
        self.low = low - 3 * self.pixel
        self.shape = ((high - self.low) / self.pixel).astype(int) + 4
        self.depth = np.full(self.shape, np.inf)
        np.minimum.at(self.depth, tuple(self.pixels(seen).T), seen[:, 2])

        self.past = np.full(self.shape, np.inf)
        if beyond is not None:
            self.look_beyond(self.project(beyond))

    def look_beyond(self, rays):
        inside = ((self.pixels(rays) >= 0) & (self.pixels(rays) < self.shape)).all(axis=1)
        rays = rays[inside]
        apart = np.sqrt(np.prod(self.shape) / max(len(rays), 1))
        reach = min(int(apart / 2 + 0.5), 4)
        for (i, j), depth in zip(self.pixels(rays), rays[:, 2], strict=True):
            window = np.s_[max(i - reach, 0):i + reach + 1, max(j - reach, 0):j + reach + 1]
            self.past[window] = np.minimum(self.past[window], depth)

    def project(self, points):
        local = (points - self.origin) @ self.axes.T
        if self.pinhole:
            local = np.column_stack([local[:, :2] / local[:, 2:], local[:, 2]])
        return local

    def pixels(self, seen):
        return np.floor((seen[:, :2] - self.low) / self.pixel).astype(int)

    def look(self, points, normals, tolerance, facing):
        seen, rays = self.project(points), (points - self.origin) @ self.axes.T
        words = []
        for (i, j), (_, _, z), ray, normal in zip(
                self.pixels(seen), seen, rays, normals @ self.axes.T, strict=True):
            inside = 0 <= i < self.shape[0] and 0 <= j < self.shape[1]
            around = [
                self.depth[max(i - k, 0):i + k + 1, max(j - k, 0):j + k + 1].min()
                if inside else np.inf for k in (1, 2)]
            towards = -normal @ _unit(ray) if self.pinhole else -normal[2]
            if self.pinhole and z <= 0:
                words.append(NONE)
            elif np.isfinite(around[0]):
                words.append(IN_FRONT if z < around[0] - tolerance else SEEN)
            elif inside and np.isfinite(self.past[i, j]):
                words.append(IN_FRONT if z < self.past[i, j] - tolerance else SEEN)
            elif np.isfinite(around[1]):
                words.append(NONE)
            else:
                words.append(EMPTY if towards > facing else NONE)
        return np.array(words)


def score(source, target, pose, samples, tau, front, facing=0.5):
    """Return (2, 4): overlap, front, empty, disagree per sample, both ways."""
    pose = centred(pose, source, target)
    return np.array([
        _score_one_way(source, target, pose, samples, tau, front, facing),
        _score_one_way(target, source, np.linalg.inv(pose), samples, tau, front, facing)])


def _score_one_way(start, end, pose, samples, tau, front, facing):
    chosen = start.samples[:samples]
    points, normals = placed(pose, start.means[chosen]), start.normals[chosen] @ pose[:3, :3].T
    near = end.closest(points)
    distance = np.linalg.norm(points - end.means[near], axis=1)
    closeness = np.maximum(0.0, 1 - (distance / tau) ** 2) ** 2
    agree = np.einsum('na,na->n', normals, end.normals[near])
    words = np.zeros(len(chosen))
    if end.raster is not None:
        words = end.raster.look(points, normals, front, facing)
    return np.array([
        (closeness * np.maximum(agree, 0)).mean(), (words == IN_FRONT).mean(),
        (words == EMPTY).mean(), (closeness * (agree < 0.5)).mean()])


def refine(source, target, pose, radii, samples, agree):
    """Return the pose after one damped point-to-plane step a radius, matches both ways."""
    pose = centred(pose, source, target)
    for radius in radii:
        rows, gaps, weights = [], [], []
        chosen, inverse = source.samples[:samples], np.linalg.inv(pose)
        x = placed(pose, source.means[chosen])
        c = target.closest(x)
        _collect(rows, gaps, weights, x, target.means[c], target.normals[c],
                 source.normals[chosen] @ pose[:3, :3].T, ~target.border[c], x, radius, agree)
        chosen = target.samples[:samples]
        x = target.means[chosen]
        c = source.closest(placed(inverse, x))
        y, n = placed(pose, source.means[c]), source.normals[c] @ pose[:3, :3].T
        _collect(rows, gaps, weights, y, x, n, target.normals[chosen], ~source.border[c], y,
                 radius, agree)
        pose = advanced(pose, *(np.concatenate(a) for a in (rows, gaps, weights)), 1e-4)
    return centred(pose, source, target, -1)


def _collect(rows, gaps, weights, moved, other, plane, facing, inner, at, radius, agree):
    gap = moved - other
    squared = (gap ** 2).sum(axis=1)
    keep = inner & (squared <= radius ** 2) & (np.einsum('na,na->n', plane, facing) >= agree)
    rows.append(np.concatenate([np.cross(at, plane), plane], axis=1)[keep])
    gaps.append(np.einsum('na,na->n', gap, plane)[keep])
    weights.append((1 - squared / radius ** 2)[keep])


def advanced(pose, rows, gaps, weights, damping):
    """Return the pose after the step that solves the weighted, damped normal equations."""
    a = (rows * weights[:, None]).T @ rows
    step = np.linalg.solve(a + damping * np.diag(np.diag(a)), -rows.T @ (weights * gaps))
    result = pose.copy()
    turn = Rotation.from_rotvec(step[:3])
    result[:3] = turn.as_matrix() @ pose[:3]
    result[:3, 3] += step[3:]
    return result


def examined(source, target, pose, samples, radius, front, facing=0.5):
    """Return numbers (2, 6) and hessian (6, 6) of `examine` without rounds."""
    pose = centred(pose, source, target)
    numbers, hessian = [], np.zeros((6, 6))
    for start, end, go in ((source, target, pose), (target, source, np.linalg.inv(pose))):
        chosen = np.arange(0, len(start.vertices), max(1, len(start.vertices) // samples))
        p, n = placed(go, start.vertices[chosen]), start.vertex_normals[chosen] @ go[:3, :3].T
        c = end.closest_vertex(p)
        far = (c < 0) | (np.linalg.norm(p - end.vertices[c], axis=1) > radius)
        words = end.raster.look(p[far], n[far], front, facing)
        against = ~far & (np.einsum('na,na->n', n, end.vertex_normals[c]) < 0.5)
        used = ~far & ~against & ~end.rim[c]
        q, m = end.vertices[c][used], end.vertex_normals[c][used]
        gap = np.einsum('na,na->n', p[used] - q, m)
        at, plane = (p[used], m) if start is source else (placed(pose, q), m @ pose[:3, :3].T)
        rows = np.concatenate([np.cross(at, plane), plane], axis=1)
        hessian += rows.T @ rows
        numbers.append([
            len(chosen), used.sum(), np.abs(gap).sum(), (words == IN_FRONT).sum(),
            (words == EMPTY).sum(), against.sum()])
    return np.array(numbers), hessian


def centred(pose, source, target, way=1):
    """Express `T_target_source` between frames at the two centres (`way` -1: the reverse)."""
    result = pose.copy()
    result[:3, 3] += way * (pose[:3, :3] @ source.centre - target.centre)
    return result


def placed(pose, points):
    return points @ pose[:3, :3].T + pose[:3, 3]


def _distances(a, b):
    return np.linalg.norm(a[:, None] - b[None], axis=2)


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _shuffled(count):
    order, state = np.arange(count), 0x9E3779B97F4A7C15
    for k in range(count, 1, -1):
        state = (state * 6364136223846793005 + 1442695040888963407) % 2 ** 64
        other = (state >> 33) % k
        order[k - 1], order[other] = order[other], order[k - 1]
    return order
