# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Objects to be captured in any number: no two alike, none symmetric, all of one size."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from ros_rops.recordings.procedural import assembly, mesh_of
from ros_rops.recordings.raycast import Camera
from ros_rops.recordings.synthetic import Capture, hand_held_poses, Model, render_view

# One size, so that it does not tell objects apart: that of the procedural ones.
RADIUS_M = 0.08
# Cells of the procedural meshes.
CELL_M = 0.002
# Views of an object lie as if there were at least so many around it: of four spread all around,
# hardly two overlap.
LEAST_AROUND = 16


def distinct_models(given: Sequence[Model], count: int) -> list[Model]:
    """
    Return `count` models: those given, then assemblies of different seeds.

    Parameters
    ----------
    given : sequence of Model
        Meshes of the caller, scaled here.
    count : int
    """
    models = list(given[:count])
    for number in range(count - len(models)):
        models.append(Model(*mesh_of(assembly(number), CELL_M), name=f'assembly{number}'))
    return [_scaled(model) for model in models]


def _scaled(model: Model) -> Model:
    vertices = (model.vertices - model.middle) * (RADIUS_M / model.radius)
    return replace(model, vertices=vertices, units='m')


def captures_of(model: Model, count: int, *, pixels: int, seed: int) -> list[Capture]:
    """
    Capture a model by a hand-held pinhole without noise, `count` neighbouring views.

    Parameters
    ----------
    model : Model
    count : int
        LEAST_AROUND and more go all around.
    pixels : int
        Side of the square image.
    seed : int
        Of the poses.

    Returns
    -------
    list of Capture
        Named '<model>/<number>', their world the model's frame.
    """
    rng = np.random.default_rng(seed)
    poses = hand_held_poses(model.middle, model.radius, max(count, LEAST_AROUND), rng)
    eyes = np.array([pose[:3, 3] for pose in poses]) - model.middle
    towards = eyes @ eyes[rng.integers(len(eyes))] / np.linalg.norm(eyes, axis=1)
    chosen = np.sort(np.argsort(-towards, kind='stable')[:count])
    focal = 1.05 * pixels  # the object spans 0.7 of the image from three radii
    middle = (pixels - 1) / 2
    camera = Camera(pixels, pixels, focal, focal, middle, middle)
    return [
        render_view(model, poses[k], camera, name=f'{model.name}/{number:03d}')
        for number, k in enumerate(chosen)]
