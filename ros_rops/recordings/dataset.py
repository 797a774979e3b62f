# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Dataset folders: `views/` and `reference_poses.json`; and Stanford's `.conf` files."""

from dataclasses import dataclass, field
import json
import os
from pathlib import Path

import numpy as np

from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats
from ros_rops.recordings.files import kind_of, natural_key, read_bytes
from ros_rops.recordings.reader import NotedView, read_view_noted

POSES_NAME = 'reference_poses.json'
REFERENCES = ('published', 'derived', 'exact')


@dataclass(frozen=True, slots=True)
class Dataset:
    """
    Range views of one object, or several, and where they belong.

    Parameters
    ----------
    folder : Path
    name : str
        The folder's name.
    units : str
        'm', 'mm', or 'auto' if no poses state them.
    reference : str
        'published', 'derived' or 'exact'; '' without poses.
    paths : tuple of Path
        The views' files in natural order.
    T_world_view : dict of str to (4, 4) float64
        By file name; empty without `reference_poses.json`.
    objects : dict of str to str
        The object that each view shows, where the poses say it.
    """

    folder: Path
    name: str
    units: str
    reference: str
    paths: tuple[Path, ...]
    T_world_view: dict[str, Floats] = field(default_factory=dict)
    objects: dict[str, str] = field(default_factory=dict)

    def read_views(self, *, sensor: str = 'auto') -> list[NotedView]:
        """
        Read all views, in the stated units.

        Raises
        ------
        InputError
            If a view cannot be read.
        """
        return [read_view_noted(p, units=self.units, sensor=sensor) for p in self.paths]


@dataclass(frozen=True, slots=True)
class Poses:
    """Content of a `reference_poses.json`; see `Dataset` for the fields."""

    units: str
    reference: str
    T_world_view: dict[str, Floats]
    objects: dict[str, str]


def read_dataset(folder: str | os.PathLike[str]) -> Dataset:
    """
    Read a dataset folder: which views, in which units, and their reference poses.

    Parameters
    ----------
    folder : path
        Holds `views/` (or the view files themselves) and, optionally, `reference_poses.json`.

    Raises
    ------
    InputError
        If the folder cannot be read, holds no view, or its poses are unsound or lack a view.
    """
    folder = Path(folder)
    inner = folder / 'views'
    paths = list_views(inner if inner.is_dir() else folder)
    name = folder.resolve().name
    if not (folder / POSES_NAME).exists():
        return Dataset(folder, name, 'auto', '', paths)
    poses = read_poses(folder / POSES_NAME)
    known = {path.name for path in paths}
    missing = sorted(set(poses.T_world_view) - known, key=natural_key)
    if missing:
        raise InputError(f'{folder / POSES_NAME}: has a pose of {missing[0]!r}, no such view')
    return Dataset(
        folder, name, poses.units, poses.reference, paths, poses.T_world_view, poses.objects)


def list_views(folder: Path) -> tuple[Path, ...]:
    """
    Return the view files of a folder in natural order (view2 before view10).

    Raises
    ------
    InputError
        If the folder cannot be read or holds no view file.
    """
    try:
        found = [path for path in folder.iterdir() if kind_of(path) and path.is_file()]
    except OSError as error:
        raise InputError(
            f'{folder}: the folder cannot be read ({error.strerror or error})') from None
    if not found:
        raise InputError(f'{folder}: holds no view file')
    return tuple(sorted(found, key=lambda path: natural_key(path.name)))


def read_poses(path: str | os.PathLike[str]) -> Poses:
    """
    Read poses in the form of `reference_poses.json`.

    Raises
    ------
    InputError
        If the file is no such JSON, its units are unknown or a pose is no rigid 4x4 transform.
    """
    path = Path(path)
    try:
        content = json.loads(read_bytes(path))
        units, table = content['units'], content['T_world_view']
        T_world_view = {str(name): np.array(T, dtype=np.float64) for name, T in table.items()}
        objects = {str(k): str(v) for k, v in content.get('objects', {}).items()}
        reference = str(content.get('reference', ''))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f'{path}: is not a file of reference poses ({error!r})') from None
    if units not in ('m', 'mm'):
        raise InputError(f'{path}: units are {units!r}, neither m nor mm')
    for name, T in T_world_view.items():
        if not _is_rigid(T):
            raise InputError(f'{path}: the pose of {name!r} is no rigid 4x4 transform')
    return Poses(units, reference, T_world_view, objects)


def _is_rigid(T: Floats) -> bool:
    if T.shape != (4, 4) or not np.isfinite(T).all():
        return False
    R = T[:3, :3]
    return bool(
        np.allclose(T[3], (0, 0, 0, 1), atol=1e-9)
        and np.allclose(R @ R.T, np.eye(3), atol=1e-4)
        and np.linalg.det(R) > 0
    )


def read_conf(path: str | os.PathLike[str]) -> dict[str, Floats]:
    """
    Read the poses of a Stanford `.conf` file, `T_world_view` by file name.

    A line `bmesh name tx ty tz qx qy qz qw` means p_world = R(q)^T p + t; other lines are skipped.

    Raises
    ------
    InputError
        If the file cannot be read, has no `bmesh` line or a line without seven numbers.
    """
    path = Path(path)
    poses: dict[str, Floats] = {}
    for line in read_bytes(path).decode('latin-1').splitlines():
        words = line.split()
        if not words or words[0] != 'bmesh':
            continue
        try:
            x, y, z, qx, qy, qz, qw = (float(word) for word in words[2:])
        except ValueError:
            raise InputError(f'{path}: no seven numbers in {line[:80]!r}') from None
        T = np.eye(4)
        T[:3, :3] = _rotation(qx, qy, qz, qw).T
        T[:3, 3] = x, y, z
        if not _is_rigid(T):
            raise InputError(f'{path}: no rigid transform in {line[:80]!r}')
        poses[words[1]] = T
    if not poses:
        raise InputError(f'{path}: has no bmesh line')
    return poses


def _rotation(x: float, y: float, z: float, w: float) -> Floats:
    norm = float(np.sqrt(x * x + y * y + z * z + w * w)) or float('nan')
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
