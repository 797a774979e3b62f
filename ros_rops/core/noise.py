# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
How noisy a view is, and its noise evened out.

Edges, normals, frames and descriptors differentiate: errors as large as the spacing of the
pixels leave nothing of them, although many pixels together still know the surface well. Averaging
blocks of them would do, but costs resolution, which views of little overlap need.
"""

from dataclasses import dataclass, replace
import math

import numpy as np
from ros_rops.core.config import MeshConfig
from ros_rops.core.mesh import image_plane
from ros_rops.core.types import Floats, Ints, RangeView
from ros_rops.kernels.smoothing import smooth
from scipy.spatial import cKDTree

# Places whose surroundings tell the noise; pixels of such a surrounding.
WINDOWS = 300
AROUND = 24
# Pixels between which the spacing is measured: between neighbours the noise would count.
APART = 4
# The weights' width, in pixels, at a noise of one spacing. Errors of n pixels average to
# 1/sqrt(n), n is proportional to the width's square.
WIDTH = 2.0


@dataclass(frozen=True, slots=True)
class _Image:
    """
    A view as an image: what is smoothed, and over what.

    Parameters
    ----------
    points : (P,) int
        The view's points in it.
    places : (P, 2) float64
        About 1 apart.
    values : (P, C) float64
        The depth (C = 1) or all coordinates, the depth last (C = 3), in spacings.
    axes : (3, C) float64
        Along which the values were measured; unused for the rays of a pinhole.
    spacing : float
    tree : cKDTree
        Of the places, in whatever scale.
    """

    points: Ints
    places: Floats
    values: Floats
    axes: Floats
    spacing: float
    tree: cKDTree


def noise_of(view: RangeView) -> float:
    """
    Return the standard deviation of a view's points across its surface, in its units.

    The median over some places of the distances to a surface of second order fitted there; what
    errors many neighbours have in common is not in it. 0 if the view tells nothing.
    """
    image = _image(view)
    return 0.0 if image is None else _noise(image) * image.spacing


def evened(view: RangeView, config: MeshConfig, *, threads: int = 0) -> RangeView:
    """
    Return a view whose noise is evened out, if it has much.

    Parameters
    ----------
    view : RangeView
    config : MeshConfig
        `noise_least`: noise, in spacings of the points, from which on.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    RangeView
        The same points moved, along their rays where they have no grid; the view itself if it
        has little noise.
    """
    image = _image(view) if config.noise_least > 0 else None
    noise = 0.0 if image is None else _noise(image)
    if image is None or noise < config.noise_least:
        return view
    smoothed = smooth(
        image.places, image.values, sigma=WIDTH * math.sqrt(noise), noise=noise, threads=threads)
    shift = (smoothed - image.values) * image.spacing
    points = view.points.copy()
    if view.grid is None and view.sensor.kind == 'pinhole':
        rays = points[image.points] - np.asarray(view.sensor.origin)
        points[image.points] += rays * (shift[:, -1] / (rays @ image.axes[:, -1]))[:, None]
    else:
        points[image.points] += shift @ image.axes.T
    return replace(view, points=points)


def _image(view: RangeView) -> _Image | None:
    if view.grid is not None:
        return _grid_image(view)
    return None if view.sensor.kind == 'unknown' else _scattered_image(view)


def _grid_image(view: RangeView) -> _Image | None:
    grid = np.asarray(view.grid)
    axes = _axes(view)
    steps = [
        _step(view.points @ axes[:, :2], grid[:, :-APART], grid[:, APART:]),
        _step(view.points @ axes[:, :2], grid[:-APART], grid[APART:])]
    spacing = math.sqrt(steps[0] * steps[1])
    if not spacing > 0:
        return None
    rows, columns = np.nonzero(grid >= 0)
    places = np.stack([columns * (steps[0] / spacing), rows * (steps[1] / spacing)], axis=1)
    points = grid[rows, columns]
    return _Image(
        points, places, view.points[points] @ axes / spacing, axes, spacing, _tree(places))


def _tree(places: Floats) -> cKDTree:
    # A few hundred are asked for: what makes the asking faster costs more than it saves.
    return cKDTree(places, balanced_tree=False, compact_nodes=False)


def _step(across: Floats, first: Ints, second: Ints) -> float:
    """Median distance across the line of sight of pixels, a pixel; 0 without any."""
    both = (first >= 0) & (second >= 0)
    if not both.any():
        return 0.0
    gaps = across[second[both]] - across[first[both]]
    return float(np.median(np.hypot(gaps[:, 0], gaps[:, 1]))) / APART


def _scattered_image(view: RangeView) -> _Image | None:
    uv, front = image_plane(view.sensor, view.points)
    if len(front) <= AROUND:
        return None
    sample = uv[::max(len(uv) // WINDOWS, 1)]
    tree = _tree(uv)
    # That many neighbours lie in a circle of as many squares of a pixel.
    radius = float(np.median(tree.query(sample, k=AROUND + 1)[0][:, -1]))
    pitch = radius * math.sqrt(math.pi / AROUND)
    depths = view.points[front] @ np.asarray(view.sensor.direction)
    if view.sensor.kind == 'pinhole':
        depths = depths - np.dot(view.sensor.origin, view.sensor.direction)
    spacing = pitch * (float(np.median(depths)) if view.sensor.kind == 'pinhole' else 1.0)
    if not spacing > 0:
        return None
    axis = np.asarray(view.sensor.direction)[:, None]
    return _Image(front, uv / pitch, depths[:, None] / spacing, axis, spacing, tree)


def _axes(view: RangeView) -> Floats:
    """Two axes across the line of sight and the one along it, the columns of (3, 3)."""
    axis = np.asarray(view.sensor.direction)
    right = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(axis, right), axis], axis=1)


def _noise(image: _Image) -> float:
    """Noise across the surface, in spacings."""
    if len(image.places) <= AROUND:
        return 0.0
    sample = np.arange(0, len(image.places), max(len(image.places) // WINDOWS, 1))
    _, near = image.tree.query(image.tree.data[sample], k=AROUND + 1)
    du, dv = np.moveaxis(image.places[near] - image.places[sample][:, None], 2, 0)
    terms = np.stack([np.ones_like(du), du, dv, du * du, du * dv, dv * dv], axis=2)
    depths = image.values[near, -1] - image.values[sample, -1:]
    across = np.swapaxes(terms, 1, 2)
    # The pseudo-inverse: places in a row leave directions open.
    inverse = np.linalg.pinv(across @ terms, hermitian=True)
    coefficients = (inverse @ (across @ depths[:, :, None]))[:, :, 0]
    left = depths - (terms @ coefficients[:, :, None])[:, :, 0]
    spread = np.sqrt((left**2).sum(axis=1) / (left.shape[1] - terms.shape[2]))
    slopes = coefficients[:, 1]**2 + coefficients[:, 2]**2
    return float(np.median(spread / np.sqrt(1.0 + slopes)))
