# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the report's 3D view draws of an object: layers, read from the folder's PLY files."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import InputError
from ros_rops.core.types import Bools, Bytes, Floats, Floats32or64, Ints
from ros_rops.recordings.cloud import FormatError
from ros_rops.recordings.files import read_bytes
from ros_rops.recordings.ply import parse_mesh, parse_vertices
from ros_rops.reporting.report_thin import cluster_vertices, every_so_many, means
from scipy.spatial import cKDTree

FILES = {'surface': 'object_{}_surface.ply', 'cloud': 'object_{}.ply',
         'residuals': 'object_{}_residuals.ply'}
FACE = 1.6
"""Bytes of a face in the report."""
NEIGHBOURS = 8
"""Residuals that are averaged where they are carried over to another layer."""


@dataclass(frozen=True, slots=True)
class Layer:
    """
    Points or a surface, in the object's frame and the run's units.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float or None
    colors : (N, 3) uint8 or None
    views : (N,) int32 or None
        `view_id` of each point; -1 for none.
    residuals : (N,) float32 or None
        NaN where nothing is known.
    states : (N,) uint8 or None
        0 alone, 1 confirmed, 2 contradicted by other views.
    faces : (F, 3) int32 or None
    filled : (F,) bool or None
        Faces where no view saw a surface.
    of : int
        Points in the file.
    of_faces : int
        Faces in the file.
    signed : bool
        Whether the residuals have a sign, or are means of sizes.
    cell : float
        Edge of the cells in which vertices were merged.
    """

    points: Floats
    normals: Floats32or64 | None = None
    colors: Bytes | None = None
    views: Ints | None = None
    residuals: NDArray[np.float32] | None = None
    states: Bytes | None = None
    faces: Ints | None = None
    filled: Bools | None = None
    of: int = 0
    of_faces: int = 0
    signed: bool = True
    cell: float = 0.0

    @property
    def bytes_each(self) -> float:
        """
        Return about how many bytes a point takes in the report, its share of faces included.

        As real scans are deflated: positions from 6 to 4, faces from 9 to 1.6, ...
        """
        return (4.2 + 1.5 * (self.normals is not None) + 1.5 * (self.colors is not None)
                + 0.3 * (self.views is not None) + 1.6 * (self.residuals is not None)
                + 0.1 * (self.states is not None)
                + (0 if self.faces is None else FACE * len(self.faces) / max(len(self.points), 1)))


@dataclass(frozen=True, slots=True)
class Layers:
    """The layers of an object by name (`FILES`), and why the others are missing."""

    found: dict[str, Layer] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)


def read_layers(folder: Path, object_id: int) -> Layers:
    """Read what the folder has of an object; a file that is missing or broken is told."""
    layers = Layers()
    for name, pattern in FILES.items():
        path = folder / pattern.format(object_id)
        if not path.exists():
            layers.missing[name] = f'{path.name} is not in the run folder'
            continue
        try:
            layer = _read(path, name == 'surface')
            if not len(layer.points):
                raise FormatError('holds no points')
            layers.found[name] = layer
        except (FormatError, InputError, KeyError, ValueError) as error:
            text = str(error).removeprefix(f'{path}: ')
            layers.missing[name] = f'{path.name} {text}'
    return layers


def _read(path: Path, surface: bool) -> Layer:
    data = read_bytes(path)
    columns = parse_vertices(data)
    points = _stacked(columns, ('x', 'y', 'z'), np.float64)
    if points is None:
        raise FormatError('lacks x, y or z')
    sound = np.isfinite(points).all(axis=1)
    if surface and not sound.all():
        raise FormatError('has vertices that are not finite')
    faces = parse_mesh(data)[1] if surface else None
    flags = parse_vertices(data, 'face').get('filled') if surface else None
    layer = Layer(
        points, _stacked(columns, ('nx', 'ny', 'nz'), np.float32),
        _stacked(columns, ('red', 'green', 'blue'), np.uint8), _column(columns, 'view_id', 'i4'),
        _column(columns, 'residual', 'f4'), _column(columns, 'state', 'u1'), faces,
        None if flags is None else flags.astype(np.bool_))
    if not sound.all():
        layer = _picked(layer, np.flatnonzero(sound))
    if layer.residuals is not None:
        # Their colours are those of the residuals: the report has its own scale.
        layer = replace(layer, colors=None)
    return replace(layer, of=len(points), of_faces=0 if faces is None else len(faces))


def _column(columns: dict[str, NDArray], name: str, dtype: str) -> NDArray | None:
    return columns[name].astype(dtype) if name in columns else None


def _stacked(columns: dict[str, NDArray], names: tuple[str, ...], dtype: type) -> NDArray | None:
    if not all(name in columns for name in names):
        return None
    return np.stack([columns[name] for name in names], axis=1).astype(dtype)


def _picked(layer: Layer, at: NDArray[np.int64]) -> Layer:
    """Return the layer of the points at `at`; for points only."""
    def of(array: NDArray | None) -> NDArray | None:
        return None if array is None else array[at]

    return replace(
        layer, points=layer.points[at], normals=of(layer.normals), colors=of(layer.colors),
        views=of(layer.views), residuals=of(layer.residuals), states=of(layer.states))


def thinned(layer: Layer, most: int) -> Layer:
    """Return a layer of at most `most` points or vertices."""
    if layer.faces is None:
        return _picked(layer, every_so_many(layer.points, most))
    groups, faces, kept, cell = cluster_vertices(layer.points, layer.faces, most)
    if not cell:
        return layer
    normals, colors = layer.normals, layer.colors
    return replace(
        layer, points=means(layer.points, groups), faces=faces, cell=cell,
        filled=None if layer.filled is None else layer.filled[kept],
        normals=None if normals is None else means(normals, groups),
        colors=None if colors is None else np.rint(means(colors, groups)).astype(np.uint8))


def with_views(layer: Layer, cloud: Layer) -> Layer:
    """Give each vertex of a surface the view of the nearest point of the cloud."""
    if cloud.views is None:
        return layer
    nearest = cKDTree(cloud.points).query(layer.points)[1]
    return replace(layer, views=cloud.views[nearest])


def with_normals(layer: Layer, cloud: Layer) -> Layer:
    """Give each point the normal of the nearest point of the cloud: without, it is not lit."""
    if cloud.normals is None:
        return layer
    nearest = cKDTree(cloud.points).query(layer.points)[1]
    return replace(layer, normals=cloud.normals[nearest])


def with_residuals(layer: Layer, measured: Layer, reach: float) -> Layer:
    """Give each point the mean size of the residuals measured around it, within `reach`."""
    if measured.residuals is None:
        return layer
    known = np.flatnonzero(np.isfinite(measured.residuals))
    if not len(known):
        return layer
    distance, at = cKDTree(measured.points[known]).query(
        layer.points, k=NEIGHBOURS, distance_upper_bound=reach)
    near = np.isfinite(distance)
    sizes = np.abs(np.append(measured.residuals[known], 0.0))[np.where(near, at, len(known))]
    count = near.sum(axis=1)
    mean = np.where(count > 0, sizes.sum(axis=1) / np.maximum(count, 1), np.nan)
    return replace(layer, residuals=mean.astype(np.float32), signed=False)
