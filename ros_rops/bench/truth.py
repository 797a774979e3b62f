# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A data set folder with its reference poses: `views/` and `reference_poses.json`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any, cast

import numpy as np

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats, frozen, RangeView, Units

POSES_FILE = 'reference_poses.json'
_METRES = {'m': 1.0, 'mm': 0.001}


@dataclass(frozen=True, slots=True, eq=False)
class Dataset:
    """
    Views of one object and their reference poses.

    Parameters
    ----------
    name : str
        Name of the folder.
    units : {'m', 'mm', 'unknown'}
    reference : str
        published, derived or exact.
    views : mapping of str to RangeView
        By file name, in the order of the poses file.
    T_world_view : mapping of str to (4, 4) float64
    dres : float
        Mean over the views of their mean mesh edge length, in `units`.
    """

    name: str
    units: Units
    reference_kind: str
    views: Mapping[str, RangeView]
    T_world_view: Mapping[str, Floats]
    dres: float

    def reference(self, source: str, target: str) -> Floats:
        """Return the reference `T_target_source` (4, 4) of two views."""
        return np.linalg.inv(self.T_world_view[target]) @ self.T_world_view[source]


def mesh_resolution(view: RangeView, config: Config | None = None) -> float:
    """Return the mean edge length of the mesh of one view, in the view's units."""
    from ros_rops.core.mesh import build_mesh

    return build_mesh(view, (config or Config()).mesh).resolution


def units_factor(units: Units, target: Units) -> float:
    """
    Return the factor that turns lengths in `units` into lengths in `target`.

    1 where one of them is unknown: nothing can be known then, and the caller says so.
    """
    if 'unknown' in (units, target):
        return 1.0
    return _METRES[units] / _METRES[target]


def rigid(matrix: object, what: str) -> Floats:
    """
    Return `matrix` as a read-only (4, 4) rigid transform.

    Raises
    ------
    InputError
        If it is not 4x4, not finite, or its rotation is off by more than 0.001.
    """
    try:
        pose = np.asarray(matrix, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f'{what}: not a matrix of numbers') from None
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise InputError(f'{what}: expected a finite 4x4 matrix, got shape {pose.shape}')
    rotation = pose[:3, :3]
    off = np.abs(rotation @ rotation.T - np.eye(3)).max()
    if off > 1e-3 or np.linalg.det(rotation) < 0 or not np.array_equal(pose[3], [0, 0, 0, 1]):
        raise InputError(f'{what}: not a rigid transform (rotation off by {off:.2g})')
    return cast(Floats, frozen(pose, np.float64))


def read_json(path: Path) -> dict[str, Any]:
    """
    Read a JSON object.

    Raises
    ------
    InputError
        If the file is missing, unreadable or no JSON object.
    """
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
    except (OSError, ValueError) as error:
        raise InputError(f'{path}: {error}') from None
    if not isinstance(content, dict):
        raise InputError(f'{path}: expected a JSON object')
    return content


def check_units(value: object, path: Path) -> Units:
    """Return `value` as units, 'unknown' where absent; InputError for any other."""
    units = 'unknown' if value is None else value
    if units not in ('m', 'mm', 'unknown'):
        raise InputError(f'{path}: units {units!r}, expected m or mm')
    return cast(Units, units)


def read_reference(folder: Path) -> tuple[Units, str, dict[str, Floats]]:
    """
    Read `reference_poses.json` of a data set folder.

    Returns
    -------
    units : {'m', 'mm', 'unknown'}
    reference : str
        published, derived or exact; 'unknown' where the file does not say.
    T_world_view : dict of str to (4, 4) float64

    Raises
    ------
    InputError
        If the file is missing, is no such JSON, or holds a matrix that is not rigid.
    """
    path = folder / POSES_FILE
    content = read_json(path)
    poses = content.get('T_world_view')
    if not isinstance(poses, dict) or not poses:
        raise InputError(f'{path}: no T_world_view (file name -> 4x4)')
    kind = content.get('reference', 'unknown')
    T_world_view = {name: rigid(pose, f'{path}: {name}') for name, pose in poses.items()}
    return check_units(content.get('units'), path), str(kind), T_world_view


def load_dataset(
    folder: Path | str,
    *,
    read: Callable[[Path, Units], RangeView],
    resolution: Callable[[RangeView], float] = mesh_resolution,
) -> Dataset:
    """
    Read a data set folder: every view that the poses file names.

    Parameters
    ----------
    folder : Path or str
        Holds `views/` and `reference_poses.json`.
    read : callable
        Reads one file, told the units of the poses file.
    resolution : callable, optional
        Mean mesh edge length of a view.

    Raises
    ------
    InputError
        If the folder, its poses file or one of the views cannot be read.
    """
    folder = Path(folder)
    units, kind, T_world_view = read_reference(folder)
    views = {name: read(folder / 'views' / name, units) for name in T_world_view}
    dres = float(np.mean([resolution(view) for view in views.values()]))
    name = folder.resolve().name
    return Dataset(name, units, kind, views, T_world_view, dres)
