# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Dataset folders: `views/` (one file a view) and `reference_poses.json`."""

from dataclasses import dataclass, field
import os
from pathlib import Path

from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats
from ros_rops.recordings.files import kind_of, natural_key
from ros_rops.recordings.poses import POSES_NAME, read_poses
from ros_rops.recordings.reader import NotedView, read_view_noted


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
    paths = tuple(p for p in list_files(folder) if kind_of(p))
    if not paths:
        raise InputError(f'{folder}: holds no view file')
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


def list_files(folder: Path) -> list[Path]:
    """
    Return the files of `folder/views`, or of the folder itself, in natural order.

    Raises
    ------
    InputError
        If the folder cannot be read.
    """
    inner = folder / 'views'
    try:
        listed = inner if inner.is_dir() else folder
        found = [path for path in listed.iterdir() if path.is_file()]
    except OSError as error:
        raise InputError(
            f'{folder}: the folder cannot be read ({error.strerror or error})') from None
    return sorted(found, key=lambda path: natural_key(path.name))
