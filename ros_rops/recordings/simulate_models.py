# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes made ready to be captured: upright, in metres, of the size asked for, painted."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from ros_rops.core.errors import InputError, ParameterError
from ros_rops.core.types import Bytes, Floats, Ints
from ros_rops.recordings.procedural import mesh_of, OBJECTS
from ros_rops.recordings.reader import read_mesh
from ros_rops.recordings.synthetic import Model
from ros_rops.recordings.units import resolve_units

PROCEDURAL = 'procedural:'
UPS = ('x', 'y', 'z', '-x', '-y', '-z')
TINTS = ((196, 120, 72), (96, 132, 168), (128, 156, 84), (168, 96, 132), (172, 160, 92))


def read_models(
    names: Sequence[str], *, up: str = 'z', size: float | None = None, units: str = 'auto',
    color: bool = False,
) -> list[Model]:
    """
    Read meshes for a simulated capture.

    Parameters
    ----------
    names : sequence of str
        PLY, OBJ or STL files, or `procedural:blob` and `procedural:bracket`.
    up : str
        The axis of the files that points up, one of `UPS`.
    size : float or None
        Longest side of each, in metres; None for the size in the file.
    units : {'auto', 'm', 'mm'}
        Of the files.
    color : bool
        Paint each in a tint of its own, striped.

    Returns
    -------
    list of Model
        In metres, z up, their names distinct.

    Raises
    ------
    InputError
        If a file cannot be read as a mesh, or has no extent.
    ParameterError
        If an option is none of its choices.
    """
    if up not in UPS:
        raise ParameterError(f'up: {up!r} is none of {", ".join(UPS)}')
    if size is not None and not 0 < size < np.inf:
        raise ParameterError(f'size: must be above 0, got {size}')
    models: list[Model] = []
    for number, name in enumerate(names):
        vertices, faces = _mesh(name, up, units, size)
        label = _distinct(Path(name.removeprefix(PROCEDURAL)).stem, [m.name for m in models])
        tint = TINTS[number % len(TINTS)]
        models.append(Model(
            vertices, faces, paint(vertices, tint) if color else None, label, 'm'))
    return models


def _mesh(name: str, up: str, units: str, size: float | None) -> tuple[Floats, Ints]:
    if name.startswith(PROCEDURAL):
        kind = name.removeprefix(PROCEDURAL)
        if kind not in OBJECTS:
            raise InputError(f'{name}: the procedural objects are {", ".join(OBJECTS)}')
        vertices, faces = _procedural(kind)
    else:
        vertices, faces = read_mesh(name)
        if not np.isfinite(vertices).all():
            raise InputError(f'{name}: has a vertex that is not finite')
        if resolve_units(vertices, units)[0] == 'mm':
            vertices = vertices * 0.001
        vertices = vertices @ _upright(up).T
    extent = float(np.ptp(vertices[faces.reshape(-1)], axis=0).max()) if len(faces) else 0.0
    if not extent > 0:
        raise InputError(f'{name}: holds no triangle, or one without an extent')
    return vertices * (size / extent if size is not None else 1.0), faces


@cache
def _procedural(kind: str) -> tuple[Floats, Ints]:
    return mesh_of(OBJECTS[kind]())


def _upright(up: str) -> Floats:
    """Return the rotation (3, 3) by which the axis `up` becomes z."""
    axis = 'xyz'.index(up[-1])
    rolled = np.roll(np.eye(3), axis - 2, axis=1)
    return np.diag([1.0, -1.0, -1.0]) @ rolled if up.startswith('-') else rolled


def _distinct(name: str, others: Sequence[str]) -> str:
    count, result = 1, name
    while result in others:
        count += 1
        result = f'{name}_{count}'
    return result


def paint(vertices: Floats, tint: tuple[int, int, int]) -> Bytes:
    """Return a tint with broad stripes, so that colour can be seen to be kept."""
    stripe = 0.85 + 0.15 * np.sign(np.sin(vertices @ np.array([190.0, 110.0, 60.0])))
    colors: Bytes = np.rint(stripe[:, None] * np.array(tint)).astype(np.uint8)
    return colors
