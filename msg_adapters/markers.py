# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a scene shows to visualization_msgs/MarkerArray, by attribute names only."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from msg_adapters.rotation import quaternion
import numpy as np
from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Floats

# Of visualization_msgs/Marker.
LINE_LIST, TEXT, ADD, DELETE_ALL = 5, 9, 0, 3

Color = tuple[float, float, float]
Shared = dict[tuple[str, bytes], list[Any]]


@dataclass(frozen=True, slots=True)
class Lines:
    """
    Line segments.

    Parameters
    ----------
    namespace : str
    number : int
        Unique in the namespace.
    T : (4, 4) float64
        Rigid: where the lines stand.
    ends : (2 S, 3) float64
        Two points for each segment, in metres, in the frame that `T` tells of.
    colors : (2 S, 3) float64
        Of each point: red, green, blue from 0 to 1.
    width : float
        In metres.
    """

    namespace: str
    number: int
    T: Floats
    ends: Floats
    colors: Floats
    width: float


@dataclass(frozen=True, slots=True)
class Label:
    """
    A text that faces the viewer.

    Parameters
    ----------
    namespace : str
    number : int
        Unique in the namespace.
    at : (3,) float64
        Its middle, in metres.
    text : str
    height : float
        Of a capital letter, in metres.
    color : tuple of float
        Red, green, blue from 0 to 1.
    """

    namespace: str
    number: int
    at: Floats
    text: str
    height: float
    color: Color


def fill(
    message: Any, make_marker: Callable[[], Any], make_point: Callable[[], Any],
    make_color: Callable[[], Any], header: Any, marks: Iterable[Lines | Label],
) -> None:
    """
    Fill a MarkerArray handed in: it takes the place of all that its topic showed before.

    Parameters
    ----------
    message : object
        For example `visualization_msgs.msg.MarkerArray()`.
    make_marker, make_point, make_color : callable
        Return empty ones, for example `Marker`, `geometry_msgs.msg.Point`,
        `std_msgs.msg.ColorRGBA`.
    header : object
        Of every marker: the frame that `marks` are in.
    marks : iterable of Lines or Label

    Raises
    ------
    ShapeError
        If the ends of lines do not come in pairs, each with a colour.
    """
    clear = make_marker()
    clear.header, clear.action = header, DELETE_ALL
    markers = [clear]
    shared: Shared = {}
    for mark in marks:
        marker = make_marker()
        marker.header, marker.ns, marker.id = header, mark.namespace, int(mark.number)
        marker.action, marker.pose.orientation.w, marker.color.a = ADD, 1.0, 1.0
        # Shown by the newest transform always: that may come after the marker.
        marker.frame_locked = True
        if isinstance(mark, Lines):
            _fill_lines(marker, mark, make_point, make_color, shared)
        else:
            _fill_label(marker, mark)
        markers.append(marker)
    message.markers = markers


def _fill_lines(
    marker: Any, lines: Lines, make_point: Callable[[], Any], make_color: Callable[[], Any],
    shared: Shared,
) -> None:
    ends, colors = np.asarray(lines.ends, np.float64), np.asarray(lines.colors, np.float64)
    if ends.ndim != 2 or ends.shape[1] != 3 or len(ends) % 2 or colors.shape != ends.shape:
        raise ShapeError(
            f'{lines.namespace}: expected ends (2 S, 3), got {ends.shape}, colors {colors.shape}')
    marker.type, marker.scale.x = LINE_LIST, float(lines.width)
    _filled(marker.pose.position, 'xyz', lines.T[:3, 3])
    _filled(marker.pose.orientation, 'xyzw', quaternion(lines.T[:3, :3]))
    # Most lines are of one shape.
    for key, make, names, rows in (
            ('points', make_point, 'xyz', ends),
            ('colors', make_color, 'rgba', np.insert(colors, 3, 1.0, axis=1))):
        same = key, rows.tobytes()
        if same not in shared:
            shared[same] = [_filled(make(), names, row) for row in rows]
        setattr(marker, key, shared[same])


def _fill_label(marker: Any, label: Label) -> None:
    marker.type, marker.scale.z, marker.text = TEXT, float(label.height), label.text
    _filled(marker.pose.position, 'xyz', label.at)
    _filled(marker.color, 'rgb', label.color)


def _filled(item: Any, names: str, values: Iterable[float]) -> Any:
    # float(): ROS sends other numbers as garbage.
    for name, value in zip(names, values, strict=True):
        setattr(item, name, float(value))
    return item
