# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What markers show: where each view was taken from, where objects are, what is not placed.

Everything is in the frame of the assembled cloud (`live.places`).
"""

from collections.abc import Iterator, Sequence

from msg_adapters.markers import Color, Label, Lines
import numpy as np
from numpy.typing import ArrayLike

from ros_rops.core.types import Floats, RangeView, Status
from ros_rops.live.places import FrameNames, in_metres, metres, Place, pose_in
from ros_rops.live.words import Update
from ros_rops.pipeline.reports import ObjectModel

AXES: tuple[Color, ...] = ((0.9, 0.1, 0.1), (0.1, 0.75, 0.1), (0.2, 0.35, 1.0))
# Tableau's ten, for objects.
OBJECTS: tuple[Color, ...] = (
    (0.12, 0.47, 0.71), (1.00, 0.50, 0.05), (0.17, 0.63, 0.17), (0.58, 0.40, 0.74),
    (0.55, 0.34, 0.29), (0.89, 0.47, 0.76), (0.74, 0.74, 0.13), (0.09, 0.75, 0.81))
WAITING: dict[Status, Color] = {
    Status.PENDING: (1.0, 0.8, 0.1), Status.AMBIGUOUS: (1.0, 0.45, 0.0),
    Status.REFUSED: (0.9, 0.1, 0.1)}
# Of the size of what was seen.
AXIS, LETTER, LINE = 0.25, 0.09, 0.006
# A sensor without an origin is drawn so many sizes before what it saw.
STAND_OFF = 2.0
LONGEST_REASON = 60
MOST_WAITING = 12
"""So many views that are not placed are listed; the last ones."""
SAMPLE = 1000
# Corners of a box that an edge joins: they differ in one bit.
_EDGES = [(a, a | 1 << k) for a in range(8) for k in range(3) if not a >> k & 1]


def scene(
    update: Update, places: Sequence[Place], names: FrameNames, frame_id: str
) -> list[Lines | Label]:
    """
    Return what to show.

    Parameters
    ----------
    update : Update
    places : sequence of Place
        Objects in the frame `frame_id` (`live.places.places_in`).
    names : FrameNames
    frame_id : str
        Views that are not placed are shown where their sensor saw them, if that is known in this
        frame.
    """
    size = _size(update)
    by_id = {place.object_id: place for place in places}
    marks: list[Lines | Label] = []
    for model in update.objects:
        if model.id not in by_id:
            continue
        T_frame_object, color = by_id[model.id].T_frame_object, OBJECTS[model.id % len(OBJECTS)]
        marks += _object(update, model, T_frame_object, size, names, color)
        for placed in model.views:
            T = T_frame_object @ in_metres(placed.T_object_view, update.units)
            marks += _placed(update, placed.name, T, size, names, color)
    return [*marks, *_waiting(update, size, names, frame_id)]


def _object(
    update: Update, model: ObjectModel, T: Floats, size: float, names: FrameNames, color: Color
) -> Iterator[Lines | Label]:
    newest, scale = model.views[-1], metres(update.units)
    view = update.views[newest.name]
    # Before the object, as its newest view saw it.
    at = _some(view).mean(axis=0) * scale - 0.7 * size * _forward(view)
    yield Lines('objects', model.id, T, *_axes(1.6 * AXIS * size), LINE * size)
    yield Label(
        'object_labels', model.id, _moved(T @ in_metres(newest.T_object_view, update.units), at),
        f'{names.of_object(model.id)}: {len(model.views)} views', 1.3 * LETTER * size, color)


def _placed(
    update: Update, name: str, T: Floats, size: float, names: FrameNames, color: Color
) -> Iterator[Lines | Label]:
    number, view, scale = update.numbers[name], update.views[name], metres(update.units)
    eye = T.copy()
    eye[:3, 3] = _moved(T, _eye(view, size / scale) * scale)
    ends, colors = _axes(AXIS * size)
    sides = _pyramid(_forward(view), AXIS * size)
    yield Lines(
        'views', number, eye, np.concatenate([ends, sides]),
        np.concatenate([colors, np.tile(color, (len(sides), 1))]), LINE * size)
    newest = ' (newest)' if name == update.newest else ''
    yield Label(
        'view_labels', number, _moved(eye, -AXIS * size * _forward(view)),
        f'{names.of_view(number)}: placed{newest}', LETTER * size, color)


def _waiting(
    update: Update, size: float, names: FrameNames, frame_id: str
) -> Iterator[Lines | Label]:
    """Show views without a pose: the box that they fill before their sensor, and why."""
    scale, row = metres(update.units), 0
    for report in reversed(update.reports):
        number, view = update.numbers[report.name], update.views[report.name]
        T = pose_in(frame_id, view, names)
        if report.status is Status.PLACED or T is None or not len(view.points):
            continue
        points, color = _some(view) * scale, WAITING[report.status]
        low, high = points.min(axis=0), points.max(axis=0)
        yield Lines('waiting', number, T, *_box(low, high, color), LINE * size)
        # One line below the other: such views stand in one place, mostly.
        at = (low + high) / 2
        at[1] = high[1] + (1.0 + 1.2 * row) * LETTER * size
        yield Label(
            'waiting_labels', number, _moved(T, at),
            f'{names.of_view(number)}: {report.status.value}: {_short(report.reason)}',
            LETTER * size, color)
        row += 1
        if row == MOST_WAITING:
            return


def _short(reason: str) -> str:
    return reason if len(reason) <= LONGEST_REASON else f'{reason[:LONGEST_REASON - 3]}...'


def _size(update: Update) -> float:
    """Return the median diagonal of the views in metres: how large all that is drawn is."""
    diagonals = [
        float(np.linalg.norm(np.ptp(_some(view), axis=0)))
        for view in update.views.values() if len(view.points)]
    return float(np.median(diagonals)) * metres(update.units) if diagonals else 1.0


def _some(view: RangeView) -> Floats:
    """Return enough of a view's points to tell where it is, and how large."""
    return view.points[::max(1, len(view.points) // SAMPLE)]


def _eye(view: RangeView, size: float) -> Floats:
    """Return where a view's sensor is, in the view's frame and units (3,)."""
    if view.sensor.kind == 'pinhole':
        return np.asarray(view.sensor.origin)
    eye: Floats = _some(view).mean(axis=0) - STAND_OFF * size * _forward(view)
    return eye


def _forward(view: RangeView) -> Floats:
    return np.asarray(view.sensor.direction, np.float64)


def _moved(T: Floats, point: ArrayLike) -> Floats:
    moved: Floats = T[:3, :3] @ np.asarray(point, np.float64) + T[:3, 3]
    return moved


def _axes(length: float) -> tuple[Floats, Floats]:
    """Return the ends (6, 3) of the axes of a frame, and their colours."""
    ends = np.zeros((6, 3))
    ends[1::2] = length * np.eye(3)
    return ends, np.repeat(np.array(AXES), 2, axis=0)


def _pyramid(forward: Floats, length: float) -> Floats:
    """Return the ends (16, 3) of the edges of a pyramid that looks `forward`."""
    right = np.cross(np.eye(3)[np.argmin(np.abs(forward))], forward)
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    corners = [
        length * (forward + 0.4 * x * right + 0.3 * y * down)
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    apex = np.zeros(3)
    return np.array(
        [end for k in range(4) for end in (apex, corners[k], corners[k], corners[k - 1])])


def _box(low: Floats, high: Floats, color: Color) -> tuple[Floats, Floats]:
    """Return the ends (24, 3) of the edges of a box, and their colours."""
    corners = np.array([[(high if a >> k & 1 else low)[k] for k in range(3)] for a in range(8)])
    ends = corners[np.array(_EDGES).reshape(-1)]
    return ends, np.tile(color, (len(ends), 1))
