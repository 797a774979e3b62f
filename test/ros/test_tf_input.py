# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Transforms from real topics. Truth: the matrices that were published, and the clock."""

import sys
import threading
import time

from msg_adapters import transforms
from msg_adapters.transforms import StampedTransform
import numpy as np
import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
pytest.importorskip('tf2_msgs.msg', reason='tf2_msgs is not built here')
from geometry_msgs.msg import TransformStamped  # noqa: E402, I100
from rclpy._rclpy_pybind11 import RCLError  # noqa: E402
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from ros_rops.nodes import tf_input  # noqa: E402
from ros_rops.nodes.tf_input import TfInput  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

SECOND = 1_000_000_000
PATIENCE_S = 20.0


def pose(x):
    T = np.eye(4)
    T[0, 3] = x
    return T


def message(parent, child, x, stamp_ns=0):
    item = TransformStamped()
    transforms.fill(item, StampedTransform(parent, child, stamp_ns, pose(x)))
    return TFMessage(transforms=[item])


def until(true):
    deadline = time.monotonic() + PATIENCE_S
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.fixture
def station():
    """Return a node that is spun, and one to publish with."""
    context = rclpy.Context()
    context.init()
    node, other = (rclpy.create_node(name, context=context) for name in ('listens', 'says'))
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)

    def spin():
        try:
            executor.spin()
        except ExternalShutdownException:
            pass
        except RCLError:
            # Between its look at the context and its wait the context may have gone.
            if context.ok():
                raise

    thread = threading.Thread(target=spin)
    thread.start()
    yield node, other
    context.try_shutdown()  # executor.shutdown would take away what it waits on
    thread.join()
    node.destroy_node()
    other.destroy_node()


@pytest.fixture
def heard(station):
    """Return a TfInput and a publisher on /tf that it hears."""
    node, other = station
    listener = TfInput(node)
    publisher = other.create_publisher(TFMessage, '/tf', 100)
    until(publisher.get_subscription_count)
    yield listener, publisher
    listener.close()


def test_static_and_moving(station):
    node, other = station
    latched = other.create_publisher(TFMessage, '/tf_static', QoSProfile(
        depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    latched.publish(message('world', 'base', 1.0))  # before anybody listens
    listener = TfInput(node)
    moving = other.create_publisher(TFMessage, '/tf', 100)
    until(moving.get_subscription_count)
    for k in (2, 4):
        moving.publish(message('base', 'eye', float(k), k * SECOND))
    until(lambda: listener.kept == 3)
    np.testing.assert_allclose(listener.lookup('world', 'eye', 3 * SECOND), pose(4))
    np.testing.assert_allclose(listener.lookup('eye', 'world'), pose(-5))
    assert set(listener.frames) == {'world', 'base', 'eye'}
    listener.close()


def test_what_comes_late_is_waited_for(heard):
    listener, publisher = heard
    listener._wait_s = PATIENCE_S
    publisher.publish(message('world', 'eye', 1.0, SECOND))
    until(lambda: listener.kept == 1)
    late = threading.Timer(
        0.1, publisher.publish, [message('world', 'eye', 3.0, SECOND + SECOND // 10)])
    late.start()
    # What is known already would hold for so long, but it moves.
    found = listener.lookup('world', 'eye', SECOND + SECOND // 20)
    late.join()
    np.testing.assert_allclose(found, pose(2))


def test_what_never_comes_is_waited_for_once(heard):
    listener, publisher = heard
    publisher.publish(message('world', 'eye', 1.0, SECOND))
    until(lambda: listener.kept == 1)
    for frames, beyond, expected in (
        (('world', 'moon'), 0, None), (('world', 'eye'), 5 * SECOND, None),
        (('eye', 'world'), SECOND // 20, pose(-1)),
    ):
        started = time.monotonic()
        found = listener.lookup(*frames, SECOND + beyond)
        assert time.monotonic() - started >= tf_input.WAIT_S
        started = time.monotonic()
        for _ in range(20):
            again = listener.lookup(*frames, SECOND + beyond)
        assert time.monotonic() - started < 20 * tf_input.WAIT_S / 2
        for one in (found, again):
            assert one is None if expected is None else np.array_equal(one, expected)


def test_known_at_once_costs_nothing(heard):
    listener, publisher = heard
    publisher.publish(message('world', 'eye', 1.0, SECOND))
    until(lambda: listener.kept == 1)
    started = time.monotonic()
    for _ in range(20):
        assert listener.lookup('world', 'eye', SECOND) is not None
    assert time.monotonic() - started < 20 * tf_input.WAIT_S / 2


def test_closing_wakes_who_waits(heard):
    listener, _ = heard
    listener._wait_s = 10 * PATIENCE_S
    answers = []
    thread = threading.Thread(target=lambda: answers.append(listener.lookup('a', 'b', 1)))
    thread.start()
    listener.close()
    thread.join(PATIENCE_S)
    assert answers == [None]


def test_memory_is_bounded(heard):
    listener, publisher = heard
    for k in range(500):
        publisher.publish(message('world', 'eye', float(k), k * SECOND))
        if k % 50 == 49:  # no faster than the reader
            until(lambda k=k: listener.lookup('world', 'eye', k * SECOND) is not None)
    assert listener.kept <= 1 + tf_input.SPAN_NS // SECOND


def test_nonsense_is_passed_by(heard):
    listener, publisher = heard
    broken = message('world', 'eye', float('nan'), SECOND)
    publisher.publish(broken)
    publisher.publish(TFMessage())
    publisher.publish(message('world', 'eye', 2.0, SECOND))
    until(lambda: listener.kept == 1)
    np.testing.assert_array_equal(listener.lookup('world', 'eye', SECOND), pose(2))


def test_without_tf2_msgs(station, monkeypatch):
    monkeypatch.setitem(sys.modules, 'tf2_msgs.msg', None)
    node, _ = station
    listener = TfInput(node)
    started = time.monotonic()
    assert not listener.available
    assert listener.lookup('world', 'eye', 1) is None
    assert time.monotonic() - started < tf_input.WAIT_S
    listener.close()
