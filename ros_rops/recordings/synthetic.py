# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Synthetic captures of a mesh, their poses known exactly."""

from dataclasses import dataclass

import numpy as np

from ros_rops.core.errors import ParameterError
from ros_rops.core.types import Bytes, Floats, Ints, RangeView, SensorModel, Units
from ros_rops.recordings.cloud import Cloud, drop_holes, full_grid
from ros_rops.recordings.depth_noise import cosines, DepthNoise, disturb
from ros_rops.recordings.raycast import Camera, cast

GOLDEN = np.pi * (3.0 - np.sqrt(5.0))


@dataclass(frozen=True, slots=True)
class Capture:
    """A rendered view and the exact pose of its camera, `T_world_view` (4, 4)."""

    view: RangeView
    T_world_view: Floats
    object_name: str = ''


@dataclass(frozen=True, slots=True)
class Model:
    """A mesh to be captured: vertices (N, 3), faces (F, 3), colours (N, 3) or None."""

    vertices: Floats
    faces: Ints
    colors: Bytes | None = None
    name: str = ''
    units: Units = 'm'

    @property
    def middle(self) -> Floats:
        """Middle of the bounding box, (3,)."""
        middle: Floats = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
        return middle

    @property
    def radius(self) -> float:
        """Radius of the sphere about the middle that holds all vertices."""
        return float(np.linalg.norm(self.vertices - self.middle, axis=1).max())


def render_view(
    model: Model,
    T_world_view: Floats,
    camera: Camera,
    *,
    noise: DepthNoise | None = None,
    noise_mr: float = 0.0,
    rng: np.random.Generator | None = None,
    name: str = 'view',
) -> Capture:
    """
    Capture a model, organized, the sensor a pinhole at the origin looking along +z.

    Parameters
    ----------
    model : Model
        In the world's frame.
    T_world_view : (4, 4) float64
        Pose of the camera.
    camera : Camera
    noise : DepthNoise or None
        Errors of a depth camera; None for exact depths.
    noise_mr : float
        Standard deviation of a gaussian error along the ray, in mesh resolutions of this view.
    rng : Generator or None
        Source of the errors; needed if there are any.

    Raises
    ------
    ParameterError
        If errors are asked for without `rng`.
    """
    if rng is None and (noise is not None or noise_mr):
        raise ParameterError('rng: needed for noise, got None')
    T_view_world = np.linalg.inv(T_world_view)
    local = model.vertices @ T_view_world[:3, :3].T + T_view_world[:3, 3]
    depth, face = cast(local, model.faces, camera)
    rays = camera.rays()
    if noise is not None and rng is not None:
        depth = disturb(depth, cosines(face, local, model.faces, rays), noise, rng)
    if noise_mr and rng is not None:
        sigma = noise_mr * resolution_of(depth[..., None] * rays)
        along = rng.normal(0.0, sigma, depth.shape)
        depth = depth + along / np.linalg.norm(rays, axis=-1)
    colors = None if model.colors is None else model.colors[model.faces[face, 0]]
    cloud = drop_holes(Cloud(
        (depth[..., None] * rays).reshape(-1, 3), full_grid(*depth.shape),
        None if colors is None else colors.reshape(-1, 3)))
    view = RangeView(
        name, cloud.points, cloud.grid, SensorModel('pinhole'), cloud.colors, model.units)
    return Capture(view, T_world_view, model.name)


def resolution_of(organized: Floats) -> float:
    """
    Return the mesh resolution of organized points (H, W, 3): the mean edge of their mesh.

    Edges run to the right, down and along one diagonal; steps in depth (edges of more than four
    times the median) do not count. Zero if there is no edge.
    """
    pairs = (
        (organized[:, :-1], organized[:, 1:]),
        (organized[:-1], organized[1:]),
        (organized[:-1, 1:], organized[1:, :-1]),
    )
    lengths = np.concatenate([np.linalg.norm(a - b, axis=-1).ravel() for a, b in pairs])
    lengths = lengths[np.isfinite(lengths)]
    if not len(lengths):
        return 0.0
    return float(lengths[lengths < 4 * np.median(lengths)].mean())


def directions_around(count: int, rng: np.random.Generator, jitter_deg: float = 10.0) -> Floats:
    """Return `count` unit vectors spread over the sphere, each moved at random, (count, 3)."""
    k = np.arange(count)
    z = 1.0 - (2.0 * k + 1.0) / count
    around = np.sqrt(1.0 - z * z)
    even = np.stack([around * np.cos(GOLDEN * k), around * np.sin(GOLDEN * k), z], axis=1)
    moved = even + rng.normal(0.0, np.deg2rad(jitter_deg), even.shape)
    unit: Floats = moved / np.linalg.norm(moved, axis=1, keepdims=True)
    return unit


def look_at(eye: Floats, target: Floats, roll: float = 0.0) -> Floats:
    """Return `T_world_view` of a camera at `eye` that looks at `target`, rolled (radians)."""
    z = (target - eye) / np.linalg.norm(target - eye)
    up = np.eye(3)[np.argmin(np.abs(z))]
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    c, s = np.cos(roll), np.sin(roll)
    T = np.eye(4)
    T[:3, :3] = np.stack([c * x + s * y, c * y - s * x, z], axis=1)
    T[:3, 3] = eye
    return T


def synthetic_views(
    model: Model,
    *,
    count: int = 12,
    seed: int = 0,
    pixels: int = 200,
    noise_mr: float = 0.0,
    noise: DepthNoise | None = None,
) -> list[Capture]:
    """
    Capture a model from all around, held by hand: distance, aim and roll vary.

    Parameters
    ----------
    model : Model
    count : int
        Number of views.
    seed : int
        Of poses and errors; the poses do not depend on the errors.
    pixels : int
        Side of the square image; the model fills about two thirds of it.
    noise_mr, noise
        As for `render_view`.

    Returns
    -------
    list of Capture
        Named '<model>_<number>', their world the model's frame.

    Raises
    ------
    ParameterError
        If `count` or `pixels` is below 1.
    """
    if count < 1 or pixels < 1:
        raise ParameterError(f'count, pixels: must be at least 1, got {count}, {pixels}')
    focal = 1.05 * pixels  # the sphere around the model spans 0.7 of the image from 3 radii
    camera = Camera(pixels, pixels, focal, focal, (pixels - 1) / 2, (pixels - 1) / 2)
    poses = hand_held_poses(
        model.middle, model.radius, count, np.random.default_rng([seed, 0]))
    rng = np.random.default_rng([seed, 1])
    return [
        render_view(model, T, camera, noise=noise, noise_mr=noise_mr, rng=rng,
                    name=f'{model.name or "view"}_{k:03d}')
        for k, T in enumerate(poses)
    ]


def hand_held_poses(
    middle: Floats, radius: float, count: int, rng: np.random.Generator
) -> list[Floats]:
    """Return poses `T_world_view` around a sphere, 2.8 to 3.4 radii away, rolled at random."""
    poses = []
    for direction in directions_around(count, rng):
        eye = middle + direction * radius * rng.uniform(2.8, 3.4)
        target = middle + rng.normal(0.0, 0.05 * radius, 3)
        poses.append(look_at(eye, target, rng.uniform(-np.pi, np.pi)))
    return poses
