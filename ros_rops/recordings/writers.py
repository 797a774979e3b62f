# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Write assembled objects, views, poses and dataset folders."""

from collections.abc import Mapping, Sequence
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError, ParameterError, ShapeError
from ros_rops.core.types import Bytes, Floats, Ints, RangeView
from ros_rops.recordings.ply import FACTS_MARK
from ros_rops.recordings.poses import Poses, poses_document, POSES_NAME
from ros_rops.recordings.view_facts import encode_facts, ViewFacts


def write_object(
    path: str | os.PathLike[str],
    points: Floats,
    *,
    normals: Floats | None = None,
    colors: Bytes | None = None,
    view_ids: Ints | None = None,
) -> None:
    """
    Write the points of an assembled object as binary PLY, or as NPZ if the suffix says so.

    Parameters
    ----------
    path : path
        Ends in `.ply` or `.npz`.
    points : (N, 3) float64
        PLY: properties x, y, z (double).
    normals : (N, 3) float64 or None
        PLY: nx, ny, nz (float).
    colors : (N, 3) uint8 or None
        PLY: red, green, blue.
    view_ids : (N,) int32 or None
        The view that each point comes from; PLY: view_id (int).

    Raises
    ------
    ShapeError
        If the arrays do not go together.
    ParameterError
        If the suffix is another.
    InputError
        If the file cannot be written.
    """
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ShapeError(f'points: expected (N, 3), got {points.shape}')
    for name, array, shape in (
        ('normals', normals, points.shape), ('colors', colors, points.shape),
        ('view_ids', view_ids, points.shape[:1]),
    ):
        if array is not None and array.shape != shape:
            raise ShapeError(f'{name}: expected {shape}, got {array.shape}')
    kind = Path(path).suffix.lower()
    if kind == '.npz':
        extra = {'normals': normals, 'colors': colors, 'view_ids': view_ids}
        _save_npz(path, points, {k: v for k, v in extra.items() if v is not None})
    elif kind == '.ply':
        columns = _columns(points, colors)
        if normals is not None:
            columns |= {f'n{axis}': ('float', normals[:, k]) for k, axis in enumerate('xyz')}
        if view_ids is not None:
            columns['view_id'] = ('int', view_ids)
        _write(path, _ply(columns))
    else:
        raise ParameterError(f'path: {os.fspath(path)!r} ends neither in .ply nor in .npz')


def write_view(
    path: str | os.PathLike[str], view: RangeView, *, facts: ViewFacts | None = None
) -> None:
    """
    Write a view as binary PLY (with `range_grid` if organized), or as NPZ.

    Parameters
    ----------
    path : path
    view : RangeView
    facts : ViewFacts or None
        PLY only: written as a comment that our reader takes up, sensor, units and stamp with it.

    Raises
    ------
    ParameterError
        If the suffix is neither `.ply` nor `.npz`.
    InputError
        If the file cannot be written.
    """
    kind = Path(path).suffix.lower()
    if kind == '.npz':
        extra = {'grid': view.grid, 'colors': view.colors}
        _save_npz(path, view.points, {k: v for k, v in extra.items() if v is not None})
    elif kind == '.ply':
        _write(path, _ply(_columns(view.points, view.colors), view.grid, _comment(facts)))
    else:
        raise ParameterError(f'path: {os.fspath(path)!r} ends neither in .ply nor in .npz')


def write_poses(
    path: str | os.PathLike[str],
    T_world_view: Mapping[str, Floats],
    *,
    units: str,
    reference: str = 'exact',
    objects: Mapping[str, str] | None = None,
    centres: Mapping[str, Floats] | None = None,
    note: str = '',
) -> None:
    """
    Write poses in the form of `reference_poses.json`.

    Parameters
    ----------
    path : path
    T_world_view : mapping of str to (4, 4) float64
        By view name.
    units : {'m', 'mm'}
    reference : {'published', 'derived', 'exact'}
    objects : mapping of str to str, or None
        The object that each view shows.
    centres : mapping of str to (3,) float64, or None
        Where the views show several objects at once: the middle of each, in the world.
    note : str
        Where the poses come from.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    content = poses_document(Poses(
        units, reference, dict(T_world_view), dict(objects or {}), note, dict(centres or {})))
    _write(path, (json.dumps(content, indent=1) + '\n').encode())


def write_dataset(
    folder: str | os.PathLike[str],
    views: Sequence[RangeView],
    T_world_view: Mapping[str, Floats],
    *,
    units: str,
    reference: str = 'exact',
    objects: Mapping[str, str] | None = None,
) -> None:
    """
    Write a dataset folder: `views/` and `reference_poses.json`, as `read_dataset` reads it.

    Parameters
    ----------
    folder : path
        Made if it does not exist.
    views : sequence of RangeView
        A name without `.ply` or `.npz` gets `.ply`; so does its pose.
    T_world_view : mapping of str to (4, 4) float64
        By view name.
    units, reference, objects
        As for `write_poses`.

    Raises
    ------
    ParameterError
        If a view has no pose, or a name is no plain file name.
    InputError
        If a file cannot be written.
    """
    names = {view.name: _file_name(view.name) for view in views}
    missing = [name for name in names if name not in T_world_view]
    if missing:
        raise ParameterError(f'T_world_view: no pose of {missing[0]!r}')
    inner = Path(folder) / 'views'
    try:
        inner.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f'{inner}: cannot be made ({error.strerror or error})') from None
    for view in views:
        write_view(inner / names[view.name], view)
    poses = {names[name]: T_world_view[name] for name in names}
    shown = {names[n]: shown for n, shown in (objects or {}).items() if n in names}
    write_poses(Path(folder) / POSES_NAME, poses, units=units, reference=reference, objects=shown)


def _file_name(name: str) -> str:
    if not name or name != Path(name).name:
        raise ParameterError(f'views: {name!r} is no plain file name')
    return name if Path(name).suffix.lower() in ('.ply', '.npz') else f'{name}.ply'


Columns = dict[str, tuple[str, NDArray]]
PLY_DTYPES = {'double': '<f8', 'float': '<f4', 'uchar': 'u1', 'int': '<i4'}


def _columns(points: Floats, colors: Bytes | None) -> Columns:
    columns: Columns = {axis: ('double', points[:, k]) for k, axis in enumerate('xyz')}
    if colors is not None:
        columns |= {c: ('uchar', colors[:, k]) for k, c in enumerate(('red', 'green', 'blue'))}
    return columns


def _comment(facts: ViewFacts | None) -> str:
    if facts is None:
        return ''
    # A name must not end the header; in JSON the escape is the same character.
    text = encode_facts(facts).decode().replace('end_header', 'end\\u005fheader')
    return f'{FACTS_MARK} {text}'


def _ply(columns: Columns, grid: Ints | None = None, comment: str = '') -> bytes:
    count = len(columns['x'][1])
    rows = np.empty(count, np.dtype([(n, PLY_DTYPES[kind]) for n, (kind, _) in columns.items()]))
    for name, (_, values) in columns.items():
        rows[name] = values
    lines = ['ply', 'format binary_little_endian 1.0']
    if comment:
        lines.append(f'comment {comment}')
    if grid is not None:
        lines += [f'obj_info num_cols {grid.shape[1]}', f'obj_info num_rows {grid.shape[0]}']
    lines.append(f'element vertex {count}')
    lines += [f'property {kind} {name}' for name, (kind, _) in columns.items()]
    body = rows.tobytes()
    if grid is not None:
        lines += [f'element range_grid {grid.size}', 'property list uchar int vertex_indices']
        body += _grid_lists(grid)
    return '\n'.join([*lines, 'end_header', '']).encode() + body


def _grid_lists(grid: Ints) -> bytes:
    """One byte 0 per hole; a byte 1 and the index otherwise."""
    cells = grid.reshape(-1)
    some = cells >= 0
    ends = np.cumsum(np.where(some, 5, 1))
    out = np.zeros(int(ends[-1]) if len(ends) else 0, np.uint8)
    starts = ends[some] - 5
    out[starts] = 1
    out[starts[:, None] + np.arange(1, 5)] = (
        cells[some].astype('<i4').view(np.uint8).reshape(-1, 4))
    return out.tobytes()


def _save_npz(
    path: str | os.PathLike[str], points: Floats, extra: Mapping[str, Any]
) -> None:
    try:
        np.savez_compressed(path, points=points, **extra)
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None


def _write(path: str | os.PathLike[str], data: bytes) -> None:
    try:
        Path(path).write_bytes(data)
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from None
