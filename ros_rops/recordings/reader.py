# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""One file to one `RangeView`."""

from collections.abc import Callable
from dataclasses import dataclass, replace
import os
from pathlib import Path

from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats, Ints, RangeView, SensorModel
from ros_rops.recordings import npz, obj, pcd, ply, stl, text
from ros_rops.recordings.cloud import Cloud, drop_holes, FormatError
from ros_rops.recordings.files import kind_of, read_bytes, TEXT_SUFFIXES, VIEW_SUFFIXES
from ros_rops.recordings.poses import stated_units
from ros_rops.recordings.sensor import resolve_sensor
from ros_rops.recordings.units import resolve_units
from ros_rops.recordings.view_facts import ViewFacts

PARSERS: dict[str, Callable[[bytes], Cloud]] = {
    '.ply': ply.parse,
    '.pcd': pcd.parse,
    '.npz': npz.parse,
    **dict.fromkeys(TEXT_SUFFIXES, text.parse),
}


NO_FACTS = ViewFacts('', 'view', '')


@dataclass(frozen=True, slots=True)
class NotedView:
    """A view and what had to be inferred to read it, one sentence a note."""

    view: RangeView
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class BadView:
    """
    A view that cannot be read, by the name it would have had, and a sentence why.

    `stamp_ns` and `frame_id` are its message's, 0 and '' where these are not known.
    """

    name: str
    reason: str
    stamp_ns: int = 0
    frame_id: str = ''


def read_view(
    path: str | os.PathLike[str], *, units: str = 'auto', sensor: str = 'auto'
) -> RangeView:
    """
    Read a range view from a PLY, PCD, NPZ or text file (text also as .gz).

    Parameters
    ----------
    path : path
        The suffix tells the kind, and the content must agree with it.
    units : {'auto', 'm', 'mm'}
        'auto' takes them from `reference_poses.json` beside the views, or from the extent.
    sensor : str
        'auto' infers it; 'pinhole', '+z', '-z', ..., 'unknown' state it (see `sensor`).

    Returns
    -------
    RangeView
        Named as the file; points in the file's units; NaN and infinities dropped, the grid kept.
        It may hold no point at all: whether that is enough is the engine's to say.

    Raises
    ------
    InputError
        If the file is missing, unreadable, empty, truncated, of an unknown kind or mislabelled,
        or the poses beside it are unsound.
    ParameterError
        If `units` or `sensor` is none of the choices.
    """
    return read_view_noted(path, units=units, sensor=sensor).view


def read_view_noted(
    path: str | os.PathLike[str], *, units: str = 'auto', sensor: str = 'auto'
) -> NotedView:
    """Read a view as `read_view` does, and say what was inferred."""
    return view_of(Path(path), read_cloud(path), units=units, sensor=sensor)


def read_cloud(path: str | os.PathLike[str]) -> Cloud:
    """Return what a view's file holds, before anything is inferred; errors as `read_view`."""
    path = Path(path)
    return _parse(path, read_bytes(path))


def view_of(path: Path, cloud: Cloud, *, units: str = 'auto', sensor: str = 'auto') -> NotedView:
    """Return the view of a file's cloud; parameters and errors as for `read_view`."""
    if units == 'auto' and cloud.facts is None:
        units = stated_units(path) or 'auto'
    noted = finish(path.name, cloud, units=units, sensor=sensor)
    return replace(noted, notes=tuple(f'{path.name}: {note}' for note in noted.notes))


def read_mesh(path: str | os.PathLike[str]) -> tuple[Floats, Ints]:
    """
    Read a triangle model from a PLY, OBJ or STL file: vertices (N, 3) and faces (F, 3).

    Raises
    ------
    InputError
        As `read_view`, and if the file has no triangles or other faces too.
    """
    path = Path(path)
    parsers = {'.obj': obj.parse_mesh, '.stl': stl.parse_mesh}
    parse = parsers.get(path.suffix.lower(), ply.parse_mesh)
    data = read_bytes(path)
    try:
        return parse(data)
    except FormatError as error:
        raise InputError(f'{path}: {error}') from None


def finish(
    name: str, cloud: Cloud, *, units: str = 'auto', sensor: str | SensorModel = 'auto'
) -> NotedView:
    """
    Make a view of what a parser found: holes dropped, units and sensor resolved.

    Parameters
    ----------
    name : str
    cloud : Cloud
    units : str
        As for `read_view`.
    sensor : str or SensorModel
        As for `read_view`, or known.

    Raises
    ------
    ParameterError
        If `units` or `sensor` is none of the choices.
    """
    return finish_clean(name, drop_holes(cloud), units=units, sensor=sensor)


def finish_clean(
    name: str, clean: Cloud, *, units: str = 'auto', sensor: str | SensorModel = 'auto',
    stamp_ns: int | None = None, frame_id: str = '',
) -> NotedView:
    """Do as `finish` with a cloud that has no holes; time and frame are those of no facts."""
    facts = clean.facts or replace(NO_FACTS, stamp_ns=stamp_ns, frame_id=frame_id)
    sensor = facts.sensor if facts.sensor and sensor == 'auto' else sensor
    known_units, about_units = (
        (facts.units, '') if clean.facts and units == 'auto'
        else resolve_units(clean.points, units))
    model, about_sensor = (sensor, '') if isinstance(sensor, SensorModel) else resolve_sensor(
        clean.points, clean.grid, sensor)
    view = RangeView(
        name, clean.points, clean.grid, model, clean.colors, known_units, facts.stamp_ns,
        facts.frame_id, facts.support, facts.beyond, facts.T_fixed_sensor)
    notes = (*clean.notes, about_units, about_sensor)
    return NotedView(view, tuple(note for note in notes if note))


def _parse(path: Path, data: bytes) -> Cloud:
    kind = kind_of(path)
    if kind is None:
        known = ', '.join(sorted(VIEW_SUFFIXES))
        raise InputError(f'{path}: no view file, its suffix is none of {known}')
    try:
        return PARSERS[kind](data)
    except FormatError as error:
        raise InputError(f'{path}: {error}{_resembles(kind, data)}') from None


def _resembles(kind: str, data: bytes) -> str:
    """Say which other kind the bytes look like, if any."""
    head = data[:200]
    guesses = {
        '.ply': head.startswith((b'ply\n', b'ply\r')),
        '.pcd': b'.PCD' in head or b'FIELDS ' in head,
        '.npz': head.startswith(b'PK\x03\x04'),
    }
    for suffix, fits in guesses.items():
        if fits and suffix != kind:
            return f'; it looks like a {suffix} file'
    return ''
