# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Frames made of messages that belong together, recorded or live."""

from dataclasses import replace
from typing import Any

from msg_adapters import depth_image, point_cloud2
from msg_adapters.attributes import attribute
import numpy as np

from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.types import Bytes, Floats32or64, SensorModel, Units
from ros_rops.recordings.cloud import mark_holes
from ros_rops.recordings.pairing import Entry
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.sensor import resolve_sensor
from ros_rops.recordings.topics import CLOUD, is_rectified, Plan
from ros_rops.recordings.units import resolve_units
from ros_rops.recordings.view_facts import ViewFacts, with_facts

Decoded = tuple[Floats32or64, Bytes | None, SensorModel | None, tuple[str, ...]]


def check_stated(units: str, sensor: str) -> None:
    """
    Refuse what is no choice of `read_frames`.

    Raises
    ------
    ParameterError
        If `units` or `sensor` is none of the choices.
    """
    resolve_units(np.zeros((0, 3)), units)
    resolve_sensor(np.zeros((0, 3)), None, sensor)


class FrameMaker:
    """
    Makes frames of messages; knows what came before.

    Parameters
    ----------
    plan : Plan
    units, sensor : str
        As for `read_frames`.
    rectified : bool or None
        Whether depth images are undistorted already; None takes it from their topic's name, as is
        ROS's custom (`image_rect...`).
    live : bool
        The messages are those of running sensors, not a recording's: so the frames say.

    Raises
    ------
    ParameterError
        If `units` or `sensor` is none of the choices.
    """

    def __init__(
        self, plan: Plan, units: str, sensor: str, *, rectified: bool | None = None,
        live: bool = False,
    ) -> None:
        check_stated(units, sensor)
        self._plan, self._sensor = plan, sensor
        self._units: Units = 'mm' if units == 'mm' else 'm'
        self._stated_units = units != 'auto'
        self._rectified, self._live = rectified, live
        self._stamps: dict[str, int] = {}
        self._notes = plan.notes

    def outcome(self, entry: Entry, name: str) -> Frame | BadView:
        """Return the frame, or why there is none."""
        channel = entry.raw.channel
        try:
            if entry.fault:
                raise InputError(entry.fault)
            points, colors, sensor, notes = (
                self._cloud(entry) if channel.kind == CLOUD else self._depth(entry))
            frame = Frame(
                name, points, colors, sensor, self._units, entry.stamp_ns, entry.frame_id,
                channel.topic, entry.raw.log_time_ns)
            if entry.facts:
                frame = self._with_facts(frame, entry.facts)
        except InputError as error:
            return BadView(name, f'{name}: {error}', entry.stamp_ns, entry.frame_id)
        notes = (
            *self._notes, *frame.notes, *notes, *self._order(channel.topic, entry.stamp_ns))
        self._notes = ()
        return replace(frame, notes=notes)

    def _with_facts(self, frame: Frame, facts: ViewFacts) -> Frame:
        """Return what was written, but for what the caller states otherwise."""
        try:
            written = with_facts(frame, replace(facts, name=frame.name))
        except OverflowError:
            raise InputError('its facts are of no sense') from None
        stated: dict[str, Any] = {}
        if self._stated_units:
            stated['units'] = self._units
        if self._sensor != 'auto':
            stated['sensor'] = frame.sensor
        view = written.view and replace(written.view, **stated)
        return replace(written, view=view, **stated)

    def _cloud(self, entry: Entry) -> Decoded:
        points, colors = point_cloud2.decode(entry.message)
        notes: tuple[str, ...] = ()
        if entry.facts is None:
            points, notes = mark_holes(points)
        stated = self._sensor
        if stated == 'auto' and points.ndim == 2 and entry.frame_id.endswith('optical_frame'):
            stated = 'pinhole'  # REP 103: such a frame is the camera's, z forward
        return points, colors, _stated_sensor(points, stated), notes

    def _depth(self, entry: Entry) -> Decoded:
        topic = entry.raw.channel.topic
        depth = depth_image.decode_depth(entry.message)
        if entry.info is None:
            raise InputError(self._lacking(topic))
        rectified = self._rectified
        if rectified is None:
            rectified = is_rectified(topic)
        points = depth_image.backproject(depth, entry.info.message, rectified=rectified)
        whole_mm = attribute(entry.message, 'encoding', 'Image') != '32FC1'
        if self._units == 'mm' and whole_mm:
            points *= np.float32(1000)
        colors, notes = _colors(entry)
        stated = 'pinhole' if self._sensor == 'auto' else self._sensor
        return points, colors, resolve_sensor(np.zeros((0, 3)), None, stated)[0], notes

    def _order(self, topic: str, stamp_ns: int) -> tuple[str, ...]:
        before = self._stamps.get(topic)
        self._stamps[topic] = stamp_ns
        if before is None or stamp_ns >= before:
            return ()
        return (f'its stamp lies {(before - stamp_ns) / 1e9:g} s before that of the frame before; '
                f'the order is that of {"arrival" if self._live else "the recording"}',)

    def _lacking(self, topic: str) -> str:
        where = self._plan.infos.get(topic)
        if self._live:
            return f'no CameraInfo came on {where} that can be read'
        if where:
            return f'its CameraInfo on {where} cannot be read'
        return ('the depth image has no CameraInfo: none on '
                f'{topic.rpartition("/")[0]}/camera_info')


def _colors(entry: Entry) -> tuple[Bytes | None, tuple[str, ...]]:
    if entry.color is None:
        return None, ()
    try:
        colors = depth_image.decode_color(entry.color.message)
    except InputError as error:
        return None, (f'its colour image is not used: {error}',)
    if colors.shape[:2] != (entry.message.height, entry.message.width):
        return None, ('its colour image is not used: it has another size',)
    return colors, ()


def _stated_sensor(points: Floats32or64, stated: str) -> SensorModel | None:
    if stated == 'auto':
        return None
    z = points[..., 2].reshape(-1)
    middle = np.zeros((1, 3))  # all that is asked is the side on which the points lie
    middle[0, 2] = np.sum(z, where=np.isfinite(z), dtype=np.float64)
    return resolve_sensor(middle, None, stated)[0]
