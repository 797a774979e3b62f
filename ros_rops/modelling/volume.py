# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The surface of an object from signed distances (Curless and Levoy 1996; Guo et al. IV-C)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math

import numpy as np
from ros_rops.core.config import ModelConfig
from ros_rops.core.errors import ModelError
from ros_rops.core.types import Floats, frozen
from ros_rops.kernels.volume import BRICK, BRICK_BYTES, Distances, Volume
from ros_rops.modelling.agreement import spread_of
from ros_rops.modelling.cleaning import cleaned
from ros_rops.modelling.extraction import extract
from ros_rops.modelling.filling import filled_faces, filled_volume, Frame
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.products import Fact, SurfaceMesh
from ros_rops.modelling.tint import tinted
from ros_rops.modelling.topology import vertex_normals

BAND_VOXELS = 2.5
"""Least band, in voxels: cubes that the surface passes have corners up to 1.7 from it."""
BAND_MR = 2.0
BAND_SPREADS = 3.0
"""Least band in standard deviations between views: else these would not meet."""
STEEPEST = 0.8 * math.sqrt(3.0)
"""
Most difference between a cube's corners, in bands: twice what a plane makes of the thinnest band,
and more the wider noise makes it; from what was seen through to what is only behind are 1.8.
"""
LONGEST_MR = 20.0
"""Faces longer than this along an axis are no surface that a scan resolved."""
COARSER = 1.25
"""Factor between voxels that are tried when the memory does not suffice."""

Say = Callable[[str], None]


def volumetric_surface(
    views: Sequence[PosedView], config: ModelConfig, *, resolution: float, threads: int = 0,
    say: Say | None = None,
) -> SurfaceMesh:
    """
    Return the surface that the views saw together.

    Parameters
    ----------
    views : sequence of PosedView
        Their order has no influence beyond the last digits.
    config : ModelConfig
        `voxel_mr`, `memory_mb`, `holes`.
    resolution : float
        What mr means (dres), in the views' units.
    threads : int
        0 takes all cores; no influence on the result.
    say : callable, optional
        Is told the voxel, their number and their memory before they are made.

    Returns
    -------
    SurfaceMesh
        Cleaned (`modelling.cleaning`); with holes where no view saw a surface, or with these
        filled and marked (`modelling.filling`). Its facts tell the `method`, the `voxel` and the
        `band` (in units), `voxels` and `volume_mb`.

    Raises
    ------
    ModelError
        If there is no view, or no surface comes of them.
    """
    views = [view for view in views if len(view.mesh.faces)]
    if not views:
        raise ModelError('no view has a surface')
    if not (np.isfinite(resolution) and resolution > 0):
        raise ModelError(f'a resolution of {resolution} makes no voxels')
    grid = _fitting(views, config, resolution, spread_of(views, resolution, threads))
    if say is not None:
        say(grid.announcement(resolution, config))
    sights = [view.sight() for view in views]
    for sight in sights:
        grid.volume.integrate(sight, threads=threads)
    known = grid.volume.distances(threads=threads)
    mesh = _meshed(known, known, views, grid, resolution, threads)
    if config.holes == 'open' or mesh.facts['closed']:
        return mesh
    if say is not None:
        say(f'closing {mesh.facts["holes"]} holes')
    whole = filled_volume(
        known, mesh.vertices, mesh.faces, sights, Frame(grid.origin, grid.voxel, grid.band),
        threads=threads)
    return _meshed(whole, known, views, grid, resolution, threads)


def _meshed(
    distances: Distances, known: Distances, views: Sequence[PosedView], grid: '_Grid',
    resolution: float, threads: int,
) -> SurfaceMesh:
    """Return the cleaned surface in `distances`; what was not `known` is marked."""
    # What is closed must go on wherever it is open.
    surface = extract(distances, grid.steepest if distances is known else math.inf)
    if not len(surface.faces):
        raise ModelError('the views saw no surface wider than a voxel')
    filled = (
        np.zeros(len(surface.faces), dtype=bool) if distances is known
        else filled_faces(known, surface.vertices, surface.faces, grid.steepest))
    vertices = grid.origin + grid.voxel * surface.vertices
    normals = frozen(vertex_normals(vertices, surface.faces), np.float32)
    mesh = cleaned(SurfaceMesh(
        vertices=frozen(vertices, np.float64),
        faces=frozen(surface.faces, np.int32),
        normals=normals,
        colors=tinted(vertices, normals, views, resolution=resolution,
                      far=max(grid.voxel, BAND_SPREADS * grid.spread), threads=threads),
        filled=frozen(filled, np.bool_),
        facts=grid.facts(),
    ), resolution=resolution)
    if not len(mesh.faces):
        raise ModelError('nothing but floating pieces comes of the views')
    return mesh


@dataclass(frozen=True, slots=True)
class _Grid:
    """A volume whose bricks are known and fit into the memory."""

    volume: Volume
    origin: Floats
    voxel: float
    band: float
    spread: float

    @property
    def megabytes(self) -> float:
        return self.volume.bricks * BRICK_BYTES / 1e6

    @property
    def steepest(self) -> float:
        return STEEPEST * self.band / self.voxel

    def facts(self) -> dict[str, Fact]:
        return {
            'method': 'volume', 'voxel': self.voxel, 'band': self.band, 'spread': self.spread,
            'voxels': self.volume.bricks * BRICK**3, 'volume_mb': round(self.megabytes, 1)}

    def announcement(self, resolution: float, config: ModelConfig) -> str:
        size = self.voxel / resolution
        text = (
            f'volume: voxels of {self.voxel:.4g} ({size:.2f} mr), '
            f'{self.volume.bricks * BRICK**3:,} of them, {self.megabytes:.0f} MB')
        if size > 1.001 * config.voxel_mr:
            text += (f'; {config.voxel_mr:g} mr, as model.voxel_mr asks, would need more than '
                     f'model.memory_mb, {config.memory_mb}')
        return text


def _fitting(
    views: Sequence[PosedView], config: ModelConfig, resolution: float, spread: float
) -> _Grid:
    """Return the bricks of the finest voxel, from the one asked for on, that fit the memory."""
    most = int(config.memory_mb * 1e6 / BRICK_BYTES)
    origin = np.median([np.median(view.points, axis=0) for view in views], axis=0)
    voxel = config.voxel_mr * resolution
    while True:
        band = max(BAND_VOXELS * voxel, BAND_MR * resolution, BAND_SPREADS * spread)
        volume = Volume(origin, voxel, band)
        longest = max(LONGEST_MR * resolution, BRICK * voxel)
        if all(volume.touch(view.points, view.mesh.faces, longest=longest, most=most)
               for view in views):
            return _Grid(volume, origin, voxel, band, spread)
        voxel *= COARSER
