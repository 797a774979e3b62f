# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""sensor_msgs/Image and CameraInfo as little-endian CDR, with their definitions."""

from numpy.typing import NDArray

from ros_rops.recordings.cdr import BREAK, HEADER, MessageBytes, STAMP
from ros_rops.recordings.raycast import Camera

IMAGE_SCHEMA = (
    HEADER
    + 'uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n'
    'uint8[] data\n'
    + STAMP
)
CAMERA_INFO_SCHEMA = (
    HEADER
    + 'uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n'
    'float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n'
    + BREAK + 'sensor_msgs/RegionOfInterest\n'
    'uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n'
    + STAMP
)


def image(pixels: NDArray, encoding: str, stamp_ns: int, frame_id: str) -> bytes:
    """
    Return an Image.

    Parameters
    ----------
    pixels : (H, W) or (H, W, C) array
        Of the type that `encoding` says: uint16 for 16UC1, float32 for 32FC1, uint8 for rgb8.
    encoding : str
    stamp_ns : int
    frame_id : str
    """
    data = pixels.astype(pixels.dtype.newbyteorder('<'), copy=False).tobytes()
    height, width = pixels.shape[:2]
    w = MessageBytes()
    w.header(stamp_ns, frame_id)
    w.put('I', height, width)
    w.text(encoding)
    w.put('B', 0)
    w.put('I', len(data) // max(height, 1))
    w.octets(data)
    return w.message()


def camera_info(camera: Camera, stamp_ns: int, frame_id: str) -> bytes:
    """Return the CameraInfo of a rectified pinhole camera (plumb_bob, all coefficients zero)."""
    c = camera
    w = MessageBytes()
    w.header(stamp_ns, frame_id)
    w.put('I', c.height, c.width)
    w.text('plumb_bob')
    w.put('I', 5)
    w.put('d', *[0.0] * 5)
    w.put('d', c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0)
    w.put('d', 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    w.put('d', c.fx, 0.0, c.cx, 0.0, 0.0, c.fy, c.cy, 0.0, 0.0, 0.0, 1.0, 0.0)
    w.put('I', *[0] * 6)
    w.put('?', False)
    return w.message()
