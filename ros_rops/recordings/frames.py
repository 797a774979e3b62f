# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a recording of any kind, one after the other, in the order of log time."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from msg_adapters import depth_image, point_cloud2
from msg_adapters.attributes import attribute
import numpy as np

from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.types import Bytes, Floats32or64, SensorModel, Units
from ros_rops.recordings.cloud import mark_holes, measured_cloud
from ros_rops.recordings.messages import Cut, Decoder, Storage
from ros_rops.recordings.pairing import Entry, Pairing
from ros_rops.recordings.reader import BadView, finish_clean, NotedView
from ros_rops.recordings.sensor import resolve_sensor
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.topics import choose, CLOUD, Plan
from ros_rops.recordings.units import resolve_units
from ros_rops.recordings.view_facts import ViewFacts, with_facts


def read_frames(
    path: Path, *, topics: Sequence[str] = (), units: str = 'auto', sensor: str = 'auto'
) -> Iterator[Frame | BadView]:
    """
    Yield the frames of a recording, named '<topic>@<log time in ns>', as they are read.

    A message that cannot be read is yielded as a `BadView` and the rest follows; so is the place
    where a recording breaks off, after all that could be read of it.

    Parameters
    ----------
    path : Path
        A .mcap, .bag or .db3 file or a rosbag2 folder.
    topics : sequence of str
        Of point clouds and depth images; none: all point clouds, or where there is none all
        depth images.
    units : {'auto', 'm', 'mm'}
        Of the numbers in point clouds and 32FC1 images, and of the frames; 'auto' follows REP 103
        and 118: metres. 16UC1 always counts millimetres.
    sensor : str
        As for `read_view`; 'auto' leaves it to be inferred from the points, but for depth images
        and for unorganized points in an `*optical_frame`, which are seen from the frame's origin.

    Raises
    ------
    InputError
        If it cannot be read, is no recording, lacks a topic named or holds no frame.
    ParameterError
        If `units` or `sensor` is none of the choices.
    """
    _check_stated(units, sensor)
    with open_storage(path) as storage:
        yield from frames_of(storage, path, topics=topics, units=units, sensor=sensor)


def frames_of(
    storage: Storage, path: Path, *, topics: Sequence[str] = (), units: str = 'auto',
    sensor: str = 'auto',
) -> Iterator[Frame | BadView]:
    """Yield the frames of an open recording, called `path`; all else as `read_frames`."""
    _check_stated(units, sensor)
    decoder = Decoder()
    plan = _chosen(path, storage, topics, decoder)
    maker = _Maker(plan, units, sensor)
    pairing = Pairing(plan, decoder, _first_infos(storage, plan, decoder))
    cuts = []
    for item in storage.messages(plan.topics):
        if isinstance(item, Cut):
            cuts.append(item)
            continue
        yield from map(maker.outcome, pairing.add(item))
    yield from map(maker.outcome, pairing.rest())
    yield from (maker.cut(path, cut) for cut in cuts)


def _check_stated(units: str, sensor: str) -> None:
    resolve_units(np.zeros((0, 3)), units)
    resolve_sensor(np.zeros((0, 3)), None, sensor)


def count_frames(path: Path, topics: Sequence[str] = ()) -> int:
    """
    Return how many frames `read_frames` would find, those that cannot be decoded included.

    Raises
    ------
    InputError
        As `read_frames`.
    """
    with open_storage(path) as storage:
        plan = _chosen(path, storage, topics, Decoder())
        if plan.count is not None:
            return plan.count
        return sum(not isinstance(item, Cut) for item in storage.messages(plan.frames))


def frame_view(frame: Frame) -> NotedView:
    """Return all measured points of a frame as a view, nothing segmented."""
    if frame.view is not None:
        return NotedView(frame.view, tuple(f'{frame.name}: {note}' for note in frame.notes))
    noted = finish_clean(
        frame.name, measured_cloud(frame.points, frame.colors, frame.notes),
        units='auto' if frame.units == 'unknown' else frame.units, sensor=frame.sensor or 'auto',
        stamp_ns=frame.stamp_ns, frame_id=frame.frame_id)
    return NotedView(noted.view, tuple(f'{frame.name}: {note}' for note in noted.notes))


def _chosen(path: Path, storage: Storage, topics: Sequence[str], decoder: Decoder) -> Plan:
    try:
        return choose(storage, topics, decoder)
    except InputError as error:
        raise InputError(f'{path}: {error}') from None


def _first_infos(storage: Storage, plan: Plan, decoder: Decoder) -> dict[str, Any]:
    """Return the first CameraInfo of each topic: a latched one may have been recorded late."""
    found: dict[str, Any] = {}
    wanted = frozenset(plan.infos.values())
    for raw in storage.messages(wanted) if wanted else ():
        if isinstance(raw, Cut) or found.keys() == wanted:
            break
        try:
            found.setdefault(raw.channel.topic, decoder.decode(raw))
        except InputError:
            continue
    return found


class _Maker:
    """Makes frames of messages; knows what came before."""

    def __init__(self, plan: Plan, units: str, sensor: str) -> None:
        self._plan, self._sensor = plan, sensor
        self._units: Units = 'mm' if units == 'mm' else 'm'
        self._stated_units = units != 'auto'
        self._used: dict[str, int] = {}
        self._stamps: dict[str, int] = {}
        self._notes = plan.notes

    def outcome(self, entry: Entry) -> Frame | BadView:
        """Return the frame, or why there is none."""
        channel, time = entry.raw.channel, entry.raw.log_time_ns
        name = self._unique(entry.facts.name if entry.facts else f'{channel.topic}@{time}')
        try:
            if entry.fault:
                raise InputError(entry.fault)
            points, colors, sensor, notes = (
                self._cloud(entry) if channel.kind == CLOUD else self._depth(entry))
            frame = Frame(
                name, points, colors, sensor, self._units, entry.stamp_ns, entry.frame_id,
                channel.topic, time)
            if entry.facts:
                frame = self._with_facts(frame, entry.facts)
        except InputError as error:
            return BadView(name, f'{name}: {error}')
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

    def cut(self, path: Path, cut: Cut) -> BadView:
        """Return the place where the recording breaks off."""
        done = sum(self._used.values())
        return BadView(path.name, f'{path}: the recording is truncated or damaged after '
                       f'{done} {"view" if done == 1 else "views"} ({cut.reason})')

    def _cloud(
        self, entry: Entry
    ) -> tuple[Floats32or64, Bytes | None, SensorModel | None, tuple[str, ...]]:
        points, colors = point_cloud2.decode(entry.message)
        notes: tuple[str, ...] = ()
        if entry.facts is None:
            points, notes = mark_holes(points)
        stated = self._sensor
        if stated == 'auto' and points.ndim == 2 and entry.frame_id.endswith('optical_frame'):
            stated = 'pinhole'  # REP 103: such a frame is the camera's, z forward
        return points, colors, _stated_sensor(points, stated), notes

    def _depth(
        self, entry: Entry
    ) -> tuple[Floats32or64, Bytes | None, SensorModel | None, tuple[str, ...]]:
        topic = entry.raw.channel.topic
        depth = depth_image.decode_depth(entry.message)
        if entry.info is None:
            where = self._plan.infos.get(topic)
            raise InputError(
                f'its CameraInfo on {where} cannot be read' if where else 'the depth image has no '
                f'CameraInfo: none on {topic.rpartition("/")[0]}/camera_info')
        rectified = 'rect' in topic.rpartition('/')[2]
        points = depth_image.backproject(depth, entry.info, rectified=rectified)
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
                'the order is that of the recording',)

    def _unique(self, name: str) -> str:
        self._used[name] = self._used.get(name, 0) + 1
        return name if self._used[name] == 1 else f'{name}#{self._used[name]}'


def _colors(entry: Entry) -> tuple[Bytes | None, tuple[str, ...]]:
    if entry.color is None:
        return None, ()
    try:
        colors = depth_image.decode_color(entry.color)
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
