# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
sensor_msgs/Image of depths or colours to arrays, by attribute names only (REP 118).

16UC1 and mono16 count millimetres and 0 is a hole; 32FC1 counts metres and NaN, infinities and
numbers that are not positive are holes.
"""

from typing import Any

from msg_adapters import camera_info
from msg_adapters.attributes import attribute, octets, whole
import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError, ShapeError

KIND = 'Image'
DEPTHS = {'16UC1': 'u2', 'mono16': 'u2', '32FC1': 'f4'}
"""Encodings of depth images."""
COLORS = {
    'rgb8': (0, 1, 2), 'bgr8': (2, 1, 0), 'rgba8': (0, 1, 2), 'bgra8': (2, 1, 0),
    'mono8': (0, 0, 0), '8UC1': (0, 0, 0), '8UC3': (2, 1, 0), '8UC4': (2, 1, 0),
}
"""Encodings of colour images: where red, green and blue are (OpenCV's 8UC3 is blue first)."""
CHANNELS = {'rgba8': 4, 'bgra8': 4, '8UC4': 4, 'mono8': 1, '8UC1': 1}
FARTHEST_M = 1e6
"""A depth beyond this is no measurement."""


def decode_depth(image: Any) -> NDArray[np.float32]:
    """
    Return the (H, W) depths of an Image, in metres, NaN where there is none.

    Parameters
    ----------
    image : object
        Has Image's attributes; its rows may be padded, its bytes in either order.

    Raises
    ------
    InputError
        If the encoding is none of `DEPTHS`, or sizes and data contradict each other.
    """
    encoding = str(attribute(image, 'encoding', KIND))
    if encoding not in DEPTHS:
        raise InputError(f'Image: encoding {encoding!r} is none of {", ".join(DEPTHS)}')
    order = '>' if attribute(image, 'is_bigendian', KIND) else '<'
    raw = _pixels(image, np.dtype(order + DEPTHS[encoding]), 1)[..., 0]
    if raw.dtype.kind == 'u':
        depth: NDArray[np.float32] = np.multiply(raw, np.float32(0.001), dtype=np.float32)
        depth[raw == 0] = np.nan
        return depth
    depth = raw.astype(np.float32)
    with np.errstate(invalid='ignore'):
        depth[~((depth > 0) & (depth <= FARTHEST_M))] = np.nan
    return depth


def decode_color(image: Any) -> NDArray[np.uint8]:
    """
    Return the (H, W, 3) red, green, blue of an Image.

    Raises
    ------
    InputError
        If the encoding is none of `COLORS`, or sizes and data contradict each other.
    """
    encoding = str(attribute(image, 'encoding', KIND))
    if encoding not in COLORS:
        raise InputError(f'Image: encoding {encoding!r} is none of {", ".join(COLORS)}')
    pixels = _pixels(image, np.dtype('u1'), CHANNELS.get(encoding, 3))
    rgb = np.empty((*pixels.shape[:2], 3), np.uint8)
    for k, source in enumerate(COLORS[encoding]):
        rgb[..., k] = pixels[..., source]
    return rgb


def _pixels(image: Any, dtype: np.dtype[Any], channels: int) -> NDArray[Any]:
    """Return the (H, W, C) pixels, without a copy, after a check of sizes."""
    height, width = whole(image, 'height', KIND), whole(image, 'width', KIND)
    step, data = whole(image, 'step', KIND), octets(image, KIND)
    row = width * channels * dtype.itemsize
    if not height or not width:
        return np.empty((0, 0, channels), dtype)
    if step < row and height > 1:
        raise InputError(f'Image: step {step} < width x bytes of a pixel = {row}')
    needed = (height - 1) * step + row
    if needed > len(data):
        raise InputError(f'Image: {len(data)} bytes of data, {height} x {width} pixels need '
                         f'{needed}')
    strides = (step, channels * dtype.itemsize, dtype.itemsize)
    return np.ndarray((height, width, channels), dtype, data, 0, strides)


def backproject(
    depth: NDArray[np.float32], info: Any, *, rectified: bool = False
) -> NDArray[np.float32]:
    """
    Return the (H, W, 3) points of a depth image in its camera's optical frame, metres.

    Parameters
    ----------
    depth : (H, W) float32
        Along the optical axis, NaN where there is none.
    info : object
        Has CameraInfo's attributes.
    rectified : bool
        Whether the image is undistorted already (`image_rect...` by ROS's custom).

    Raises
    ------
    InputError
        As `camera_info.calibration` and `camera_info.rays`.
    ShapeError
        If `depth` has another shape.
    """
    if depth.ndim != 2:
        raise ShapeError(f'depth: expected (H, W), got {depth.shape}')
    camera = camera_info.calibration(info, *depth.shape, rectified=rectified)
    x, y, lost = camera_info.rays(camera)
    points = np.empty((*depth.shape, 3), np.float32)
    np.multiply(x, depth, out=points[..., 0])
    np.multiply(y, depth, out=points[..., 1])
    points[..., 2] = depth
    if lost is not None:
        points[lost] = np.nan
    return points
