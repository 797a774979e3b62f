# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Where objects stand, in metres.

Registration tells where the views of an object stand to each other, not where objects stand to
each other. What tells that is the sensor: in the frame of a view, every object that was seen in it
stands at inv(T_object_view). So each object has the place at which it was seen last. In the frame
of a sensor that place holds as long as the sensor and the object stand still; where the sensor's
poses in a fixed frame are known (prior.fixed_frame) it is told in that, and the sensor may move.
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
    """Return where each object stands as its newest view tells it, in that view's frame."""
    found = []
    for model in update.objects:
        name = model.views[-1].name
        place = _place(model, update, names, shown_frame(update.views[name], names))
        found += [place] if place else []
    return found


def places_in(update: Update, names: FrameNames, frame_id: str) -> list[Place]:
    """
    Return where each object stands in one frame.

    Each as its newest view tells it that tells it in this frame; an object without such a view
    is left out, since nothing says where it stands.
    """
    found = (_place(model, update, names, frame_id) for model in update.objects)
    return [place for place in found if place is not None]


def _place(
    model: ObjectModel, update: Update, names: FrameNames, frame_id: str
) -> Place | None:
    for placed in reversed(model.views):
        T_frame_view = pose_in(frame_id, update.views[placed.name], names)
        if T_frame_view is not None:
            T_view_object = inverse(in_metres(placed.T_object_view, update.units))
            return Place(model.id, placed.name, frame_id, T_frame_view @ T_view_object)
    return None


def pose_in(frame_id: str, view: RangeView, names: FrameNames) -> Floats | None:
    """Return where a view stands in a frame, (4, 4) in metres; None if nothing tells."""
    if frame_id == names.fixed and view.T_fixed_sensor is not None:
        return in_metres(view.T_fixed_sensor, view.units)
    return np.eye(4) if frame_id == names.of_sensor(view) else None


def shown_frame(view: RangeView, names: FrameNames) -> str:
    """Return the frame in which what a view saw is shown: the fixed one, or the sensor's."""
    return names.fixed if names.fixed and view.T_fixed_sensor is not None else (
        names.of_sensor(view))


def newest_frame(update: Update, names: FrameNames) -> str:
    """Return the frame in which the newest view is shown; '' without views."""
    view = update.views.get(update.newest)
    return '' if view is None else shown_frame(view, names)


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
