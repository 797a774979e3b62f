# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Where objects stand before the sensor, in metres.

Registration tells where the views of an object stand to each other, not where objects stand to
each other. What tells that is the sensor: in the frame of a view, every object that was seen in it
stands at inv(T_object_view). So each object has the place at which it was seen last, which is
where it still is if neither it nor the sensor has moved since.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ros_rops.core.types import Floats, RangeView, Units
from ros_rops.live.words import Update
from ros_rops.pipeline.reports import ObjectModel

NO_FRAME = 'sensor'
"""Stands, with the prefix, for the frame of a sensor that names none."""


@dataclass(frozen=True, slots=True)
class Place:
    """
    Where an object was seen last.

    Parameters
    ----------
    object_id : int
    view : str
        Name of the view that tells it.
    frame_id : str
    T_frame_object : (4, 4) float64
        In metres.
    """

    object_id: int
    view: str
    frame_id: str
    T_frame_object: Floats


@dataclass(frozen=True, slots=True)
class FrameNames:
    """
    Names of frames.

    Parameters
    ----------
    prefix : str
        Stands before all names that are ours.
    fixed : str
        The frame that `RangeView.T_fixed_sensor` is in (parameter prior.fixed_frame).
    """

    prefix: str = ''
    fixed: str = ''

    def of_object(self, object_id: int) -> str:
        """Return the frame of an object's model."""
        return f'{self.prefix}object_{object_id}'

    def of_view(self, number: int) -> str:
        """Return the frame of a view: its sensor's as it stood to the object then."""
        return f'{self.prefix}view_{number}'

    def of_sensor(self, view: RangeView) -> str:
        """Return the frame of the sensor that took a view, as the message said."""
        return view.frame_id.removeprefix('/') or f'{self.prefix}{NO_FRAME}'


def last_places(update: Update, names: FrameNames) -> list[Place]:
    """
    Return where each object stands, as its newest view tells it.

    In the fixed frame, where there is one and the sensor's pose in it is known: the sensor may
    move on while the object stays. Else in the frame of the sensor that took the view.
    """
    found = []
    for model in update.objects:
        name, T_view_object = _newest(model, update)
        view, T_fixed_view = update.views[name], _in_fixed(update, name)
        if names.fixed and T_fixed_view is not None:
            place = Place(model.id, name, names.fixed, T_fixed_view @ T_view_object)
        else:
            place = Place(model.id, name, names.of_sensor(view), T_view_object)
        found.append(place)
    return found


def places_before(update: Update, names: FrameNames, frame_id: str) -> list[Place]:
    """
    Return where each object stands before the sensor `frame_id` as it stood at its newest view.

    As the object's newest view from there tells it; where both views have a pose in the fixed
    frame, by these and by the object's newest view of any sensor. An object that neither tells
    of is left out: nothing says where it stands.
    """
    fixed_sensor = next((
        _in_fixed(update, report.name) for report in reversed(update.reports)
        if names.of_sensor(update.views[report.name]) == frame_id), None)
    found = []
    for model in update.objects:
        place = _carried(model, update, frame_id, fixed_sensor) or _seen(
            model, update, names, frame_id)
        if place is not None:
            found.append(place)
    return found


def _carried(
    model: ObjectModel, update: Update, frame_id: str, T_fixed_sensor: Floats | None
) -> Place | None:
    name, T_view_object = _newest(model, update)
    T_fixed_view = _in_fixed(update, name)
    if T_fixed_sensor is None or T_fixed_view is None:
        return None
    return Place(model.id, name, frame_id, inverse(T_fixed_sensor) @ T_fixed_view @ T_view_object)


def _seen(
    model: ObjectModel, update: Update, names: FrameNames, frame_id: str
) -> Place | None:
    for placed in reversed(model.views):
        if names.of_sensor(update.views[placed.name]) == frame_id:
            T = in_metres(placed.T_object_view, update.units)
            return Place(model.id, placed.name, frame_id, inverse(T))
    return None


def _newest(model: ObjectModel, update: Update) -> tuple[str, Floats]:
    """Return the name of an object's newest view, and T_view_object in metres."""
    placed = model.views[-1]
    return placed.name, inverse(in_metres(placed.T_object_view, update.units))


def _in_fixed(update: Update, name: str) -> Floats | None:
    T = update.views[name].T_fixed_sensor
    return None if T is None else in_metres(T, update.units)


def newest_frame(update: Update, names: FrameNames) -> str:
    """Return the frame of the sensor that took the newest view; '' without views."""
    view = update.views.get(update.newest)
    return '' if view is None else names.of_sensor(view)


def poses(update: Update) -> Mapping[int, Mapping[str, Floats]]:
    """Return T_object_view (4, 4) in metres by object and name of view."""
    return {
        model.id: {
            placed.name: in_metres(placed.T_object_view, update.units) for placed in model.views}
        for model in update.objects}


def in_metres(transform: Floats, units: Units) -> Floats:
    """Return a rigid transform (4, 4) whose lengths were in `units`."""
    T = np.array(transform, np.float64)
    T[:3, 3] *= metres(units)
    return T


def metres(units: Units) -> float:
    """Return what a length of 1 is in metres; of unknown units, 1."""
    return 0.001 if units == 'mm' else 1.0


def inverse(transform: Floats) -> Floats:
    """Return the inverse of a rigid transform (4, 4)."""
    T = np.eye(4)
    T[:3, :3] = transform[:3, :3].T
    T[:3, 3] = -T[:3, :3] @ transform[:3, 3]
    return T
