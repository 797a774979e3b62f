# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""tf2_msgs/TFMessage and geometry_msgs/TransformStamped to matrices and back, by names only."""

from dataclasses import dataclass
import math
from typing import Any

from msg_adapters.attributes import attribute
from msg_adapters.rotation import quaternion
import numpy as np
from ros_rops.core.errors import InputError, ShapeError
from ros_rops.core.types import Floats
from scipy.spatial.transform import Rotation

KIND = 'TransformStamped'
LARGEST = 1e15
"""A translation beyond this is uninitialised memory."""


@dataclass(frozen=True, slots=True)
class StampedTransform:
    """
    Where a child frame stands in its parent's at one time.

    Parameters
    ----------
    parent, child : str
        Without a leading slash.
    stamp_ns : int
    T_parent_child : (4, 4) float64
        p_parent = T_parent_child p_child.
    """

    parent: str
    child: str
    stamp_ns: int
    T_parent_child: Floats


def decode(message: Any) -> list[StampedTransform]:
    """
    Return the transforms of a TFMessage.

    Raises
    ------
    InputError
        If it is none.
    """
    try:
        listed = list(attribute(message, 'transforms', 'TFMessage'))
    except TypeError:
        raise InputError('TFMessage: transforms is no sequence') from None
    return [decode_one(item) for item in listed]


def decode_one(item: Any) -> StampedTransform:
    """
    Return the transform of a TransformStamped.

    Raises
    ------
    InputError
        If it is none, a number is not finite or the quaternion is nowhere near a unit one.
    """
    head, transform = attribute(item, 'header', KIND), attribute(item, 'transform', KIND)
    stamp = attribute(head, 'stamp', KIND)
    parent, child = (
        str(name).removeprefix('/')
        for name in (attribute(head, 'frame_id', KIND), attribute(item, 'child_frame_id', KIND)))
    translation = _numbers(attribute(transform, 'translation', KIND), 'xyz')
    rotation = _numbers(attribute(transform, 'rotation', KIND), 'xyzw')
    length = math.hypot(*rotation)  # numpy's norm overflows
    if not (1e-6 < length < 1e6 and math.hypot(*translation) < LARGEST):
        raise InputError(f'{KIND}: {parent} to {child} is no transform')
    try:
        time = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
    except (AttributeError, TypeError, ValueError, OverflowError):
        raise InputError(f'{KIND}: {parent} to {child} has no stamp') from None
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat(np.array(rotation) / length).as_matrix()
    T[:3, 3] = translation
    return StampedTransform(parent, child, time, T)


def _numbers(owner: Any, names: str) -> list[float]:
    try:
        return [float(attribute(owner, name, KIND)) for name in names]
    except (TypeError, ValueError, OverflowError):
        raise InputError(f'{KIND}: {names} are no numbers') from None


def fill(item: Any, value: StampedTransform) -> None:
    """
    Fill a TransformStamped handed in, for example `geometry_msgs.msg.TransformStamped()`.

    Raises
    ------
    ShapeError
        If the matrix is not (4, 4).
    """
    T = np.asarray(value.T_parent_child, np.float64)
    if T.shape != (4, 4):
        raise ShapeError(f'T_parent_child: expected (4, 4), got {T.shape}')
    item.header.frame_id, item.child_frame_id = value.parent, value.child
    item.header.stamp.sec = int(value.stamp_ns // 1_000_000_000)
    item.header.stamp.nanosec = int(value.stamp_ns % 1_000_000_000)
    # float(): ROS sends other numbers as garbage.
    for name, number in zip('xyz', T[:3, 3], strict=True):
        setattr(item.transform.translation, name, float(number))
    for name, number in zip('xyzw', quaternion(T[:3, :3]), strict=True):
        setattr(item.transform.rotation, name, number)
