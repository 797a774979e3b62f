# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The files of a run folder as the report reads them: whatever is missing is told, not raised."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import json
import math
from pathlib import Path
from typing import Any

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.pipeline.parameters import load_config
from ros_rops.reporting.report_names import short_names

Document = Mapping[str, Any]

OPTIONAL = ('metrics', 'trace', 'frames', 'run', 'quality')


@dataclass(frozen=True, slots=True)
class RunFiles:
    """
    What a run folder says.

    Parameters
    ----------
    folder : Path
    poses : mapping
        Of `poses.json`.
    metrics, trace, frames, run, quality : mapping
        Of the other files; empty where one is missing.
    config : Config or None
        Of `config.yaml`.
    picture : bytes
        `picture.png`; empty if there is none.
    missing : mapping of str to str
        File name to why it is not used.
    """

    folder: Path
    poses: Document
    metrics: Document
    trace: Document
    frames: Document
    run: Document
    quality: Document
    config: Config | None
    picture: bytes
    missing: Mapping[str, str] = field(default_factory=dict)

    @property
    def units(self) -> str:
        """Return the units of everything in the folder."""
        return str(self.poses.get('units') or 'unknown')

    @property
    def views(self) -> Sequence[Document]:
        """Return what `poses.json` says of every view, in the run's order."""
        views: Sequence[Document] = self.poses['views']
        return views

    @property
    def numbers(self) -> Mapping[str, int]:
        """Return each view's place in the run's order: the `view_id` of its points."""
        return {str(view['name']): number for number, view in enumerate(self.views)}

    @property
    def shown(self) -> Mapping[str, str]:
        """Return each view's name as it is shown: long ones shortened."""
        names = tuple(str(view['name']) for view in self.views)
        return dict(zip(names, short_names(names), strict=True))

    @property
    def left_out(self) -> Mapping[str, str]:
        """Return the views that have a place but are left out of their model, and why."""
        found: dict[str, str] = {}
        for item in items_of(self.quality, 'objects'):
            flags = {str(view.get('name')): view.get('flags') for view in items_of(item, 'views')}
            for name, why in _left_out(item):
                said = flags.get(name)
                listed = '; '.join(map(str, said)) if isinstance(said, list) else ''
                found[name] = why or listed or 'what it saw contradicts what the others saw'
        return {name: why for name, why in found.items() if name in self.numbers}

    def quality_of(self, object_id: int) -> Document:
        """Return what `quality.json` says of an object; empty if it says nothing."""
        return next((item for item in items_of(self.quality, 'objects')
                     if item.get('id') == object_id), {})


def read_run_folder(folder: Path) -> RunFiles:
    """
    Read a run folder.

    Raises
    ------
    InputError
        If it has no sound `poses.json`: then it is no run folder.
    """
    poses = _poses(folder / 'poses.json')
    missing: dict[str, str] = {}
    documents = {name: _optional(folder / f'{name}.json', missing) for name in OPTIONAL}
    return RunFiles(
        folder, poses, config=_config(folder / 'config.yaml', missing),
        picture=_picture(folder / 'picture.png', missing), missing=missing, **documents)


def items_of(document: Document, *keys: str) -> list[Document]:
    """Return the mappings in a list somewhere in a document; none if there is no such list."""
    found = get(document, *keys)
    if not isinstance(found, (list, tuple)):
        return []
    return [item for item in found if isinstance(item, Mapping)]


def get(document: Any, *keys: str) -> Any:
    """Return what lies at a path of keys; None where the document does not go as far."""
    for key in keys:
        if not isinstance(document, Mapping):
            return None
        document = document.get(key)
    return document


def _left_out(item: Document) -> list[tuple[str, str]]:
    """Return the names of the views left out of an object's model, and why where it is told."""
    told = item.get('left_out')
    if told is None:
        told = get(item, 'cloud', 'left_out')
    if isinstance(told, str):
        told = told.split(', ')
    if not isinstance(told, list):
        return []
    return [
        (str(one.get('name')), str(one.get('reason') or '')) if isinstance(one, Mapping)
        else (str(one), '') for one in told]


def _poses(path: Path) -> Document:
    try:
        poses = _parsed(path)
        for item in poses['objects']:
            int(item['id']), [str(view['name']) for view in item['views']]
        for view in poses['views']:
            str(view['name']), str(view['status']), view.get('reason')
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f'{path}: is not the poses.json of a run ({error!r})') from None
    return dict(poses)


def _parsed(path: Path) -> Any:
    """Return what a JSON file says; None for numbers that no page or script can do with."""
    return json.loads(
        path.read_text(encoding='utf-8'), parse_constant=lambda name: None,
        parse_int=_bounded, parse_float=_bounded)


def _bounded(word: str) -> int | float | None:
    value = float(word)
    if not math.isfinite(value):
        return None
    return int(word) if word.lstrip('-').isdigit() else value


def _optional(path: Path, missing: dict[str, str]) -> Document:
    try:
        document = _parsed(path)
    except FileNotFoundError:
        missing[path.name] = 'is not in the run folder'
        return {}
    except OSError as error:
        missing[path.name] = f'cannot be read ({error.strerror or error})'
        return {}
    except (ValueError, RecursionError) as error:
        missing[path.name] = f'is no JSON ({error})'
        return {}
    if not isinstance(document, Mapping):
        missing[path.name] = f'holds no object but {type(document).__name__}'
        return {}
    return document


def _config(path: Path, missing: dict[str, str]) -> Config | None:
    if not path.exists():
        missing[path.name] = 'is not in the run folder'
        return None
    try:
        return load_config(path)
    except ParameterError as error:
        missing[path.name] = str(error).removeprefix(f'{path}: ')
        return None


def _picture(path: Path, missing: dict[str, str]) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        missing[path.name] = ('is not in the run folder' if isinstance(error, FileNotFoundError)
                              else f'cannot be read ({error.strerror or error})')
        return b''
