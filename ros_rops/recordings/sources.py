# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""From what a user names (folders, files, recordings) to views, one after the other."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import os
from pathlib import Path

from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.recordings.dataset import list_files
from ros_rops.recordings.files import is_recording, kind_of, RECORDING_SUFFIXES, VIEW_SUFFIXES
from ros_rops.recordings.frames import count_frames, frame_view, read_frames
from ros_rops.recordings.reader import BadView, NotedView, read_view_noted
from ros_rops.recordings.rosbag_folder import is_rosbag_folder

Outcome = NotedView | BadView


@dataclass(frozen=True, slots=True)
class ViewFile:
    """
    One file that holds one view.

    Parameters
    ----------
    path : Path
    name : str
        The view's name: the file's, behind as many folders as tell it from the others'.
    """

    path: Path
    name: str

    def count(self) -> int:
        """Return the number of views: one."""
        return 1

    def views(self, *, units: str = 'auto', sensor: str = 'auto') -> Iterator[Outcome]:
        """Yield the view, or a `BadView` if the file cannot be read."""
        try:
            noted = read_view_noted(self.path, units=units, sensor=sensor)
        except InputError as error:
            yield BadView(self.name, str(error))
            return
        yield replace(noted, view=replace(noted.view, name=self.name))


@dataclass(frozen=True, slots=True)
class Recording:
    """
    A recording (.mcap, .bag, .db3, or a rosbag2 folder) that holds any number of views.

    Parameters
    ----------
    path : Path
    topics : tuple of str
        Whose frames to read; none: as `read_frames` chooses.
    """

    path: Path
    topics: tuple[str, ...] = ()

    def count(self) -> int:
        """
        Return the number of views.

        Raises
        ------
        InputError
            If the file is no recording.
        """
        return count_frames(self.path, self.topics)

    def frames(self, *, units: str = 'auto', sensor: str = 'auto') -> Iterator[Frame | BadView]:
        """Yield the frames; a `BadView` for each that cannot be read, or for the whole file."""
        try:
            yield from read_frames(self.path, topics=self.topics, units=units, sensor=sensor)
        except InputError as error:
            yield BadView(self.path.name, str(error))

    def views(self, *, units: str = 'auto', sensor: str = 'auto') -> Iterator[Outcome]:
        """Yield each frame's measured points as a view, nothing segmented, as `frames` does."""
        for frame in self.frames(units=units, sensor=sensor):
            yield frame if isinstance(frame, BadView) else frame_view(frame)


ViewSource = ViewFile | Recording


def find_views(inputs: Sequence[str | os.PathLike[str]]) -> list[ViewSource]:
    """
    Return where the views are, in the order named and in natural order within a folder.

    Parameters
    ----------
    inputs : sequence of paths
        Folders (with or without `views/` inside), view files, recordings (.mcap, .bag, .db3, or
        a rosbag2 folder).

    Returns
    -------
    list of ViewFile or Recording
        Each yields its views when asked; nothing is read yet. A file named twice comes once.

    Raises
    ------
    InputError
        If a path does not exist, a folder cannot be read or holds no view, a file is of an
        unknown kind, or a name is no text.
    """
    if not inputs:
        raise InputError('no input named')
    paths = [path for name in inputs for path in _expand(Path(name))]
    for path in paths:
        _check_name(path)
    unique = list({path.resolve(): path for path in paths}.values())
    names = _distinct_names(unique)
    return [
        Recording(path) if is_recording(path) or is_rosbag_folder(path) else ViewFile(path, name)
        for path, name in zip(unique, names, strict=True)
    ]


def _check_name(path: Path) -> None:
    """Refuse a name that no result could hold: views are told apart by it."""
    try:
        os.fspath(path).encode('utf-8')
    except UnicodeEncodeError:
        raise InputError(f'{os.fsencode(path)!r}: the name is not UTF-8; rename it') from None


def _distinct_names(paths: Sequence[Path]) -> list[str]:
    """Return the shortest ends of the paths that are distinct, `views` folders left out."""
    parts = [[part for part in path.resolve().parts if part != 'views'] for path in paths]
    names = [part[-1] for part in parts]
    for length in range(2, max(map(len, parts), default=0) + 1):
        shared = Counter(names)
        for k, part in enumerate(parts):
            if shared[names[k]] > 1:
                names[k] = '/'.join(part[-length:])
    distinct = len(set(names)) == len(names)
    return names if distinct else [str(path) for path in paths]


def _expand(path: Path) -> list[Path]:
    try:
        is_folder, exists = path.is_dir(), path.exists()
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    if is_folder:
        return [path] if is_rosbag_folder(path) else _expand_folder(path)
    if not exists:
        raise InputError(f'{path}: no such file or folder')
    if kind_of(path) is None and not is_recording(path):
        known = ', '.join(sorted(VIEW_SUFFIXES | RECORDING_SUFFIXES))
        raise InputError(f'{path}: no view file, its suffix is none of {known}')
    return [path]


def _expand_folder(folder: Path) -> list[Path]:
    found = [path for path in list_files(folder) if kind_of(path) or is_recording(path)]
    if not found:
        raise InputError(f'{folder}: holds no view file and no recording')
    return found
