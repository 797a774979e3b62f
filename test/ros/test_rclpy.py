# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Real rclpy: a cloud through the wire format and through a topic. Truth: what was sent."""

import array
import time

from msg_adapters import depth_image, point_cloud2, transforms
import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from geometry_msgs.msg import TransformStamped  # noqa: E402, I100
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.serialization import deserialize_message, serialize_message  # noqa: E402
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField  # noqa: E402

HEIGHT, WIDTH, STEP, PADDING = 3, 5, 16, 8


def _pixels() -> np.ndarray:
    pixels = np.arange(HEIGHT * WIDTH * 3, dtype='<f4').reshape(HEIGHT, WIDTH, 3) + 0.25
    pixels[1, 2] = np.nan
    return pixels


def _cloud() -> PointCloud2:
    """Return an organized cloud with a hole, unused bytes in each point and padded rows."""
    rows = np.zeros((HEIGHT, WIDTH * STEP + PADDING), np.uint8)
    rows[:, :WIDTH * STEP].reshape(HEIGHT, WIDTH, STEP)[..., :12] = _pixels().view(np.uint8)
    data = array.array('B')
    data.frombytes(rows.tobytes())
    message = PointCloud2(
        height=HEIGHT, width=WIDTH, is_bigendian=False, is_dense=False, point_step=STEP,
        row_step=WIDTH * STEP + PADDING, data=data,
        fields=[
            PointField(name=axis, offset=4 * i, datatype=PointField.FLOAT32, count=1)
            for i, axis in enumerate('xyz')])
    message.header.frame_id = 'camera'
    message.header.stamp.sec = 7
    return message


def test_fields_are_checked():
    with pytest.raises(AssertionError):
        PointCloud2().height = 1.5


def test_cloud_survives_the_wire_format():
    sent = _cloud()
    assert deserialize_message(serialize_message(sent), PointCloud2) == sent


def test_adapter_reads_a_real_cloud():
    message = deserialize_message(serialize_message(_cloud()), PointCloud2)
    xyz, rgb = point_cloud2.decode(message)
    np.testing.assert_array_equal(xyz, _pixels())
    assert rgb is None


def test_adapter_fills_a_real_cloud():
    rgb = np.arange(HEIGHT * WIDTH * 3, dtype=np.uint8).reshape(HEIGHT, WIDTH, 3)
    message = PointCloud2()
    point_cloud2.fill(message, PointField, _pixels(), rgb)
    back = deserialize_message(serialize_message(message), PointCloud2)
    assert (back.height, back.width, back.is_dense) == (HEIGHT, WIDTH, False)
    for found, sent in zip(point_cloud2.decode(back), (_pixels(), rgb), strict=True):
        np.testing.assert_array_equal(found, sent)


def test_cloud_goes_through_a_topic():
    rclpy.init()
    node = rclpy.create_node('ros_rops_test')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    received = []
    node.create_subscription(PointCloud2, 'views', received.append, 10)
    publisher = node.create_publisher(PointCloud2, 'views', 10)
    try:
        deadline = time.monotonic() + 20.0
        while publisher.get_subscription_count() == 0 and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)
        publisher.publish(_cloud())
        while not received and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    assert received == [_cloud()]


def _image(pixels: np.ndarray, encoding: str) -> Image:
    data = array.array('B')
    data.frombytes(pixels.tobytes())
    return Image(
        height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, data=data,
        step=pixels[0].nbytes, is_bigendian=0)


def test_adapter_reads_a_real_depth_image():
    pixels = 1000 + np.arange(HEIGHT * WIDTH, dtype='<u2').reshape(HEIGHT, WIDTH)
    pixels[1, 2] = 0
    message = deserialize_message(serialize_message(_image(pixels, '16UC1')), Image)
    info = CameraInfo(
        height=HEIGHT, width=WIDTH, distortion_model='plumb_bob', d=[0.0] * 5,
        k=[10.0, 0.0, 2.0, 0.0, 10.0, 1.0, 0.0, 0.0, 1.0])
    info = deserialize_message(serialize_message(info), CameraInfo)
    points = depth_image.backproject(depth_image.decode_depth(message), info)
    np.testing.assert_allclose(points[2, 4], [0.2 * 1.014, 0.1 * 1.014, 1.014], rtol=1e-6)
    assert np.isnan(points[1, 2]).all()


def test_adapter_reads_a_real_colour_image():
    rgb = np.arange(HEIGHT * WIDTH * 3, dtype=np.uint8).reshape(HEIGHT, WIDTH, 3)
    message = deserialize_message(serialize_message(_image(rgb, 'bgr8')), Image)
    np.testing.assert_array_equal(depth_image.decode_color(message), rgb[..., ::-1])


def test_adapter_fills_and_reads_a_real_transform():
    T = np.eye(4)
    T[:3] = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3]]
    message = TransformStamped()
    transforms.fill(message, transforms.StampedTransform('base', 'eye', 5_000_000_007, T))
    back = deserialize_message(serialize_message(message), TransformStamped)
    found = transforms.decode_one(back)
    assert (found.parent, found.child, found.stamp_ns) == ('base', 'eye', 5_000_000_007)
    np.testing.assert_allclose(found.T_parent_child, T, atol=1e-15)
