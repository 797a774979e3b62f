# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Poses beside the views: `reference_poses.json` and Stanford's `.conf` files."""

from dataclasses import dataclass, field
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats
from ros_rops.recordings.files import read_bytes

POSES_NAME = 'reference_poses.json'


@dataclass(frozen=True, slots=True)
class Poses:
    """
    Content of a `reference_poses.json`.

    Parameters
    ----------
    units : {'m', 'mm'}
        Of the views and of the poses' translations.
    reference : str
        'published', 'derived' or 'exact'.
    T_world_view : dict of str to (4, 4) float64
        By file name.
    objects : dict of str to str
        The object that each view shows, where it is said.
    note : str
        Where the poses come from.
    centres : dict of str to (3,) float64
        Where the views show several objects at once: the middle of each, in the world.
    """

    units: str
    reference: str
    T_world_view: dict[str, Floats]
    objects: dict[str, str]
    note: str = ''
    centres: dict[str, Floats] = field(default_factory=dict)


def read_poses(path: str | os.PathLike[str]) -> Poses:
    """
    Read poses in the form of `reference_poses.json`.

    Raises
    ------
    InputError
        If the file is no such JSON, its units are unknown or a pose is no rigid 4x4 transform.
    """
    path = Path(path)
    return parse_poses(read_bytes(path), str(path))


def parse_poses(data: bytes, path: str) -> Poses:
    """Return the poses of a `reference_poses.json`'s bytes; errors as `read_poses`."""
    try:
        content = json.loads(data)
        units, table = content['units'], content['T_world_view']
        T_world_view = {str(name): np.array(T, dtype=np.float64) for name, T in table.items()}
        objects = {str(k): str(v) for k, v in content.get('objects', {}).items()}
        centres = {
            str(k): np.array(v, np.float64).reshape(3)
            for k, v in content.get('centres', {}).items()}
        reference, note = str(content.get('reference', '')), str(content.get('note', ''))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f'{path}: is not a file of reference poses ({error!r})') from None
    if units not in ('m', 'mm'):
        raise InputError(f'{path}: units are {units!r}, neither m nor mm')
    for name, T in T_world_view.items():
        if not _is_rigid(T):
            raise InputError(f'{path}: the pose of {name!r} is no rigid 4x4 transform')
    return Poses(units, reference, T_world_view, objects, note, centres)


def poses_document(poses: Poses) -> dict[str, Any]:
    """Return the content of `reference_poses.json`; what is empty is left out."""
    content: dict[str, Any] = {'units': poses.units, 'reference': poses.reference}
    if poses.note:
        content['note'] = poses.note
    if poses.objects:
        content['objects'] = dict(poses.objects)
    if poses.centres:
        content['centres'] = {name: centre.tolist() for name, centre in poses.centres.items()}
    content['T_world_view'] = {name: T.tolist() for name, T in poses.T_world_view.items()}
    return content


def stated_units(path: Path) -> str | None:
    """
    Return the units that the poses beside a view, or beside its `views` folder, state.

    Raises
    ------
    InputError
        If those poses are unsound.
    """
    folder = path.resolve().parent
    if folder.name == 'views':
        folder = folder.parent
    poses = folder / POSES_NAME
    return read_poses(poses).units if poses.is_file() else None


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
