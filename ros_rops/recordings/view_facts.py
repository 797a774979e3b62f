# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What we know of a frame or view and sensor_msgs cannot say, as JSON on a topic of its own.

The JSON stands in a std_msgs/String, which every tool for bags can read and play.

Each message on `/view_facts` belongs to the next message of the topic that it names, and has its
log time. With it a recording gives back exactly what was written: name, units, sensor, support,
a missing stamp, the order of the points. Other tools show it, or pass it by.
"""

import base64
import binascii
from collections.abc import Mapping
from dataclasses import dataclass, replace
import json
from typing import Any
import zlib

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError, RopsError
from ros_rops.core.frame import Frame
from ros_rops.core.types import (
    Bytes, Floats, Floats32or64, Ints, is_rigid, RangeView, SensorModel, SupportPlane, Units)
from ros_rops.recordings import cdr

FACTS_TOPIC = '/view_facts'


@dataclass(frozen=True, slots=True)
class ViewFacts:
    """
    The facts of one message.

    Parameters
    ----------
    topic : str
        Of the message that they belong to.
    kind : {'view', 'frame'}
        'view': the message is a finished view, nothing is to be cut out of it.
    name, units, sensor, stamp_ns, frame_id, support, notes
        As in `RangeView` and `Frame`.
    shape : tuple of int
        (H, W) if organized, else (N,): a message cannot tell one row from none.
    grid : (H, W) int32 or None
        For a view whose points do not stand in the order of their pixels.
    log_time_ns : int or None
        In a view's file, which has no other place for it.
    beyond : (M, 3) float32 or None
    T_fixed_sensor : (4, 4) float64 or None
    """

    topic: str
    kind: str
    name: str
    units: Units = 'unknown'
    sensor: SensorModel | None = None
    stamp_ns: int | None = None
    frame_id: str = ''
    shape: tuple[int, ...] = ()
    grid: Ints | None = None
    support: SupportPlane | None = None
    notes: tuple[str, ...] = ()
    log_time_ns: int | None = None
    beyond: NDArray[np.float32] | None = None
    T_fixed_sensor: Floats | None = None


def encode_facts(facts: ViewFacts) -> bytes:
    """Return the facts as JSON (ASCII; floats in full)."""
    content: dict[str, Any] = {
        'topic': facts.topic, 'kind': facts.kind, 'name': facts.name, 'units': facts.units,
        'stamp_ns': facts.stamp_ns, 'frame_id': facts.frame_id, 'shape': list(facts.shape),
        'sensor': None, 'notes': list(facts.notes)}
    if facts.sensor is not None:
        content['sensor'] = sensor_document(facts.sensor)
    if facts.support is not None:
        content['support'] = support_document(facts.support)
    if facts.grid is not None:
        content['grid'] = _packed(facts.grid.astype('<i4'))
    if facts.beyond is not None:
        content['beyond'] = _packed(facts.beyond.astype('<f4'))
    if facts.T_fixed_sensor is not None:
        content['T_fixed_sensor'] = facts.T_fixed_sensor.tolist()
    if facts.log_time_ns is not None:
        content['log_time_ns'] = facts.log_time_ns
    return json.dumps(content, separators=(',', ':')).encode()


def decode_facts(data: bytes) -> ViewFacts:
    """
    Return the facts that `encode_facts` wrote, as they are or in a std_msgs/String.

    Raises
    ------
    InputError
        If the bytes are no such JSON.
    """
    try:
        content = json.loads(cdr.string_of(data))
        return ViewFacts(
            str(content['topic']), str(content['kind']), str(content['name']),
            units_of(content.get('units', 'unknown')), sensor_of(content.get('sensor')),
            _stamp(content.get('stamp_ns')), str(content.get('frame_id', '')),
            tuple(int(n) for n in content.get('shape', ())), _grid(content.get('grid')),
            support_of(content.get('support')),
            tuple(str(note) for note in content.get('notes', ())),
            _stamp(content.get('log_time_ns')), _beyond(content.get('beyond')),
            _matrix(content.get('T_fixed_sensor')))
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError,
            zlib.error, binascii.Error) as error:
        raise InputError(f'{FACTS_TOPIC}: facts that cannot be read ({error!r})') from None


def _stamp(value: Any) -> int | None:
    return None if value is None else int(value)


def _grid(content: Mapping[str, Any] | None) -> Ints | None:
    if content is None:
        return None
    return _unpacked(content, '<i4').astype(np.int32)


def _beyond(content: Mapping[str, Any] | None) -> NDArray[np.float32] | None:
    return None if content is None else _unpacked(content, '<f4').astype(np.float32)


def _matrix(content: Any) -> Floats | None:
    if content is None:
        return None
    matrix = np.array(content, np.float64)
    if not is_rigid(matrix):
        raise ValueError('T_fixed_sensor is no rigid motion')
    return matrix


def _packed(array: NDArray[Any]) -> dict[str, Any]:
    packed = base64.b64encode(zlib.compress(array.tobytes()))
    return {'shape': list(array.shape), 'zlib_base64': packed.decode()}


def _unpacked(content: Mapping[str, Any], kind: str) -> NDArray[Any]:
    """Return the (H, W) array of `_packed`; no more memory is taken than its shape says."""
    height, width = (int(n) for n in content['shape'])
    unpacker = zlib.decompressobj()
    data = unpacker.decompress(
        base64.b64decode(content['zlib_base64']), 4 * height * width + 1)
    return np.frombuffer(data, kind).reshape(height, width)


def sensor_document(sensor: SensorModel) -> dict[str, Any]:
    """Return a sensor as JSON values."""
    return {'kind': sensor.kind, 'origin': [float(v) for v in sensor.origin],
            'direction': [float(v) for v in sensor.direction]}


def sensor_of(content: Mapping[str, Any] | None) -> SensorModel | None:
    """
    Return the sensor of `sensor_document`.

    Raises
    ------
    ValueError, KeyError, TypeError
        If the content is another.
    """
    if content is None:
        return None
    kind = content['kind']
    if kind not in ('pinhole', 'orthographic', 'unknown'):
        raise ValueError(f'sensor {kind!r}')
    return SensorModel(kind, _triple(content['origin']), _triple(content['direction']))


def support_document(support: SupportPlane) -> dict[str, Any]:
    """Return a supporting plane as JSON values."""
    return {'normal': [float(v) for v in support.normal], 'offset': float(support.offset)}


def support_of(content: Mapping[str, Any] | None) -> SupportPlane | None:
    """
    Return the plane of `support_document`.

    Raises
    ------
    ValueError, KeyError, TypeError
        If the content is another.
    """
    if content is None:
        return None
    return SupportPlane(_triple(content['normal']), float(content['offset']))


def units_of(value: Any) -> Units:
    """
    Return `value` if it is one of the units.

    Raises
    ------
    ValueError
        If it is none.
    """
    if value == 'm':
        return 'm'
    if value == 'mm':
        return 'mm'
    if value == 'unknown':
        return 'unknown'
    raise ValueError(f'units {value!r}')


def _triple(values: Any) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def organized(view: RangeView) -> tuple[Floats, Bytes | None]:
    """
    Return (H, W, 3) points, NaN where none, and colours.

    They are (N, 3), as in the view, if it has no grid or one that does not count its points in
    the order of the pixels.
    """
    if view.grid is None:
        return view.points, view.colors
    empty = view.grid < 0
    if not np.array_equal(view.grid[~empty], np.arange(len(view.points))):
        return view.points, view.colors
    points = np.full((*view.grid.shape, 3), np.nan)
    points[~empty] = view.points
    if view.colors is None:
        return points, None
    colors = np.zeros(points.shape, np.uint8)
    colors[~empty] = view.colors
    return points, colors


def with_facts(frame: Frame, facts: ViewFacts) -> Frame:
    """
    Return the frame that was written, from the frame as the message alone tells it.

    `frame.view` is set if the facts are those of a view.

    Raises
    ------
    InputError
        If facts and message contradict each other.
    """
    try:
        points = frame.points.reshape(*facts.shape, 3)
        colors = None if frame.colors is None else frame.colors.reshape(points.shape)
        view = _view(points, colors, facts) if facts.kind == 'view' else None
        return replace(
            frame, name=facts.name, points=points, colors=colors, sensor=facts.sensor,
            units=facts.units, stamp_ns=facts.stamp_ns, frame_id=facts.frame_id,
            notes=facts.notes, view=view)
    except (ValueError, IndexError, RopsError) as error:
        raise InputError(
            f'{facts.name}: the message contradicts its {FACTS_TOPIC} ({error})') from None


def _view(points: Floats32or64, colors: Bytes | None, facts: ViewFacts) -> RangeView:
    grid = facts.grid
    if points.ndim == 3:
        measured = ~np.isnan(points[..., 2])
        grid = np.full(measured.shape, -1, np.int32)
        grid[measured] = np.arange(np.count_nonzero(measured), dtype=np.int32)
        points = points[measured]
        colors = None if colors is None else colors[measured]
    return RangeView(
        facts.name, points.astype(np.float64), grid, facts.sensor or SensorModel(), colors,
        facts.units, facts.stamp_ns, facts.frame_id, facts.support, facts.beyond,
        facts.T_fixed_sensor)
