# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes known exactly, thin ones among them, seen from all around by a simulated scanner."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from ros_rops.bench.resolution import mesh_resolution
from ros_rops.core.errors import InputError
from ros_rops.core.se3 import move
from ros_rops.core.types import Floats, Ints, RangeView, SensorModel
from ros_rops.recordings.cloud import Cloud, drop_holes, full_grid
from ros_rops.recordings.raycast import Camera, cast
from ros_rops.recordings.simulate_models import PROCEDURAL, read_models
from ros_rops.recordings.synthetic import look_at, Model, render_view, resolution_of

STEP_DEG = 15.0
ELEVATIONS_DEG = (20.0, -20.0)
"""Every other view looks from so far above, the others from so far below."""
AWAY = 3.0
"""Distance of the eye, in radii of the object."""
FILL = 0.7

Sight = Literal['pinhole', 'orthographic']
Mesh = tuple[Floats, Ints]


def lattice(rows: int, columns: int, *, round_rows: bool) -> Ints:
    """Return the triangles of a lattice whose columns (and rows) close up, (F, 3)."""
    r, c = np.mgrid[:rows if round_rows else rows - 1, :columns]
    here, right = r * columns + c, r * columns + (c + 1) % columns
    below, across = (r + 1) % rows * columns + c, (r + 1) % rows * columns + (c + 1) % columns
    return np.concatenate([
        np.stack([here, below, right], axis=-1).reshape(-1, 3),
        np.stack([right, below, across], axis=-1).reshape(-1, 3)]).astype(np.int32)


def cup(radius: float = 0.04, height: float = 0.08, wall: float = 0.002) -> Mesh:
    """Return a cup, open above, of walls 2 mm thick: turned about z, its rim a half circle."""
    t = np.linspace(0, np.pi, 7)
    rim = np.stack([radius + wall / 2 * (np.cos(t) - 1), height + wall / 2 * np.sin(t)], axis=1)
    corners: list[Sequence[float]] = [
        (1e-5, 0.0), (radius, 0.0), *rim, (radius - wall, wall), (1e-5, wall)]
    parts = []
    for start, end in pairwise(np.asarray(corners)):
        count = max(1, int(np.linalg.norm(end - start) / 0.002))
        parts.append(start + np.linspace(0, 1, count, endpoint=False)[:, None] * (end - start))
    profile = np.concatenate([*parts, [corners[-1]]])
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    vertices = np.stack([
        profile[:, :1] * np.cos(angles), profile[:, :1] * np.sin(angles),
        np.broadcast_to(profile[:, 1:], (len(profile), len(angles)))], axis=-1)
    # The profile ends 10 micrometres from the axis: a fan of slivers closes what is left.
    k = np.arange(1, len(angles) - 1)
    fan = np.stack([0 * k, k, k + 1], axis=1)
    last = (len(profile) - 1) * len(angles)
    faces = lattice(len(profile), len(angles), round_rows=False)[:, ::-1]
    return vertices.reshape(-1, 3), np.concatenate(
        [faces, fan[:, ::-1], last + fan]).astype(np.int32)


def knot(size: float = 0.025, thickness: float = 0.006) -> Mesh:
    """Return a rod 6 mm thick bent to a trefoil knot: it hides itself from most sides."""
    t = np.linspace(0, 2 * np.pi, 450, endpoint=False)
    curve = size * np.stack([
        np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -1.2 * np.sin(3 * t),
    ], axis=1)
    along = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    a = np.linspace(0, 2 * np.pi, 24, endpoint=False)[None, :, None]
    tube = curve[:, None] + thickness / 2 * (np.cos(a) * side[:, None] + np.sin(a) * up[:, None])
    return tube.reshape(-1, 3), lattice(*tube.shape[:2], round_rows=True)


THIN: dict[str, Callable[[], Mesh]] = {'thin:cup': cup, 'thin:knot': knot}


def read_shape(name: str) -> Model:
    """
    Return a shape to be captured: `thin:cup`, `thin:knot`, `procedural:NAME` or a mesh file.

    Raises
    ------
    InputError
        If there is no such shape, or the file is no mesh.
    """
    if name in THIN:
        vertices, faces = THIN[name]()
        return Model(vertices, faces, name=name.partition(':')[2], units='m')
    if name.startswith('thin:'):
        raise InputError(f'{name}: the thin shapes are {", ".join(THIN)}')
    size = None if name.startswith(PROCEDURAL) else 0.2
    return read_models([name], size=size)[0]


@dataclass(frozen=True, slots=True)
class Scanner:
    """
    How a shape is scanned.

    Parameters
    ----------
    sight : {'pinhole', 'orthographic'}
    organized : bool
    noise_mr : float
        Standard deviation of the error along the ray, in mesh resolutions of the view.
    pixels : int
        Side of the square image; the object fills up to 0.7 of it.
    """

    sight: Sight = 'pinhole'
    organized: bool = True
    noise_mr: float = 0.0
    pixels: int = 240

    @property
    def text(self) -> str:
        """Return the scanner in words."""
        kind = 'organized' if self.organized else 'unorganized'
        return f'{self.sight}, {kind}, noise {self.noise_mr:g} dres'


def poses_around(model: Model, step_deg: float = STEP_DEG) -> list[Floats]:
    """Return `T_world_view` of a scanner every `step_deg` around z, from above and from below."""
    directions = [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    for k, angle in enumerate(np.radians(np.arange(0.0, 360.0, step_deg))):
        up = np.radians(ELEVATIONS_DEG[k % len(ELEVATIONS_DEG)])
        directions.append((np.cos(up) * np.cos(angle), np.cos(up) * np.sin(angle), np.sin(up)))
    reach = AWAY * model.radius
    return [look_at(model.middle + reach * np.asarray(d), model.middle) for d in directions]


def scan(model: Model, scanner: Scanner, seed: int = 0) -> list[tuple[RangeView, Floats]]:
    """Return the views of a shape from all around with their exact `T_world_view`."""
    rng = np.random.default_rng(seed)
    result = []
    for k, T in enumerate(poses_around(model)):
        name = f'{model.name}_{k:02d}'
        view = _pinhole(model, T, scanner, rng, name) if scanner.sight == 'pinhole' \
            else _orthographic(model, T, scanner, rng, name)
        result.append((view if scanner.organized else replace(view, grid=None), T))
    return result


def dres_of(views: Sequence[tuple[RangeView, Floats]]) -> float:
    """Return the mean mesh resolution of views."""
    return float(np.mean([mesh_resolution(view) for view, _ in views]))


def _pinhole(
    model: Model, T: Floats, scanner: Scanner, rng: np.random.Generator, name: str
) -> RangeView:
    focal = FILL * scanner.pixels / 2 * np.sqrt(AWAY * AWAY - 1)
    middle = (scanner.pixels - 1) / 2
    camera = Camera(scanner.pixels, scanner.pixels, focal, focal, middle, middle)
    return render_view(
        model, T, camera, noise_mr=scanner.noise_mr, rng=rng, name=name).view


def _orthographic(
    model: Model, T: Floats, scanner: Scanner, rng: np.random.Generator, name: str
) -> RangeView:
    """
    Capture with parallel rays, by a projective map under which a pinhole's rays are parallel.

    (x, y, z) goes to (x, y, 1) / (far - z): straight lines stay straight, and what a pinhole finds
    at depth 1 / (far - z) lies at z.
    """
    local, far = move(np.linalg.inv(T), model.vertices), 2 * AWAY * model.radius
    scale = FILL * scanner.pixels / (2 * model.radius)
    middle = (scanner.pixels - 1) / 2
    camera = Camera(scanner.pixels, scanner.pixels, scale, scale, middle, middle)
    mapped = np.concatenate([local[:, :2], np.ones((len(local), 1))], axis=1)
    depth, _ = cast(mapped / (far - local[:, 2:]), model.faces, camera)
    z = far - 1 / depth
    xy = camera.rays()[..., :2]
    if scanner.noise_mr:
        exact = np.concatenate([xy, z[..., None]], axis=-1)
        z = z + rng.normal(0.0, scanner.noise_mr * resolution_of(exact), z.shape)
    cloud = drop_holes(Cloud(
        np.concatenate([xy, z[..., None]], axis=-1).reshape(-1, 3), full_grid(*z.shape), None))
    sensor = SensorModel('orthographic', direction=(0.0, 0.0, 1.0))
    return RangeView(name, cloud.points, cloud.grid, sensor, None, model.units)
