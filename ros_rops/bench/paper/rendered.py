# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Views rendered around a mesh, as the paper's synthetic data (V-A6): their poses are exact."""

import numpy as np
from ros_rops.bench.resolution import mesh_resolution
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.errors import ParameterError
from ros_rops.core.se3 import rigid
from ros_rops.core.types import Floats
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.synthetic import Capture, look_at, Model, render_view

VIEWS = 24
STEP_DEG = 15.0
# The camera looks down a little, as on a turntable; the paper states azimuths alone.
ELEVATION_DEG = 15.0
DISTANCE_RADII = 3.0
# The sphere that holds the model spans 0.7 of the image then; views have about 20,000 points.
FOCAL_PIXELS = 1.05
PIXELS = 400


def turntable_poses(middle: Floats, radius: float, views: int, step_deg: float) -> list[Floats]:
    """
    Return poses `T_world_view` around the y axis, the first from +z, all looking at `middle`.

    Parameters
    ----------
    middle : (3,) float64
    radius : float
        Of the sphere about `middle` that holds the model.
    views : int
    step_deg : float
        Azimuth between neighbours.
    """
    up = np.deg2rad(ELEVATION_DEG)
    direction = np.array([0.0, np.sin(up), np.cos(up)])
    first = look_at(middle + DISTANCE_RADII * radius * direction, middle)
    poses = []
    for azimuth in np.deg2rad(step_deg) * np.arange(views):
        c, s = np.cos(azimuth), np.sin(azimuth)
        turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        poses.append(rigid(turn, middle - turn @ middle) @ first)
    return poses


def rendered_set(
    model: Model,
    *,
    views: int = VIEWS,
    step_deg: float = STEP_DEG,
    noise_mr: float = 0.0,
    seed: int = 0,
    pixels: int = PIXELS,
) -> ReferenceSet:
    """
    Render a model from all around.

    Parameters
    ----------
    model : Model
        Its y axis is that of the turntable.
    views : int
    step_deg : float
        Azimuth between neighbours.
    noise_mr : float
        Standard deviation of a gaussian error along the ray, in mesh resolutions of the view.
    seed : int
        Of the noise; poses do not depend on it.
    pixels : int
        Side of the square image.

    Returns
    -------
    ReferenceSet
        Named '<model>_<views>', organized views '<model>_<azimuth>'; dres is that of the views
        without noise, which lengthens edges and would flatter the errors.

    Raises
    ------
    ParameterError
        If `views` is below 2 or `pixels` below 16, or the noise is negative.
    ViewError
        If nothing of the model is seen.
    """
    if views < 2 or pixels < 16 or not 0 <= noise_mr < 100:
        raise ParameterError(
            f'views, pixels, noise_mr: expected at least 2, 16, 0, got {views}, {pixels}, '
            f'{noise_mr}')
    poses = turntable_poses(model.middle, model.radius, views, step_deg)
    clean = _captures(model, poses, step_deg, pixels, 0.0, seed)
    captures = _captures(model, poses, step_deg, pixels, noise_mr, seed) if noise_mr else clean
    return ReferenceSet(
        name=f'{model.name}_{views}', units=model.units, reference_kind='exact',
        views={one.view.name: one.view for one in captures},
        T_world_view={one.view.name: one.T_world_view for one in captures},
        dres=float(np.mean([mesh_resolution(one.view) for one in clean])))


def _captures(
    model: Model, poses: list[Floats], step_deg: float, pixels: int, noise_mr: float, seed: int
) -> list[Capture]:
    focal = FOCAL_PIXELS * pixels
    camera = Camera(pixels, pixels, focal, focal, (pixels - 1) / 2, (pixels - 1) / 2)
    rng = np.random.default_rng(seed)
    return [
        render_view(
            model, T, camera, noise_mr=noise_mr, rng=rng,
            name=f'{model.name}_{k * step_deg:g}')
        for k, T in enumerate(poses)]
