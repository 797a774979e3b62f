# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
An object's views assembled to one cloud.

Where views overlap their points are duplicates, some tenths of a mesh resolution apart: noise, and
what is left of the poses' errors. Each point moves along its normal to where all points around it
agree that the surface is, weighted by how far each may be trusted; of those then at the same place
one stays.
"""

from collections.abc import Sequence

import numpy as np
from ros_rops.core.config import ModelConfig
from ros_rops.kernels.consensus import agree, Agreed, heaviest, Reach, Samples, spread
from ros_rops.modelling.gathering import noise_of, samples_of
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.products import ModelCloud

LEAST_RADIUS_MR = 1.5
"""Views of 1 mr have some nine points within it: enough for a height and a slope."""
NOISE_RADII = 1.5
"""The neighbourhood is wider by so many standard deviations of the noise."""
MOST_RADIUS_MR = 3.0
DEPTH_RADII = 1.5
"""Poses are wrong across the surface, too."""
NEAR_MR = 1.0
"""A view without a point so near did not see the place."""


def assemble_cloud(
    views: Sequence[PosedView], config: ModelConfig, *, resolution: float, threads: int = 0
) -> ModelCloud:
    """
    Assemble the views of an object.

    Parameters
    ----------
    views : sequence of PosedView
    config : ModelConfig
    resolution : float
        dres, in the views' units.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    ModelCloud
        Empty if no view has a surface.
    """
    samples = samples_of(views)
    reach = _reach(views, config, resolution)
    spacing = config.cloud_mr * resolution
    targets = np.arange(len(samples.points), dtype=np.int32)
    if spacing > 0 and len(targets):
        targets = heaviest(samples.points, samples.normals, samples.weights, spacing)
    agreed = agree(samples, targets, reach, threads=threads)
    if spacing > 0:
        order = np.argsort(-agreed.weights, kind='stable').astype(np.int32)
        agreed = _taken(agreed, spread(agreed.points, agreed.normals, order, spacing))
    return _cloud(views, samples, agreed)


def _reach(views: Sequence[PosedView], config: ModelConfig, resolution: float) -> Reach:
    noise = float(np.median([noise_of(view) for view in views])) if views else 0.0
    radius = min(
        LEAST_RADIUS_MR * resolution + NOISE_RADII * noise, MOST_RADIUS_MR * resolution)
    return Reach(
        radius, DEPTH_RADII * radius, NEAR_MR * resolution,
        max(config.cloud_mr, NEAR_MR) * resolution)


def _taken(agreed: Agreed, pick: np.ndarray) -> Agreed:
    return Agreed(*(column[pick] for column in agreed))


def _cloud(views: Sequence[PosedView], samples: Samples, agreed: Agreed) -> ModelCloud:
    numbers = np.array([view.number for view in views], np.int32)
    return ModelCloud(
        agreed.points, agreed.normals, agreed.colors if len(samples.colors) else None,
        agreed.weights, numbers[agreed.views] if len(numbers) else agreed.views,
        np.minimum(agreed.directions, 255).astype(np.uint8), {
            'points_measured': sum(len(view.view.points) for view in views),
            'points': len(agreed.points)})
