# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
sensor_msgs/PointCloud2 to arrays and back, by attribute names only.

The same code serves messages of rclpy, mcap and rosbags. Pixel (row v, column u) of an organized
cloud lies at v * row_step + u * point_step: rows may be padded, fields come in any order.
"""

import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass
import sys
from typing import Any

from msg_adapters.attributes import attribute, octets, whole
import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError, ShapeError
from ros_rops.core.types import Floats32or64

KIND = 'PointCloud2'
DATATYPES = {1: 'i1', 2: 'u1', 3: 'i2', 4: 'u2', 5: 'i4', 6: 'u4', 7: 'f4', 8: 'f8'}
CODES = {kind: code for code, kind in DATATYPES.items()}
NATIVE = '<' if sys.byteorder == 'little' else '>'
PACKED = frozenset({5, 6, 7})
"""Types whose four bytes may hold a packed colour."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a point, as in sensor_msgs/PointField."""

    name: str
    offset: int
    datatype: int
    count: int = 1


@dataclass(frozen=True, slots=True)
class Layout:
    """Where things are in the bytes of a message, checked against their number."""

    height: int
    width: int
    point_step: int
    row_step: int
    order: str
    fields: dict[str, Field]


def decode(message: Any) -> tuple[Floats32or64, NDArray[np.uint8] | None]:
    """
    Return the points, and the colours if there are any, of a PointCloud2.

    Parameters
    ----------
    message : object
        Has PointCloud2's attributes; `data` is anything with the buffer protocol, or a sequence
        of bytes.

    Returns
    -------
    xyz : (H, W, 3) or (N, 3), float32 if x, y and z are all float32, else float64
        Organized if `height` > 1; holes are as in the message. Not a copy, and read-only, where
        the message holds nothing but x, y, z in this order.
    rgb : (H, W, 3) or (N, 3) uint8, or None
        From a packed `rgb` / `rgba` (float32 or uint32), or `r`, `g`, `b` bytes.

    Raises
    ------
    InputError
        If x, y or z is missing or sizes, offsets and the data contradict each other.
    """
    data = octets(message, KIND)
    layout = _layout(message, len(data))
    shape = (layout.height, layout.width) if layout.height > 1 else (layout.width,)
    xyz = _points(data, layout)
    rgb = _colors(data, layout)
    return xyz.reshape(*shape, 3), None if rgb is None else rgb.reshape(*shape, 3)


def _points(data: memoryview, layout: Layout) -> Floats32or64:
    """Return the (H, W, 3) coordinates."""
    for name in 'xyz':
        if name not in layout.fields:
            raise InputError(f'PointCloud2 has no field {name!r}')
    x, y, z = (layout.fields[name] for name in 'xyz')
    single = {field.datatype for field in (x, y, z)} == {CODES['f4']}
    together = single and layout.order == NATIVE and (
        y.offset, z.offset) == (x.offset + 4, x.offset + 8)
    if together and layout.width:
        return _together(data, layout, x.offset)
    shape = (layout.height, layout.width, 3)
    xyz: Floats32or64 = np.empty(shape, np.float32) if single else np.empty(shape)
    with np.errstate(invalid='ignore'):  # holes may be signalling NaN
        for k, field in enumerate((x, y, z)):
            xyz[..., k] = _channel(data, layout, field)
    return xyz


def _together(data: memoryview, layout: Layout, offset: int) -> NDArray[np.float32]:
    """Return x, y, z that lie side by side, each point copied as one item of twelve bytes."""
    shape, steps = (layout.height, layout.width), (layout.row_step, layout.point_step)
    points: NDArray[Any] = np.ndarray(shape, 'V12', data, offset, steps)
    xyz = np.ascontiguousarray(points).view(np.float32)
    aligned = xyz if xyz.flags.aligned else xyz.copy()
    return aligned.reshape(layout.height, layout.width, 3)


def _layout(message: Any, size: int) -> Layout:
    height, width = whole(message, 'height', KIND), whole(message, 'width', KIND)
    point_step, row_step = whole(message, 'point_step', KIND), whole(message, 'row_step', KIND)
    order = '>' if attribute(message, 'is_bigendian', KIND) else '<'
    if height == 0 or width == 0:
        height, width = min(height, 1), 0
    row = width * point_step
    if height == 1:
        row_step = row  # one row has no step; drivers write all sorts of things there
    if row_step < row:
        raise InputError(f'PointCloud2: row_step {row_step} < width x point_step = {row}')
    needed = (height - 1) * row_step + row if width else 0
    if width and not point_step:
        raise InputError('PointCloud2: point_step is 0')
    if needed > size:
        raise InputError(
            f'PointCloud2: {size} bytes of data, {height} x {width} points need {needed}')
    return Layout(height, width, point_step, row_step, order, _fields(message, point_step))


def _fields(message: Any, point_step: int) -> dict[str, Field]:
    fields = {}
    try:
        listed = list(attribute(message, 'fields', KIND))
    except TypeError:
        raise InputError('PointCloud2: fields is no sequence') from None
    for item in listed:
        name = str(attribute(item, 'name', KIND))
        code = whole(item, 'datatype', KIND)
        field = Field(name, whole(item, 'offset', KIND), code, max(whole(item, 'count', KIND), 1))
        if code not in DATATYPES:
            if name in ('x', 'y', 'z'):
                raise InputError(f'PointCloud2: field {name!r} has unknown datatype {code}')
            continue
        size = np.dtype(DATATYPES[code]).itemsize * field.count
        if field.offset + size > point_step:
            raise InputError(
                f'PointCloud2: field {name!r} ends at byte {field.offset + size} of a point of '
                f'{point_step}')
        fields[name] = field
    return fields


def _channel(data: memoryview, layout: Layout, field: Field) -> NDArray[Any]:
    """Return the (H, W) view of one field's first value, without a copy."""
    if not layout.width:
        return np.zeros((layout.height, 0))
    return np.ndarray(
        (layout.height, layout.width),
        layout.order + DATATYPES[field.datatype],
        data,
        field.offset,
        (layout.row_step, layout.point_step),
    )


def _colors(data: memoryview, layout: Layout) -> NDArray[np.uint8] | None:
    offsets = _color_offsets(layout)
    if offsets is None:
        return None
    rgb = np.empty((layout.height, layout.width, 3), np.uint8)
    for k, offset in enumerate(offsets):
        rgb[..., k] = _channel(data, layout, Field('', offset, CODES['u1']))
    return rgb


def _color_offsets(layout: Layout) -> tuple[int, ...] | None:
    """Return where in a point its red, green and blue bytes are, if anywhere."""
    packed = layout.fields.get('rgb', layout.fields.get('rgba'))
    if packed is not None and packed.datatype in PACKED:
        # The number is alpha, red, green, blue from its highest byte down.
        return tuple(packed.offset + (k if layout.order == '<' else 3 - k) for k in (2, 1, 0))
    single = [layout.fields.get(name) for name in 'rgb']
    offsets = tuple(
        field.offset for field in single if field is not None and field.datatype == CODES['u1'])
    return offsets if len(offsets) == 3 else None


def encode(
    xyz: NDArray[Any],
    rgb: NDArray[np.uint8] | None = None,
    extra: Mapping[str, NDArray[Any]] | None = None,
    *,
    wide: bool = False,
) -> dict[str, Any]:
    """
    Return the values of a PointCloud2's attributes (all but `header`), little-endian.

    Parameters
    ----------
    xyz : (H, W, 3) or (N, 3) float
        NaN marks a hole.
    rgb : same shape, uint8, or None
        Written packed into a float32 `rgb`, as PCL and RViz expect it.
    extra : mapping of str to (H, W) or (N,) arrays, or None
        Further fields, each in its own type (float64 and integers of 1-4 bytes included).
    wide : bool
        Write x, y, z as float64; else float32, which every tool reads.

    Returns
    -------
    dict
        `fields` are `Field`; `data` is an `array.array('B')`, which rclpy takes without a copy.

    Raises
    ------
    ShapeError
        If the shapes do not go together or a type has no PointField code.
    """
    if xyz.ndim not in (2, 3) or xyz.shape[-1] != 3:
        raise ShapeError(f'xyz: expected (H, W, 3) or (N, 3), got {xyz.shape}')
    height, width = xyz.shape[:2] if xyz.ndim == 3 else (1, len(xyz))
    channels: dict[str, NDArray[Any]] = {
        name: xyz[..., k].astype(np.float64 if wide else np.float32)
        for k, name in enumerate('xyz')}
    if rgb is not None:
        if rgb.shape != xyz.shape or rgb.dtype != np.uint8:
            raise ShapeError(f'rgb: expected {xyz.shape} uint8, got {rgb.shape} {rgb.dtype}')
        bits = rgb.astype(np.uint32)
        channels['rgb'] = (
            bits[..., 0] << 16 | bits[..., 1] << 8 | bits[..., 2]).view(np.float32)
    for name, values in (extra or {}).items():
        if values.shape != xyz.shape[:-1] or values.dtype.str[1:] not in CODES:
            raise ShapeError(f'{name}: expected {xyz.shape[:-1]}, got {values.shape} '
                             f'{values.dtype}')
        channels[name] = values
    return _pack(channels, height, width, bool(np.isfinite(xyz).all()))


def _pack(
    channels: dict[str, NDArray[Any]], height: int, width: int, dense: bool
) -> dict[str, Any]:
    dtype = np.dtype([(name, '<' + v.dtype.str[1:]) for name, v in channels.items()])
    points = np.empty(height * width, dtype)
    for name, values in channels.items():
        points[name] = values.reshape(-1)
    data = array.array('B')
    data.frombytes(points.view(np.uint8).data)
    offsets: Mapping[str, Any] = dtype.fields or {}
    return {
        'height': height,
        'width': width,
        'fields': [
            Field(name, int(offsets[name][1]), CODES[v.dtype.str[1:]])
            for name, v in channels.items()
        ],
        'is_bigendian': False,
        'point_step': dtype.itemsize,
        'row_step': dtype.itemsize * width,
        'data': data,
        'is_dense': dense,
    }


def fill(
    message: Any,
    make_field: Callable[[], Any],
    xyz: NDArray[Any],
    rgb: NDArray[np.uint8] | None = None,
    extra: Mapping[str, NDArray[Any]] | None = None,
) -> None:
    """
    Fill a message handed in, its `header` left alone.

    Parameters
    ----------
    message : object
        For example `sensor_msgs.msg.PointCloud2()`.
    make_field : callable
        Returns an empty field, for example `sensor_msgs.msg.PointField`.
    xyz, rgb, extra
        As for `encode`.

    Raises
    ------
    ShapeError
        As `encode`.
    """
    values = encode(xyz, rgb, extra)
    fields = []
    for field in values.pop('fields'):
        item = make_field()
        for name in ('name', 'offset', 'datatype', 'count'):
            setattr(item, name, getattr(field, name))
        fields.append(item)
    message.fields = fields
    for name, value in values.items():
        setattr(message, name, value)
