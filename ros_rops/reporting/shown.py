# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""An object as it is looked at: read from the files of a run folder, coloured as asked for."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from ros_rops.core.errors import InputError
from ros_rops.core.types import Bytes, Floats, Ints
from ros_rops.recordings.cloud import FormatError
from ros_rops.recordings.files import read_bytes
from ros_rops.recordings.ply import parse_mesh, parse_vertices
from ros_rops.reporting.picture import PALETTE

PLAIN = (205, 205, 200)


@dataclass(frozen=True, slots=True)
class Shown:
    """
    What is drawn.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float64
        Zero where none is known.
    colors : (N, 3) uint8
    faces : (F, 3) int32 or None
        None: points only.
    what : str
        In words.
    """

    points: Floats
    normals: Floats
    colors: Bytes
    faces: Ints | None
    what: str


def read_shown(folder: Path, object_id: int, color: str) -> Shown:
    """
    Read an object of a run.

    Parameters
    ----------
    folder : Path
    object_id : int
    color : {'view', 'residual', 'rgb'}
        `view`: the surface, or where there is none the cloud, by the view that saw it. `residual`:
        the points of all views. `rgb`: the surface or cloud as the sensor saw it; grey without
        colours.

    Raises
    ------
    InputError
        If a file that is needed is not there, or cannot be read.
    """
    stem = folder / f'object_{object_id}'
    if color == 'residual':
        path = Path(f'{stem}_residuals.ply')
        columns = _columns(path)
        points = _stack(path, columns, 'xyz')
        return Shown(points, np.zeros_like(points), _rgb(columns, len(points)), None,
                     'residuals of all views')
    path = Path(f'{stem}_surface.ply')
    surface = path.exists()
    if not surface:
        path = Path(f'{stem}.ply')
    columns = _columns(path)
    points = _stack(path, columns, 'xyz')
    normals = _stack(path, columns, ('nx', 'ny', 'nz'))
    colors = _by_view(Path(f'{stem}.ply'), points) if color == 'view' else (
        _rgb(columns, len(points)))
    what = 'surface' if surface else 'cloud'
    if color == 'rgb' and 'red' not in columns:
        what += ', without colours of its own'
    elif color == 'view':
        what += ' by view'
    return Shown(points, normals, colors, _faces(path) if surface else None, what)


def _by_view(path: Path, points: Floats) -> Bytes:
    """Return the colour of the view that saw the nearest point of the cloud."""
    from scipy.spatial import cKDTree

    columns = _columns(path)
    if 'view_id' not in columns:
        raise InputError(f'{path}: does not say which view saw a point')
    _, nearest = cKDTree(_stack(path, columns, 'xyz')).query(points)
    ids = columns['view_id'][nearest]
    order = np.searchsorted(np.unique(columns['view_id']), ids)
    return np.rint(PALETTE[order % len(PALETTE)] * 255).astype(np.uint8)


def _columns(path: Path) -> dict[str, np.ndarray]:
    if not path.exists():
        raise InputError(f'{path}: is not there; `rops model {path.parent}` makes it')
    try:
        return parse_vertices(read_bytes(path))
    except FormatError as error:
        raise InputError(f'{path}: {error}') from None


def _faces(path: Path) -> Ints:
    try:
        return parse_mesh(read_bytes(path))[1]
    except FormatError as error:
        raise InputError(f'{path}: {error}') from None


def _stack(path: Path, columns: dict[str, np.ndarray], names: str | tuple[str, ...]) -> Floats:
    try:
        found: Floats = np.stack([columns[name] for name in names], axis=1).astype(np.float64)
    except KeyError as error:
        raise InputError(f'{path}: lacks {error}') from None
    if not len(found):
        raise InputError(f'{path}: is empty')
    if not np.isfinite(found).all():
        raise InputError(f'{path}: is damaged; {"".join(names)} are not all numbers')
    return found


def _rgb(columns: dict[str, np.ndarray], count: int) -> Bytes:
    if not {'red', 'green', 'blue'} <= set(columns):
        return np.full((count, 3), PLAIN, np.uint8)
    return np.stack([columns[name] for name in ('red', 'green', 'blue')], axis=1).astype(np.uint8)
