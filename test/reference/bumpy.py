# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Views of analytic surfaces with exact poses: what fine registration is tried on."""

import numpy as np
from ros_rops.core.fine import FineView
from scipy.spatial.transform import Rotation

SIZE = 30.0


def radius_of(directions, bumps):
    """Return the radius (N,) of a bumpy ball seen along unit `directions` (N, 3)."""
    x, y, z = directions.T
    return SIZE * (1 + bumps * (
        np.sin(3 * x + 1) * np.cos(4 * y) + 0.6 * np.sin(5 * z + 2 * x) + 0.5 * x * y))


def surface(directions, bumps):
    """Return points and outward unit normals; the normals by the gradient of f = |p| - r."""
    points = directions * radius_of(directions, bumps)[:, None]
    step = 1e-4
    gradient = np.zeros_like(points)
    for axis in range(3):
        value = []
        for sign in (1, -1):
            moved = points + sign * step * np.eye(3)[axis]
            length = np.linalg.norm(moved, axis=1)
            value.append(length - radius_of(moved / length[:, None], bumps))
        gradient[:, axis] = (value[0] - value[1]) / (2 * step)
    return points, gradient / np.linalg.norm(gradient, axis=1, keepdims=True)


def lattice(count, rotation):
    """Return `count` directions spread evenly over the sphere, turned by `rotation`."""
    k = np.arange(count) + 0.5
    z, angle = 1 - 2 * k / count, k * np.pi * (1 + 5 ** 0.5)
    side = np.sqrt(1 - z ** 2)
    return rotation.apply(np.stack([side * np.cos(angle), side * np.sin(angle), z], axis=1))


def rigid(rotation, translation):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation.as_matrix(), translation
    return pose


def views_of(looks, *, bumps=0.12, noise=0.0, count=12000, seed=0):
    """
    Return views (each in a frame of its own), exact poses and mesh resolution.

    Parameters
    ----------
    looks : (V, 3)
        Directions from the object to the sensor. Every view samples the surface at other
        places.
    noise : float
        Standard deviation in mesh resolutions, every coordinate.
    """
    rng = np.random.default_rng(seed)
    resolution = 1.1 * np.sqrt(4 * np.pi * SIZE ** 2 / count)
    views, poses = [], []
    for look in np.asarray(looks, dtype=float):
        look = look / np.linalg.norm(look)
        points, normals = surface(lattice(count, Rotation.random(rng=rng)), bumps)
        facing = normals @ look
        points, normals, facing = (a[facing > 0.3] for a in (points, normals, facing))
        points = points + noise * resolution * rng.normal(size=points.shape)
        pose = rigid(Rotation.random(rng=rng), rng.normal(size=3) * 100)
        views.append(FineView(
            (points - pose[:3, 3]) @ pose[:3, :3], normals @ pose[:3, :3], facing < 0.38))
        poses.append(pose)
    return views, poses, resolution


def disturbed(views, poses, resolution, *, degrees=1.5, shift_mr=1.5, seed=1):
    """Turn every pose but the first about its view's middle, and shift it."""
    rng = np.random.default_rng(seed)
    result = [poses[0]]
    for view, pose in zip(views[1:], poses[1:], strict=True):
        middle = pose[:3, :3] @ view.points.mean(axis=0) + pose[:3, 3]
        axis, way = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        turn = Rotation.from_rotvec(np.radians(degrees) * axis)
        move = rigid(turn, middle - turn.apply(middle) + way * shift_mr * resolution)
        result.append(move @ pose)
    return result


def errors(views, poses, truth, resolution):
    """Return (V,) rotation errors in degrees and (V,) shifts of the middle in resolutions."""
    turns = np.degrees([
        Rotation.from_matrix(a[:3, :3] @ b[:3, :3].T).magnitude()
        for a, b in zip(poses, truth, strict=True)])
    shifts = [
        np.linalg.norm((a - b)[:3, :3] @ v.points.mean(axis=0) + (a - b)[:3, 3]) / resolution
        for v, a, b in zip(views, poses, truth, strict=True)]
    return turns, np.array(shifts)
