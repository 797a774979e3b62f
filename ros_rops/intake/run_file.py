# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
`run.json`: what a run was asked to do, so that it can be gone on with after a crash.

It is written before the work begins and replaced as a whole, never changed in place.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
import hashlib
import json
from pathlib import Path
from typing import Any

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.recordings.atomic import replace_file
from ros_rops.recordings.sources import Recording, ViewFile, ViewSource

RUN_NAME = 'run.json'
FORMAT = 1
STATES = ('running', 'partial', 'finished')
ENDS = 1 << 20
"""Bytes at either end of an input that are looked at to see whether it is the same."""


@dataclass(frozen=True, slots=True)
class Stamp:
    """
    An input as it was when the run began.

    Parameters
    ----------
    kind : {'view', 'recording'}
    path : str
        Absolute.
    name : str
        The view's name; empty for a recording.
    size : int
        In bytes; of a folder, the sum.
    digest : str
        SHA-256 of the size and of the first and last megabyte of every file.
    topics : tuple of str
        Of a recording, as `--topic` says; empty: as `read_frames` chooses.
    """

    kind: str
    path: str
    name: str
    size: int
    digest: str
    topics: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RunFile:
    """
    The content of `run.json`.

    Parameters
    ----------
    inputs : tuple of str
        As named in the command.
    sources : tuple of Stamp
        Every input, in order.
    units : str
        As `--units` says.
    picture : bool
        Whether picture.png is drawn.
    journal : bool
        Whether a journal is kept.
    background : Stamp or None
        The recording whose first frame shows the station without an object.
    parameters : mapping
        All, by dotted name.
    version : str
        Of ros_rops.
    state : {'running', 'partial', 'finished'}
        'partial': its results are of a part of the input.
    station : mapping
        Of a run of the station's node, the node's own parameters by name: such a run has no
        inputs but what its journal holds. Empty for others.
    models, report : bool
        Whether models are made, and report.html is written, when the poses are.
    """

    inputs: tuple[str, ...]
    sources: tuple[Stamp, ...]
    units: str = 'auto'
    picture: bool = True
    journal: bool = True
    background: Stamp | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    version: str = ''
    state: str = 'running'
    station: Mapping[str, Any] = field(default_factory=dict)
    models: bool = True
    report: bool = True

    @property
    def config(self) -> Config:
        """Return the parameters."""
        return Config.from_flat(self.parameters)


def stamp(source: ViewSource) -> Stamp:
    """Return what tells an input from another; of one that cannot be read, an empty digest."""
    path = source.path.resolve()
    try:
        size, digest = _identity(path)
    except OSError:
        size, digest = 0, ''  # reading it will say why
    if isinstance(source, ViewFile):
        return Stamp('view', str(path), source.name, size, digest)
    return Stamp('recording', str(path), '', size, digest, source.topics)


def _identity(path: Path) -> tuple[int, str]:
    digest, total = hashlib.sha256(), 0
    for part in _parts(path):
        size = part.stat().st_size
        total += size
        digest.update(f'{part.relative_to(path).as_posix()} {size}\n'.encode())
        digest.update(_ends(part, size))
    return total, digest.hexdigest()


def _parts(path: Path) -> Iterator[Path]:
    if path.is_dir():
        yield from sorted(part for part in path.rglob('*') if part.is_file())
    else:
        yield path


def _ends(path: Path, size: int) -> bytes:
    with path.open('rb') as stream:
        head = stream.read(ENDS)
        stream.seek(max(len(head), size - ENDS))
        return head + stream.read(ENDS)


def source_of(stamped: Stamp) -> ViewSource:
    """Return the input that a stamp was made of."""
    path = Path(stamped.path)
    if stamped.kind == 'view':
        return ViewFile(path, stamped.name)
    return Recording(path, stamped.topics)


def what_changed(stamped: Stamp) -> str:
    """Return what became of an input since it was stamped; empty if it is as it was."""
    if not Path(stamped.path).exists():
        return 'is gone'
    return '' if stamp(source_of(stamped)) == stamped else 'has changed'


def write_run_file(folder: Path, run_file: RunFile) -> None:
    """
    Write `run.json`, as a whole or not at all.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    text = json.dumps({'format': FORMAT, **asdict(run_file)}, indent=1, ensure_ascii=False)
    try:
        replace_file(folder / RUN_NAME, text + '\n')
    except OSError as error:
        raise InputError(
            f'{folder / RUN_NAME}: cannot be written ({error.strerror or error})') from None


def read_run_file(folder: Path) -> RunFile:
    """
    Read `run.json`.

    Raises
    ------
    InputError
        If it is not there or is none; the text says which.
    """
    path = folder / RUN_NAME
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
    except OSError as error:
        raise InputError(
            f'{path}: cannot be read ({error.strerror or error}); is it a run folder?') from None
    except ValueError as error:
        raise InputError(f'{path}: is not JSON ({error})') from None
    try:
        return _run_file(content)
    except (KeyError, TypeError, ValueError, ParameterError) as error:
        raise InputError(f'{path}: is not the run.json of a run ({error})') from None


def _run_file(content: Mapping[str, Any]) -> RunFile:
    if content['format'] != FORMAT or content['state'] not in STATES:
        raise ValueError(f'format {content["format"]!r}, state {content["state"]!r}')
    found = RunFile(
        _texts(content['inputs']), tuple(map(_stamp_of, content['sources'])),
        str(content['units']), bool(content['picture']),
        bool(content['journal']),
        None if content['background'] is None else _stamp_of(content['background']),
        dict(content['parameters']), str(content['version']), str(content['state']),
        dict(content.get('station', {})), bool(content.get('models', True)),
        bool(content.get('report', True)))
    Config.from_flat(found.parameters)
    return found


def _stamp_of(content: Mapping[str, Any]) -> Stamp:
    return Stamp(**{**content, 'topics': _texts(content['topics'])})


def _texts(values: Sequence[object]) -> tuple[str, ...]:
    return tuple(map(str, values))
