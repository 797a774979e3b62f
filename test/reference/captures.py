# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Small synthetic views of procedural objects, their poses known exactly."""

from functools import cache

import numpy as np
from ros_rops.recordings.procedural import blob, bracket, mesh_of
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.synthetic import look_at, Model, render_view

FIELDS = {'blob': blob, 'bracket': bracket}
PIXELS = 130


@cache
def model(name):
    vertices, faces = mesh_of(FIELDS[name](), cell=0.003)
    return Model(vertices, faces, name=name)


def neighbours(name, degrees=35.0):
    """Return two captures of an object, the camera moved by an angle around it."""
    return _around(model(name), 0.6, degrees)


@cache
def arc(name, count=4, degrees=35.0):
    """Return captures of an object, the camera moved around it step by step."""
    return tuple(_around(model(name), 0.6, degrees, count=count))


def of_field(field, degrees=15.0, radius=0.07):
    """Return two captures of any body within `radius`, seen mostly from above."""
    vertices, faces = mesh_of(field, cell=0.003)
    return _around(Model(vertices, faces, name='body'), 0.95, degrees, radius)


def _around(thing, height, degrees, radius=None, count=2):
    focal, middle = 1.05 * PIXELS, (PIXELS - 1) / 2
    camera = Camera(PIXELS, PIXELS, focal, focal, middle, middle)
    random, distance = np.random.default_rng(5), 3 * (radius or thing.radius)
    result = []
    for k, angle in enumerate(np.radians(degrees) * np.arange(count)):
        side = np.sqrt(1 - height ** 2)
        eye = thing.middle + distance * np.array(
            [np.cos(angle) * side, np.sin(angle) * side, height])
        pose = look_at(eye, thing.middle, roll=0.7 * k)
        result.append(render_view(
            thing, pose, camera, noise_mr=0.1, rng=random, name=f'{thing.name}_{k}'))
    return result


def error(found, first, second):
    """Return rotation (degrees) and shift (units) of a pose of `second` in `first`'s frame."""
    truth = np.linalg.inv(first.T_world_view) @ second.T_world_view
    middle = second.view.points.mean(axis=0)
    turn = (np.trace(found[:3, :3].T @ truth[:3, :3]) - 1) / 2
    shift = np.linalg.norm((found - truth)[:3] @ [*middle, 1])
    return np.degrees(np.arccos(np.clip(turn, -1, 1))), shift
