# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Depth frames of analytic scenes: a round table, boxes, balls and upright cylinders on it, a wall.

Every ray is intersected with every body in closed form, so what each pixel shows is known.
"""

from dataclasses import dataclass

import numpy as np
from ros_rops.core.frame import Frame
from ros_rops.core.types import SensorModel
from ros_rops.recordings.synthetic import look_at

NOTHING, TABLE, WALL, FIRST_BODY = -1, 0, 1, 2
TABLE_RADIUS = 0.25


@dataclass(frozen=True)
class Box:
    low: tuple
    high: tuple

    def hit(self, eye, rays):
        with np.errstate(divide='ignore', invalid='ignore'):
            a, b = (np.asarray(self.low) - eye) / rays, (np.asarray(self.high) - eye) / rays
        near, far = np.minimum(a, b).max(axis=-1), np.maximum(a, b).min(axis=-1)
        return np.where((near <= far) & (near > 0), near, np.inf)


@dataclass(frozen=True)
class Ball:
    middle: tuple
    radius: float

    def hit(self, eye, rays):
        off = eye - np.asarray(self.middle)
        a, b = (rays**2).sum(axis=-1), rays @ off
        inside = b**2 - a * (off @ off - self.radius**2)
        near = (-b - np.sqrt(np.maximum(inside, 0))) / a
        return np.where((inside > 0) & (near > 0), near, np.inf)


@dataclass(frozen=True)
class Post:
    """Upright cylinder from the table to `height`."""

    x: float
    y: float
    radius: float
    height: float

    def hit(self, eye, rays):
        off = eye[:2] - np.array([self.x, self.y])
        a, b = (rays[..., :2]**2).sum(axis=-1), rays[..., :2] @ off
        inside = b**2 - a * (off @ off - self.radius**2)
        side = (-b - np.sqrt(np.maximum(inside, 0))) / np.maximum(a, 1e-12)
        height = eye[2] + side * rays[..., 2]
        side = np.where((inside > 0) & (height >= 0) & (height <= self.height), side, np.inf)
        top = (self.height - eye[2]) / rays[..., 2]
        place = off + top[..., None] * rays[..., :2]
        top = np.where((place**2).sum(axis=-1) <= self.radius**2, top, np.inf)
        return np.minimum(side, top)


@dataclass(frozen=True)
class Shot:
    """
    A frame and its truth.

    `body` (H, W): what each pixel shows; `height` (H, W): of its true point over the table;
    `T_sensor_world`; `exact` (H, W): the true depth.
    """

    frame: Frame
    body: np.ndarray
    height: np.ndarray
    exact: np.ndarray
    T_sensor_world: np.ndarray

    def plane_error(self, plane):
        """Return the angle (degrees) and height (m, at the world's origin) of a found plane."""
        truth = self.T_sensor_world[:3, 2]
        angle = np.degrees(np.arccos(np.clip(truth @ np.asarray(plane.normal), -1, 1)))
        return angle, abs(self.T_sensor_world[:3, 3] @ np.asarray(plane.normal) - plane.offset)


def shoot(
    bodies, *, size=(320, 240), eye=(0.0, -0.42, 0.34), target=(0.0, 0.0, 0.02), wall=None,
    table=TABLE_RADIUS, noise=0.0, step=0.0, flying=0.0, lost=0.0, seed=0, name='frame',
    units='m', kind=np.float32,
):
    """
    Render a scene; the table is z = 0, the wall y = `wall`.

    `noise`: standard deviation of the depth at 1 m, growing with its square; `step`: of the depth;
    `flying`: share of the pixels at a jump that hang between; `lost`: share of holes.
    """
    random = np.random.default_rng(seed)
    width, height = size
    focal = 0.96 * width
    v, u = np.mgrid[:height, :width]
    rays = np.stack(
        [(u - (width - 1) / 2) / focal, (v - (height - 1) / 2) / focal, np.ones(u.shape)], -1)
    pose = look_at(np.asarray(eye), np.asarray(target))
    turned, eye = rays @ pose[:3, :3].T, np.asarray(eye, float)
    depths = [_table(eye, turned, table), _wall(eye, turned, wall)]
    depths += [body.hit(eye, turned) for body in bodies]
    exact = np.min(depths, axis=0)
    body = np.where(np.isfinite(exact), np.argmin(depths, axis=0), NOTHING)
    depth = exact.copy()
    if flying:
        jump = np.zeros(depth.shape, bool)
        jump[:, 1:] = np.abs(np.diff(np.where(np.isfinite(exact), exact, 9.0), axis=1)) > 0.02
        hang = jump & (random.random(depth.shape) < flying) & np.isfinite(exact)
        left = np.roll(exact, 1, axis=1)
        hang &= np.isfinite(left)
        depth = np.where(hang, (exact + left) / 2, depth)
        body = np.where(hang, NOTHING, body)
    depth = np.where(np.isfinite(depth), depth, np.nan)
    depth = depth + noise * depth**2 * random.normal(size=depth.shape)
    if step:
        depth = np.rint(depth / step) * step
    depth[~np.isfinite(exact) | (random.random(depth.shape) < lost)] = np.nan
    body = np.where(np.isfinite(depth), body, NOTHING)
    points = (depth[..., None] * rays * (1000 if units == 'mm' else 1)).astype(kind)
    world = eye + np.where(np.isfinite(exact), exact, 0)[..., None] * turned
    frame = Frame(
        name, points, sensor=SensorModel('pinhole'), units=units, frame_id='camera')
    return Shot(frame, body, world[..., 2], exact, np.linalg.inv(pose))


def _table(eye, rays, radius):
    depth = -eye[2] / np.where(rays[..., 2] < 0, rays[..., 2], np.nan)
    place = eye[:2] + depth[..., None] * rays[..., :2]
    return np.where((place**2).sum(axis=-1) <= radius**2, depth, np.inf)


def _wall(eye, rays, place):
    if place is None:
        return np.full(rays.shape[:2], np.inf)
    depth = (place - eye[1]) / np.where(rays[..., 1] > 0, rays[..., 1], np.nan)
    return np.where(depth > 0, depth, np.inf)


def scores(kept, truth):
    """Return precision and recall of a mask."""
    both = np.count_nonzero(kept & truth)
    return both / max(1, np.count_nonzero(kept)), both / max(1, np.count_nonzero(truth))
