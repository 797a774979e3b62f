# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Scan folders to recordings and back, and recordings of other kinds to MCAP.

A view keeps its points, grid, colours, units, sensor, stamp, frame, support, name and reference
pose, bit by bit, both ways. A recording that came from a folder gives the same messages again.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import json
import os
from pathlib import Path
import re
from typing import Any

from ros_rops.core.errors import InputError
from ros_rops.recordings.cdr import string_of
from ros_rops.recordings.frames import frame_view, read_frames
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.messages import Cut
from ros_rops.recordings.poses import (
    parse_poses, Poses, poses_document, POSES_NAME, read_poses)
from ros_rops.recordings.reader import BadView, read_cloud, view_of
from ros_rops.recordings.simulate import poses_path
from ros_rops.recordings.sources import find_views, ViewFile
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.view_facts import ViewFacts
from ros_rops.recordings.writers import write_poses, write_view

POINTS = '/points'
PERIOD_NS = 1_000_000_000
"""Log time between views that have no stamp."""
POSES_TOPIC = '/reference_poses'
"""One std_msgs/String: a `reference_poses.json` by the names of the views."""
UNSAFE = re.compile(r'[^\w.@#+=-]+')

Tell = Callable[[str], None]


@dataclass(slots=True)
class Conversion:
    """What came of it: views written, and what could not be read, a sentence each."""

    views: int = 0
    faults: list[str] = field(default_factory=list)


def _silent(text: str) -> None:
    """Tell nobody."""


def to_recording(
    inputs: Sequence[str | os.PathLike[str]], path: str | os.PathLike[str], *,
    units: str = 'auto', sensor: str = 'auto', tell: Tell = _silent,
) -> Conversion:
    """
    Write view files, or the views of folders, as an MCAP recording.

    Parameters
    ----------
    inputs : sequence of paths
        As for `find_views`, but no recordings.
    path : path
        Of the recording.
    units, sensor : str
        As for `read_view`.
    tell : callable
        Told the name of each view.

    Raises
    ------
    InputError
        If an input does not exist, is a recording, or the file cannot be written.
    """
    sources = find_views(inputs)
    files = [source for source in sources if isinstance(source, ViewFile)]
    if len(files) < len(sources):
        raise InputError('recordings and view files cannot be converted together')
    done, poses = Conversion(), _FolderPoses()
    with create_mcap(path) as mcap:
        for number, file in enumerate(files):
            tell(file.name)
            try:
                cloud = read_cloud(file.path)
                view = view_of(file.path, cloud, units=units, sensor=sensor).view
            except InputError as error:
                done.faults.append(str(error))
                continue
            facts = cloud.facts or ViewFacts(POINTS, 'view', file.name)
            log_time = facts.log_time_ns
            if log_time is None:
                log_time = max(view.stamp_ns or 0, 0) or number * PERIOD_NS
            mcap.add_view(
                replace(view, name=facts.name), topic=facts.topic, log_time_ns=log_time)
            poses.add(file.path, facts.name)
            done.views += 1
        if poses.found:
            mcap.add_text(
                json.dumps(poses_document(poses.joined())), topic=POSES_TOPIC, log_time_ns=0,
                latched=True)
    return done


class _FolderPoses:
    """The reference poses beside view files, put to the names of the views."""

    def __init__(self) -> None:
        self.found: dict[Path, Poses] = {}
        self._views: list[tuple[Poses, str, str]] = []

    def add(self, path: Path, name: str) -> None:
        """Take the view called `name` that lies at `path`."""
        folder = path.resolve().parent
        folder = folder.parent if folder.name == 'views' else folder
        if folder not in self.found and (folder / POSES_NAME).is_file():
            self.found[folder] = read_poses(folder / POSES_NAME)
            if len({poses.units for poses in self.found.values()}) > 1:
                raise InputError(f'{folder / POSES_NAME}: its units are not those of the rest')
        if folder in self.found:
            self._views.append((self.found[folder], path.name, name))

    def joined(self) -> Poses:
        """Return the poses of all; what the folders say differently is left out."""
        every = list(self.found.values())
        references, notes = {p.reference for p in every}, {p.note for p in every}
        return Poses(
            every[0].units, references.pop() if len(references) == 1 else '',
            {name: p.T_world_view[file] for p, file, name in self._views
             if file in p.T_world_view},
            {name: p.objects[file] for p, file, name in self._views if file in p.objects},
            notes.pop() if len(notes) == 1 else '', every[0].centres if len(every) == 1 else {})


def to_folder(
    path: str | os.PathLike[str], folder: str | os.PathLike[str], *,
    topics: Sequence[str] = (), units: str = 'auto', sensor: str = 'auto', tell: Tell = _silent,
) -> Conversion:
    """
    Write the views of a recording as a scan folder: `views/*.ply`, `reference_poses.json`.

    Nothing is segmented: each view holds all measured points of its frame. Poses are those that
    the recording holds of its views, or those of the file `X_poses.json` beside `X.mcap`.

    Parameters
    ----------
    path : path
        Of the recording.
    folder : path
        Made if it does not exist.
    topics, units, sensor
        As for `read_frames`.
    tell : callable
        Told the name of each view.

    Raises
    ------
    InputError
        If the recording cannot be read, or the folder cannot be written.
    """
    path, inner = Path(path), Path(folder) / 'views'
    known = _known_poses(path)
    done, files = Conversion(), _FileNames()
    given: dict[str, str] = {}
    for frame in read_frames(path, topics=topics, units=units, sensor=sensor):
        tell(frame.name)
        if isinstance(frame, BadView):
            done.faults.append(frame.reason)
            continue
        if not done.views:
            _make(inner)
        view = frame_view(frame).view
        given[view.name] = files.of(view.name)
        write_view(inner / given[view.name], view, facts=ViewFacts(
            frame.topic, 'view', view.name, view.units, view.sensor, view.stamp_ns,
            view.frame_id, support=view.support, log_time_ns=frame.log_time_ns,
            beyond=view.beyond, T_fixed_sensor=view.T_fixed_sensor))
        done.views += 1
    if known is not None and done.views:
        write_poses(
            Path(folder) / POSES_NAME, _renamed(known.T_world_view, given), units=known.units,
            reference=known.reference, objects=_renamed(known.objects, given),
            centres=known.centres, note=known.note)
    return done


def _renamed(values: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return what is said of views by the names of their files, in the order of the views."""
    return {file: values[view] for view, file in names.items() if view in values}


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f'{folder}: cannot be made ({error.strerror or error})') from None


class _FileNames:
    """File names of views, each given once, whatever the views are called."""

    def __init__(self) -> None:
        self._given: set[str] = set()

    def of(self, name: str) -> str:
        """Return the name itself if it can be a PLY file's, else one that resembles it."""
        stem = name[:-4] if name.endswith('.ply') else name
        if not stem.isprintable() or stem != Path(stem).name or len(stem.encode()) > 200:
            stem = UNSAFE.sub('_', stem).strip('_')[:50] or 'view'
        count, result = 1, stem
        while result.lower() in self._given:
            count += 1
            result = f'{stem}_{count}'
        self._given.add(result.lower())
        return f'{result}.ply'


def _known_poses(path: Path) -> Poses | None:
    """Return the poses of a recording's views: its own, or those beside it."""
    if poses_path(path).is_file():
        return read_poses(poses_path(path))
    with open_storage(path) as storage:
        for raw in storage.messages(frozenset({POSES_TOPIC})):
            if not isinstance(raw, Cut):
                return parse_poses(string_of(bytes(raw.data)), f'{path}: {POSES_TOPIC}')
    return None
