# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the kernel that evens out the noise of an image of points."""

from ros_rops.core.errors import ParameterError, ShapeError
from ros_rops.core.types import Floats
from ros_rops.kernels import _kernels


def smooth(
    places: Floats, values: Floats, *, sigma: float, noise: float, threads: int = 0
) -> Floats:
    """
    Replace values by those of planes fitted around their places.

    A plane is fitted over the places to every column, with weights that fall with the distance
    (normal, cut at two standard deviations), from places of the same surface: whose depths are
    near its own, given the noise and slopes of up to 3, and then near the plane.

    Parameters
    ----------
    places : (N, 2) float64
        In an image, a pixel about 1 apart.
    values : (N, C) float64
        The last column is the depth, in units of the pixels' spacing.
    sigma : float
        Standard deviation of the weights, in pixels.
    noise : float
        Standard deviation of the depths' errors, in units of the pixels' spacing.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    (N, C) float64
        Values with too little around them, and those of stray points, are as they were.

    Raises
    ------
    ShapeError
        If an array has the wrong shape.
    ParameterError
        If `sigma` is not positive or `noise` is negative.
    """
    if places.ndim != 2 or places.shape[1] != 2:
        raise ShapeError(f'places: expected (N, 2), got {places.shape}')
    if values.ndim != 2 or values.shape[0] != len(places) or values.shape[1] < 1:
        raise ShapeError(f'values: expected ({len(places)}, 1 or more), got {values.shape}')
    if not sigma > 0 or not noise >= 0:
        raise ParameterError(
            f'sigma, noise: expected above 0 and 0 or more, got {sigma!r}, {noise!r}')
    smoothed: Floats = _kernels.smooth(places, values, sigma, noise, threads)
    return smoothed
