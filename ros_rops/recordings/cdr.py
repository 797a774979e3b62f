# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Clouds and transforms as little-endian CDR, with their definitions.

mcap's own writer takes a quarter of a second per 100 kB of cloud (one call a byte); these take
none. Tests decode them with mcap's decoder.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import struct
from typing import Any

from ros_rops.core.types import Floats

HEADER = 'std_msgs/Header header\n'
BREAK = '=' * 80 + '\nMSG: '
STAMP = (
    BREAK + 'std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n'
    + BREAK + 'builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n'
)
POINT_CLOUD2_SCHEMA = (
    HEADER
    + 'uint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\nuint32 point_step\n'
    'uint32 row_step\nuint8[] data\nbool is_dense\n'
    + BREAK + 'sensor_msgs/PointField\n'
    'uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n'
    'uint8 FLOAT32=7\nuint8 FLOAT64=8\n'
    'string name\nuint32 offset\nuint8 datatype\nuint32 count\n'
    + STAMP
)
STRING_SCHEMA = 'string data\n'
MARK = b'\0\1\0\0'
"""Little-endian CDR, before the body."""
TF_SCHEMA = (
    'geometry_msgs/TransformStamped[] transforms\n'
    + BREAK + 'geometry_msgs/TransformStamped\n' + HEADER
    + 'string child_frame_id\ngeometry_msgs/Transform transform\n'
    + BREAK + 'geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n'
    'geometry_msgs/Quaternion rotation\n'
    + BREAK + 'geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n'
    + BREAK + 'geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n'
    + STAMP
)


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """A transform between named frames: `T_parent_child` (4, 4), child points to the parent."""

    T_parent_child: Floats
    parent: str
    child: str


class MessageBytes:
    """Bytes under construction; values are aligned to their size, counted from the body."""

    def __init__(self) -> None:
        self._body = bytearray()

    def put(self, code: str, *values: Any) -> None:
        """Append values of one struct type."""
        size = struct.calcsize(code)
        self._body += b'\0' * (-len(self._body) % size)
        self._body += struct.pack(f'<{len(values)}{code}', *values)

    def text(self, value: str) -> None:
        """Append a string: its length with the closing zero, then both."""
        data = value.encode(errors='replace') + b'\0'
        self.put('I', len(data))
        self._body += data

    def header(self, stamp_ns: int, frame_id: str) -> None:
        """Append a std_msgs/Header."""
        seconds, rest = divmod(stamp_ns, 1_000_000_000)
        if not 0 <= seconds < 2**31:  # what the message cannot hold is no time
            seconds, rest = 0, 0
        self.put('i', seconds)
        self.put('I', rest)
        self.text(frame_id)

    def octets(self, data: bytes) -> None:
        """Append a uint8[]."""
        self.put('I', len(data))
        self._body += data

    def message(self) -> bytes:
        """Return the finished message: little-endian CDR's mark and the body."""
        return MARK + bytes(self._body)


def point_cloud2(values: dict[str, Any], stamp_ns: int, frame_id: str) -> bytes:
    """Return a PointCloud2; `values` as `msg_adapters.point_cloud2.encode` returns them."""
    w = MessageBytes()
    w.header(stamp_ns, frame_id)
    w.put('I', values['height'], values['width'], len(values['fields']))
    for field in values['fields']:
        w.text(field.name)
        w.put('I', field.offset)
        w.put('B', field.datatype)
        w.put('I', field.count)
    w.put('?', values['is_bigendian'])
    w.put('I', values['point_step'], values['row_step'])
    w.octets(bytes(values['data']))
    w.put('?', values['is_dense'])
    return w.message()


def tf_message(transforms: Sequence[Transform], stamp_ns: int) -> bytes:
    """Return a TFMessage of the transforms, all of one time."""
    from scipy.spatial.transform import Rotation

    w = MessageBytes()
    w.put('I', len(transforms))
    for one in transforms:
        w.header(stamp_ns, one.parent)
        w.text(one.child)
        w.put('d', *one.T_parent_child[:3, 3].tolist())
        w.put('d', *Rotation.from_matrix(one.T_parent_child[:3, :3]).as_quat().tolist())
    return w.message()


def string_message(text: str) -> bytes:
    """Return a std_msgs/String."""
    w = MessageBytes()
    w.text(text)
    return w.message()


def string_of(data: bytes) -> bytes:
    """Return the text of a std_msgs/String of `string_message`, or any other bytes as they are."""
    return data[8:].rstrip(b'\0') if data.startswith(MARK) else data
