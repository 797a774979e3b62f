# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Where a view's rays come from: stated, or inferred from the points.

An organized view tells by itself: its pixels are affine in (x, y, z) if the rays are parallel,
in (x/z, y/z) if they leave the origin. An unorganized one tells only whether the origin stands
well outside the points.
"""

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import ParameterError
from ros_rops.core.types import Floats, Ints, SensorModel

AXES = {
    '+x': (1.0, 0.0, 0.0), '-x': (-1.0, 0.0, 0.0), '+y': (0.0, 1.0, 0.0),
    '-y': (0.0, -1.0, 0.0), '+z': (0.0, 0.0, 1.0), '-z': (0.0, 0.0, -1.0),
}  # fmt: skip
CHOICES = ('auto', 'pinhole', 'unknown', *AXES)
SAMPLE = 5000
"""Most points that take part in a fit."""
FIT_PX = 3.0
"""A model fits if its pixels are met within this (rms); real lenses distort by a pixel or two."""
CENTRAL_PX = 0.1
"""So close, the rays leave the origin whatever else fits."""
STAND_OFF = 1.5
"""The origin is a centre of projection if it is this many depths away from the points."""
FARTHEST = 200.0
"""Beyond this many extents the origin is an arbitrary frame, not a sensor."""


def resolve_sensor(points: Floats, grid: Ints | None, stated: str) -> tuple[SensorModel, str]:
    """
    Return the sensor of a view and a note ('' if it was stated).

    Parameters
    ----------
    points : (N, 3) float64
        Finite.
    grid : (H, W) int32 or None
    stated : str
        'auto'; 'pinhole' (rays from the origin along the z axis, to the points' side); an axis
        such as '-z' (parallel rays along it); or 'unknown'.

    Raises
    ------
    ParameterError
        If `stated` is none of those.
    """
    if stated == 'unknown':
        return SensorModel('unknown', direction=AXES['-z']), ''
    if stated in AXES:
        return SensorModel('orthographic', direction=AXES[stated]), ''
    if stated == 'pinhole':
        return _pinhole(points), ''
    if stated != 'auto':
        raise ParameterError(f'sensor: {stated!r} is none of {", ".join(CHOICES)}')
    if len(points) < 10:
        return SensorModel('unknown', direction=AXES['-z']), 'sensor unknown: too few points'
    found = None if grid is None else _from_grid(points, grid)
    sensor, why = found or _from_points(points)
    direction = ', '.join(f'{value:.3f}' for value in sensor.direction)
    place = 'pinhole at the origin' if sensor.kind == 'pinhole' else 'parallel rays'
    return sensor, f'sensor inferred: {place} along ({direction}); {why}'


def _pinhole(points: Floats) -> SensorModel:
    behind = len(points) > 0 and float(points[:, 2].mean()) < 0
    return SensorModel('pinhole', direction=AXES['-z' if behind else '+z'])


def _from_grid(points: Floats, grid: Ints) -> tuple[SensorModel, str] | None:
    measured = np.flatnonzero(grid.reshape(-1) >= 0)
    if len(measured) < 10:
        return None
    pick = np.linspace(0, len(measured) - 1, min(SAMPLE, len(measured))).astype(int)
    rows, columns = np.divmod(measured[pick], grid.shape[1])
    pixels = np.stack([columns, rows], axis=1).astype(np.float64)
    xyz = points[grid[rows, columns]]
    central = np.inf
    if xyz[:, 2].min() > 0 or xyz[:, 2].max() < 0:
        central = _misfit_px(xyz[:, :2] / xyz[:, 2:], pixels)
    # A flat scene fits both; only rays that miss their pixels speak against a common centre.
    missed = not central <= CENTRAL_PX
    parallel = _misfit_px(xyz - xyz.mean(axis=0), pixels) if missed else np.inf
    if min(parallel, central) > FIT_PX:
        return None
    if not missed or central <= 1.5 * parallel:
        return _pinhole(xyz), f'its pixels agree within {central:.2g} px'
    direction = _ray_direction(xyz, pixels)
    return SensorModel('orthographic', direction=direction), (
        f'its pixels agree within {parallel:.2g} px; larger z assumed nearer to the sensor')


def _misfit_px(predictors: Floats, pixels: Floats) -> float:
    """Rms distance in pixels left by the best affine map from predictors to pixels."""
    scale = np.ptp(np.ascontiguousarray(predictors.T), axis=1)  # along rows: faster
    design = np.ones((len(predictors), predictors.shape[1] + 1))
    design[:, :-1] = (predictors - predictors.mean(axis=0)) / np.where(scale > 0, scale, 1.0)
    solution = np.linalg.lstsq(design, pixels, rcond=None)[0]
    return float(np.sqrt(((design @ solution - pixels) ** 2).sum(axis=1).mean()))


def _ray_direction(xyz: Floats, pixels: Floats) -> tuple[float, float, float]:
    """
    Return the direction of parallel rays, from a sensor on the side of larger z.

    Along a ray the pixel stays and (x, y) moves with z: its slope is the coefficient of z in
    (x, y) ~ (column, row, z). Scanners that look through a mirror at the side (Cyberware) have
    slopes up to 0.55.
    """
    plane = np.column_stack([pixels - pixels.mean(axis=0), np.ones(len(pixels))])
    basis = np.linalg.qr(plane)[0]

    def off_plane(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return values - basis @ (basis.T @ values)

    depth = off_plane(xyz[:, 2])
    power = float(depth @ depth)
    # A flat view leaves the slope open: then the axis itself.
    flat = power <= 1e-6 * float(np.ptp(xyz, axis=0).max()) ** 2 * len(xyz)
    slope = np.zeros(2) if flat else off_plane(xyz[:, :2]).T @ depth / power
    ray = np.array([-slope[0], -slope[1], -1.0])
    x, y, z = (ray / np.linalg.norm(ray)).tolist()
    return x, y, z


def _from_points(points: Floats) -> tuple[SensorModel, str]:
    low, high = points.min(axis=0), points.max(axis=0)
    middle, extent = (low + high) / 2, float((high - low).max())
    near, depth = float(min(abs(low[2]), abs(high[2]))), float(high[2] - low[2])
    outside = low[2] > 0 or high[2] < 0
    ahead = np.hypot(middle[0], middle[1]) < abs(middle[2])
    if outside and ahead and near > STAND_OFF * depth and near < FARTHEST * extent:
        return _pinhole(points), f'the points begin {near / max(depth, 1e-300):.2g} depths away'
    return SensorModel('orthographic', direction=AXES['-z']), (
        'assumed, the points tell nothing (state the sensor if it is another)')
