# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Rendered views in their exact places, and how to put one wrong."""

from dataclasses import replace
from functools import cache

import numpy as np
from reference.captures import model
from ros_rops.core.config import Config
from ros_rops.modelling.posed import pose_views, resolution_of
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.synthetic import look_at, render_view, synthetic_views
from scipy.spatial.transform import Rotation


def posed(captures):
    """Return captures as posed views."""
    names = [one.view.name for one in captures]
    return pose_views(
        [(one.view.name, one.T_world_view) for one in captures],
        {one.view.name: one.view for one in captures},
        {name: k for k, name in enumerate(names)}, Config())


@cache
def around(name, count=9, pixels=150, noise_mr=0.3):
    """Return views of an object from all around."""
    return posed(synthetic_views(
        model(name), count=count, seed=1, pixels=pixels, noise_mr=noise_mr))


def capture_from(thing, direction, name, pixels=110, noise_mr=0.2):
    """Capture a model from a direction, three radii away."""
    focal, middle = 1.05 * pixels, (pixels - 1) / 2
    camera = Camera(pixels, pixels, focal, focal, middle, middle)
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    pose = look_at(thing.middle + 3 * thing.radius * direction, thing.middle)
    return render_view(
        thing, pose, camera, noise_mr=noise_mr, rng=np.random.default_rng(3), name=name)


def turntable(name, angles_deg, height=0.35):
    """Return posed views, the object turned by angles about z before a sensor at rest."""
    thing = model(name)
    side = np.sqrt(1 - height ** 2)
    captures = []
    for k, angle in enumerate(np.radians(angles_deg)):
        # To turn the object by an angle is to carry the sensor round the other way.
        eye = thing.middle + 3 * thing.radius * np.array(
            [side * np.cos(-angle), side * np.sin(-angle), height])
        captures.append(_upright(thing, eye, f'{name}_{k}'))
    return posed(captures)


def _upright(thing, eye, name, pixels=110):
    """Capture with the camera upright, so that the axis stands still before it."""
    z = (thing.middle - eye) / np.linalg.norm(thing.middle - eye)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.stack([x, np.cross(z, x), z], axis=1), eye
    focal, middle = 1.05 * pixels, (pixels - 1) / 2
    camera = Camera(pixels, pixels, focal, focal, middle, middle)
    return render_view(
        thing, pose, camera, noise_mr=0.2, rng=np.random.default_rng(3), name=name)


def wronged(views, k, *, degrees=0.0, shift_mr=0.0, seed=0):
    """Turn view k about its middle and shift it, in directions by chance."""
    rng = np.random.default_rng(seed)
    axis, way = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    middle = views[k].points.mean(axis=0)
    turn = Rotation.from_rotvec(np.radians(degrees) * axis).as_matrix()
    motion = np.eye(4)
    motion[:3, :3] = turn
    motion[:3, 3] = middle - turn @ middle + way * shift_mr * resolution_of(views)
    result = list(views)
    result[k] = replace(views[k], T_object_view=motion @ views[k].T_object_view)
    return tuple(result)
