# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The second half of a run folder: models and their quality, made from what the first half says.

Views and `poses.json` are all that is needed, so that models can be made again at any time, and
are the same then. Nothing here touches `poses.json`.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
import json
from pathlib import Path
import resource
import shutil
import time
from typing import Any

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.errors import RopsError
from ros_rops.core.groups_model import formats_of
from ros_rops.core.types import Floats, RangeView
from ros_rops.modelling.model import build_model, Model
from ros_rops.modelling.posed import pose_views
from ros_rops.reporting.json_file import write_json
from ros_rops.reporting.model_files import files_of, write_model
from ros_rops.reporting.poses import plain

QUALITY = 'quality.json'
SCRATCH = '.models'
"""Below the run folder: files that are not whole yet."""
# What `quality.json` says of an object of which nothing is known.
UNKNOWN: Mapping[str, Any] = {
    'id': 0, 'mesh_resolution': None, 'views': [], 'worst_views': [], 'left_out': [], 'edges': [],
    'loops': None, 'coverage': None, 'surface': None, 'cloud': None, 'summary': '', 'notes': []}
UNKNOWN_VIEW: Mapping[str, Any] = {
    'residual': None, 'confirmed': None, 'contradicted': None, 'alone': None,
    'least_constrained': None, 'flags': [], 'left_out': False}


@dataclass(frozen=True, slots=True)
class ModelTask:
    """
    What models are made of; nothing in it changes any more.

    Parameters
    ----------
    document : mapping
        The content of `poses.json`.
    views : mapping of str to RangeView
        Those of its objects by name, in its units.
    config : Config
    threads : int
    """

    document: Mapping[str, Any]
    views: Mapping[str, RangeView]
    config: Config
    threads: int = 0


@dataclass(frozen=True, slots=True)
class Made:
    """
    What became of a task.

    Parameters
    ----------
    objects : mapping of int to tuple of str
        By object, the names of the files written.
    notes : tuple of str
        What could not be made, and why.
    """

    objects: Mapping[int, tuple[str, ...]]
    notes: tuple[str, ...]


def make_models(
    folder: Path, task: ModelTask, *, only: Collection[int] = (),
    say: Callable[[str], None] | None = None,
) -> Made:
    """
    Make the models of a run and write them, and `quality.json`, into `folder`.

    One object after the other, so that memory is that of one. A model that cannot be made, or not
    written, does not touch the others.

    Parameters
    ----------
    folder : Path
    task : ModelTask
    only : collection of int
        These objects; the rest stays as it is. By default all.
    say : callable, optional
        Is told what is done next.

    Raises
    ------
    OSError
        If `quality.json` cannot be written.
    """
    scratch = folder / SCRATCH
    shutil.rmtree(scratch, ignore_errors=True)  # of a process that was killed
    workshop = _Workshop(folder, scratch, task, say or _nothing)
    try:
        for shape in task.document['objects']:
            if not only or shape['id'] in only:
                workshop.make(shape)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return workshop.finish(only)


def modelled_objects(folder: Path) -> frozenset[int]:
    """Return the objects of a run whose models were made of its poses, as `quality.json` says."""
    return frozenset(_earlier(folder))


class _Workshop:
    """Makes the objects of a task, and keeps what is said of them."""

    def __init__(
        self, folder: Path, scratch: Path, task: ModelTask, say: Callable[[str], None]
    ) -> None:
        self._folder, self._scratch, self._task, self._say = folder, scratch, task, say
        self._numbers = {view['name']: k for k, view in enumerate(task.document['views'])}
        self._entries: dict[int, dict[str, Any]] = {}
        self._files: dict[int, tuple[str, ...]] = {}
        self._seconds: dict[str, float] = {}

    def make(self, shape: Mapping[str, Any]) -> None:
        """Make the model of an object and write it."""
        number = int(shape['id'])
        try:
            model = self._build(shape)
            self._entries[number] = _entry(model)
            started = time.perf_counter()
            self._files[number] = self._write(model)
            self._spend({**model.seconds, 'write': time.perf_counter() - started})
        except Exception as error:  # whatever it is, the other objects are worth theirs
            entry = self._entries.setdefault(number, {**UNKNOWN, 'id': number, 'notes': []})
            entry['notes'] = [*entry['notes'], _told(error)]

    def finish(self, only: Collection[int]) -> Made:
        """Write what is said of the objects; return what became of them."""
        entries = dict(self._entries)
        if only:
            entries = {**_earlier(self._folder), **entries}
        units, shown = self._task.document['units'], self._task.document['objects']
        write_json(self._folder / QUALITY, plain({
            'units': units,
            'objects': [entries[shape['id']] for shape in shown if shape['id'] in entries]}))
        _note_seconds(self._folder, self._seconds)
        return Made(self._files, tuple(
            f'object {number}: {note}'
            for number, entry in self._entries.items() for note in entry['notes']))

    def _build(self, shape: Mapping[str, Any]) -> Model:
        task, number = self._task, int(shape['id'])
        poses = [(view['name'], np.array(view['T_object_view'], np.float64))
                 for view in shape['views']]
        started = time.perf_counter()
        views = pose_views(poses, task.views, self._numbers, task.config)
        self._spend({'mesh': time.perf_counter() - started})
        return build_model(
            number, views, task.config, turntable_axis=_axis(task.document, poses),
            threads=task.threads, say=lambda text: self._say(f'object {number}: {text}'))

    def _write(self, model: Model) -> tuple[str, ...]:
        """Write the files beside, then put them in the place of those of an earlier model."""
        self._say(f'object {model.object_id}: writing its files')
        self._scratch.mkdir(exist_ok=True)
        names = write_model(
            self._scratch, model, units=self._task.document['units'],
            formats=formats_of(self._task.config.model.formats))
        for path in files_of(self._folder, model.object_id):
            if path.name not in names:
                path.unlink()
        for name in names:
            (self._scratch / name).replace(self._folder / name)
        return tuple(names)

    def _spend(self, seconds: Mapping[str, float]) -> None:
        for name, value in seconds.items():
            self._seconds[name] = self._seconds.get(name, 0.0) + value


def _entry(model: Model) -> dict[str, Any]:
    said = dict(model.quality.document()) if model.quality is not None else {}
    if not said:
        said['views'] = [
            {**UNKNOWN_VIEW, 'name': view.name, 'number': view.number,
             'points': len(view.view.points)} for view in model.views]
        said['summary'] = '; '.join(model.notes)
    return {
        **UNKNOWN, **said, 'id': model.object_id, 'mesh_resolution': model.resolution or None,
        'surface': None if model.surface is None else dict(model.surface.facts),
        'cloud': None if model.cloud is None else dict(model.cloud.facts),
        'notes': list(model.notes)}


def _told(error: Exception) -> str:
    if isinstance(error, OSError):
        place = f'{Path(error.filename).name}: ' if error.filename else ''
        return f'not written: {place}{error.strerror or error}'
    kind = '' if isinstance(error, RopsError) else f' ({type(error).__name__})'
    return f'not made: {error}{kind}'


def _earlier(folder: Path) -> dict[int, dict[str, Any]]:
    """Return what `quality.json` said of objects, if it is there and sound."""
    try:
        content = json.loads((folder / QUALITY).read_text(encoding='utf-8'))
        return {int(entry['id']): entry for entry in content['objects']}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def _axis(document: Mapping[str, Any], poses: list[tuple[str, Floats]]) -> Floats | None:
    """Return the direction of the station's axis, if it was found, in an object's frame."""
    found = document.get('station', {}).get('axis_found')
    if not found:
        return None
    # The sensor stands still before it: every view knows it in the same place.
    axis: Floats = np.sum([T[:3, :3] @ found['direction'] for _, T in poses], axis=0)
    length = float(np.linalg.norm(axis))
    return axis / length if length > 0 else None


def _note_seconds(folder: Path, seconds: Mapping[str, float]) -> None:
    """Add to `metrics.json`, where there is one, how long the models took."""
    path = folder / 'metrics.json'
    try:
        metrics = json.loads(path.read_text(encoding='utf-8'))
        metrics['model_seconds'] = {**seconds, 'all': sum(seconds.values())}
        # In KiB, as Linux has it.
        metrics['model_peak_rss_mib'] = round(
            resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, 1)
        write_json(path, metrics)
    except (OSError, ValueError, TypeError):  # no run folder, or one that others wrote
        pass


def _nothing(text: str) -> None:
    pass
