# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Draw what RViz shows of a station that runs, without RViz: docs/station.png.

The clouds and markers are those that the node publishes (`assembled`, `markers`, both latched). In
an environment with rclpy, while the station of this command is there:

    ros2 launch ros_rops replay.launch.py recording:=bags/table.mcap
    python .ci/draw_station.py docs/station.png
"""

from io import BytesIO
import sys
import time
from typing import Any

from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
import numpy as np
from PIL import Image
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_rops.live.scene import OBJECTS
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker, MarkerArray

PATIENCE_S = 30.0
WIDTH, HEIGHT, DPI = 1100, 640, 100
FOCAL = 940.0
BACKGROUND = '#1e1e22'  # as in rviz/station.rviz
UP = np.array((0.0, -0.82, -0.57))
"""Of the table of bags/table.mcap, in the frame of the sensor that the clouds are in."""
TARGET, EYE = np.array((0.0, -0.175, 0.42)), np.array((0.36, -0.84, -0.72))


def heard() -> tuple[PointCloud2, MarkerArray]:
    """Return the newest cloud and the newest markers of the station."""
    rclpy.init()
    node = Node('draw_station')
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    found: dict[str, Any] = {}
    for kind, topic in ((PointCloud2, 'assembled'), (MarkerArray, 'markers')):
        node.create_subscription(kind, topic, lambda m, t=topic: found.update({t: m}), latched)
    deadline = time.monotonic() + PATIENCE_S
    while len(found) < 2 and time.monotonic() < deadline:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()
    if len(found) < 2:
        raise SystemExit('no station publishes assembled and markers here')
    return found['assembled'], found['markers']


def draw(path: str, cloud: PointCloud2, markers: MarkerArray) -> None:
    """Write the picture of a cloud, coloured by object, and of markers."""
    figure = Figure((WIDTH / DPI, HEIGHT / DPI), dpi=DPI, facecolor=BACKGROUND)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-WIDTH / 2, WIDTH / 2), ylim=(HEIGHT / 2, -HEIGHT / 2))
    axes.axis('off')
    _draw_cloud(axes, cloud)
    labels: list[np.ndarray] = []
    for marker in markers.markers:
        place, turn = marker.pose.position, marker.pose.orientation
        origin = np.array([place.x, place.y, place.z])
        if marker.type == Marker.TEXT_VIEW_FACING:
            _draw_label(axes, marker, _projected(origin[None])[0][0], labels)
        elif marker.type == Marker.LINE_LIST:
            rotation = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w])
            ends = rotation.apply([(p.x, p.y, p.z) for p in marker.points]) + origin
            colors = [(c.r, c.g, c.b, c.a) for c in marker.colors[::2]]
            axes.add_collection(LineCollection(
                _projected(ends)[0].reshape(-1, 2, 2), colors=colors, linewidths=1.3))
    file = BytesIO()
    figure.savefig(file, format='png', facecolor=BACKGROUND)
    Image.open(file).convert('RGB').quantize(128, dither=Image.Dither.NONE).save(
        path, optimize=True)


def _draw_cloud(axes: Any, cloud: PointCloud2) -> None:
    """Draw the points, the nearest last, in the colours of their objects, lit from the eye."""
    fields = {field.name: field.offset for field in cloud.fields}
    data = bytes(cloud.data)

    def values(name: str, kind: str) -> np.ndarray:
        return np.ndarray(cloud.width, kind, data, fields[name], (cloud.point_step,))

    points, normals = (
        np.stack([values(name, '<f4') for name in names], axis=1).astype(float)
        for names in (('x', 'y', 'z'), ('normal_x', 'normal_y', 'normal_z')))
    rays = EYE - points
    light = (normals * rays).sum(axis=1) / np.linalg.norm(rays, axis=1)
    order = np.flatnonzero(light > 0)  # what is turned away is hidden
    at, depth = _projected(points[order])
    nearest_last = np.argsort(-depth)
    order = order[nearest_last]
    tints = np.asarray(OBJECTS)[values('object_id', '<i4')[order] % len(OBJECTS)]
    axes.scatter(
        *at[nearest_last].T, s=2.2, linewidths=0, c=tints * (0.25 + 0.75 * light[order, None]))


def _draw_label(axes: Any, marker: Marker, at: np.ndarray, others: list[np.ndarray]) -> None:
    """Draw a label; below its place where another one is above it."""
    taken = any((abs(at - other) < (90, 12)).all() for other in others)
    others.append(at)
    name = marker.text.partition(':')[0] if marker.ns == 'view_labels' else marker.text
    axes.text(*at, name, color='white', ha='center', va='top' if taken else 'bottom',
              fontsize=11 if marker.ns == 'object_labels' else 7)


def _projected(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return pixels (N, 2) from the picture's middle, and depths (N,), of points (N, 3)."""
    z = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    x = np.cross(z, UP) / np.linalg.norm(np.cross(z, UP))
    seen = (points - EYE) @ np.stack([x, np.cross(z, x), z], axis=1)
    return FOCAL * seen[:, :2] / seen[:, 2:], seen[:, 2]


if __name__ == '__main__':
    draw(sys.argv[1], *heard())
