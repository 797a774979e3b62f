# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
An object's views assembled to one cloud.

Where views overlap their points are duplicates, some tenths of a mesh resolution apart: noise, and
what is left of the poses' errors. Each point moves along its normal to where all points around it
agree that the surface is, weighted by how far each may be trusted; of those then at the same place
one stays. Points that other views saw through are left out; whole views that stand wrong are the
caller's to leave out (`standing`).
"""

from collections.abc import Mapping, Sequence

import numpy as np
from ros_rops.core.config import ModelConfig
from ros_rops.core.types import Bools, Ints
from ros_rops.kernels.consensus import agree, Agreed, heaviest, Reach, Samples, spread
from ros_rops.modelling.exposure import exposures
from ros_rops.modelling.gathering import every_point, noise_of, piece_sizes_of, samples_of
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.products import Fact, ModelCloud
from ros_rops.modelling.witnesses import Tolerance, Witness

LEAST_RADIUS_MR = 1.5
"""A view has some nine points within it: enough for a height and a slope."""
NOISE_RADII = 3.0
"""The neighbourhood is wider by so many standard deviations of the noise."""
MOST_RADIUS_MR = 3.0
NOISY_MR = 0.1
"""From this noise on the normals of single triangles are too rough to tell sides by."""
NEAR_MR = 1.0
"""A view without a point so near did not see the place."""
THROUGH_MR = 2.0
"""Of a surface seen so far behind, a point is no part; and five standard deviations of noise."""
SIDEWAYS_MR = 1.5
"""A ray that passes an edge by less might meet it if the pose were a little better."""
FEW_DIRECTIONS = 2
"""What more views saw is there, whatever another says."""
SPECK = 50
"""A piece of fewer points that hangs in the air, seen by one view alone, is none of the object."""


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
        Empty if no view has a surface. With `view_ids`: every point of every view where it was
        measured, view by view.
    """
    noise = float(np.median([noise_of(view) for view in views])) if views else 0.0
    reach = _reach(config, resolution, noise)
    if config.view_ids:
        return _unmerged(views, reach, threads)
    tolerance = Tolerance(THROUGH_MR * resolution + 5 * noise, SIDEWAYS_MR * resolution)
    samples = samples_of(views, exposures(views, resolution))
    if noise > NOISY_MR * resolution:
        samples = _smoothed(samples, reach, threads)
    targets, agreed = _merged(samples, config.cloud_mr * resolution, reach, threads)
    sizes = piece_sizes_of(views)[targets]
    specks = (agreed.directions < FEW_DIRECTIONS) & (sizes < SPECK)
    seen_through = _seen_through(agreed, views, tolerance, threads)
    kept = np.flatnonzero(~specks & ~seen_through)
    measured = sum(len(view.view.points) for view in views)
    return _cloud(views, samples, agreed.at(kept), {
        'points_measured': measured, 'points': len(kept),
        'points_without_surface': sum(int((view.weights <= 0).sum()) for view in views),
        'specks_removed': int(specks.sum()),
        'seen_through_removed': int((seen_through & ~specks).sum()),
        'views': len(views), 'noise': noise, 'radius': reach.radius})


def _reach(config: ModelConfig, resolution: float, noise: float) -> Reach:
    radius = min(
        LEAST_RADIUS_MR * resolution + NOISE_RADII * noise, MOST_RADIUS_MR * resolution)
    near = NEAR_MR * resolution
    return Reach(radius, near, max(config.cloud_mr * resolution, near))


def _smoothed(samples: Samples, reach: Reach, threads: int) -> Samples:
    """Return the samples with the normals that the points around them agree on."""
    every = np.arange(len(samples.points), dtype=np.int32)
    return samples._replace(normals=agree(samples, every, reach, threads=threads).normals)


def _merged(
    samples: Samples, spacing: float, reach: Reach, threads: int
) -> tuple[Ints, Agreed]:
    """Return which samples stand for the places of the surface, and what is agreed on there."""
    targets = np.arange(len(samples.points), dtype=np.int32)
    if spacing > 0:
        targets = heaviest(samples.points, samples.normals, samples.weights, spacing)
    agreed = agree(samples, targets, reach, threads=threads)
    pick = np.arange(len(targets), dtype=np.int32)
    if spacing > 0:
        order = np.argsort(-agreed.weights, kind='stable').astype(np.int32)
        pick = spread(agreed.points, agreed.normals, order, spacing)
    # What no point confirms (a normal like no other around) has no weight.
    pick = pick[agreed.weights[pick] > 0]
    return targets[pick], agreed.at(pick)


def _seen_through(
    agreed: Agreed, views: Sequence[PosedView], tolerance: Tolerance, threads: int
) -> Bools:
    """Tell which places more is said against than for, (M,)."""
    result = np.zeros(len(agreed.points), np.bool_)
    some = np.flatnonzero(agreed.directions <= FEW_DIRECTIONS)
    against = np.zeros(len(some))
    for view in views:
        against += Witness(view).denies(agreed.points[some], tolerance, threads)
    result[some] = against > agreed.weights[some]
    return result


def _unmerged(views: Sequence[PosedView], reach: Reach, threads: int) -> ModelCloud:
    samples, on_surface = every_point(views)
    targets = np.flatnonzero(on_surface).astype(np.int32)
    surface = samples._replace(
        points=samples.points[targets], normals=samples.normals[targets],
        weights=samples.weights[targets], views=samples.views[targets],
        colors=samples.colors[:0])
    every = np.arange(len(targets), dtype=np.int32)
    directions = np.ones(len(samples.points), np.int32)
    directions[targets] = agree(surface, every, reach, move=False, threads=threads).directions
    return _cloud(views, samples, Agreed(
        samples.points, samples.normals, samples.weights, samples.views, directions, directions,
        samples.colors[:, :3]), {
            'points_measured': len(samples.points), 'points': len(samples.points),
            'points_without_surface': int((~on_surface).sum()), 'views': len(views)})


def _cloud(
    views: Sequence[PosedView], samples: Samples, agreed: Agreed, facts: Mapping[str, Fact]
) -> ModelCloud:
    numbers = np.array([view.number for view in views], np.int32)
    return ModelCloud(
        agreed.points, agreed.normals, agreed.colors if len(samples.colors) else None,
        agreed.weights, numbers[agreed.views] if len(numbers) else agreed.views,
        np.minimum(agreed.directions, 255).astype(np.uint8), facts)
