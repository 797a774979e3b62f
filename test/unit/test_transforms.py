# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Transform messages and trees; truth: products of matrices written by hand."""

import math
import os
from pathlib import Path
from types import SimpleNamespace

from msg_adapters import transforms
from msg_adapters.transforms import StampedTransform
import numpy as np
import pytest
from reference.bags import FORMATS, NOETIC, SECOND, text, transform, write_bag
from ros_rops.core.errors import InputError, ShapeError
from ros_rops.recordings.transforms import read_transforms, TransformTree
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))
OUSTER = DATA.parent / 'recordings' / 'ouster_ros1_profile.mcap'
HALF = math.sqrt(0.5)


def pose(x: float, turn_deg: float = 0.0) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler('z', turn_deg, degrees=True).as_matrix()
    T[0, 3] = x
    return T


def stamped(parent: str, child: str, T: np.ndarray, stamp_ns: int = 0) -> StampedTransform:
    return StampedTransform(parent, child, stamp_ns, T)


def test_a_quarter_turn_by_hand():
    message = transform(7, '/base', 'eye', (1, 2, 3), (0, 0, HALF, HALF)).make(NOETIC)
    found, = transforms.decode(message)
    assert (found.parent, found.child, found.stamp_ns) == ('base', 'eye', 7)
    np.testing.assert_allclose(
        found.T_parent_child, [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]],
        atol=1e-15)


def empty() -> SimpleNamespace:
    return SimpleNamespace(
        header=SimpleNamespace(stamp=SimpleNamespace()), child_frame_id='',
        transform=SimpleNamespace(translation=SimpleNamespace(), rotation=SimpleNamespace()))


def test_round_trip():
    T = np.eye(4)
    T[:3, :3] = Rotation.random(random_state=3).as_matrix()
    T[:3, 3] = [1, -2, 3]
    item, value = empty(), stamped('a', 'b', T, 12 * SECOND + 34)
    transforms.fill(item, value)
    assert type(item.transform.rotation.w) is float
    assert (item.header.stamp.sec, item.header.stamp.nanosec) == (12, 34)
    back = transforms.decode_one(item)
    np.testing.assert_allclose(back.T_parent_child, T, atol=1e-15)
    assert (back.parent, back.child, back.stamp_ns) == ('a', 'b', 12 * SECOND + 34)
    with pytest.raises(ShapeError, match='T_parent_child'):
        transforms.fill(item, stamped('a', 'b', np.eye(3)))


@pytest.mark.parametrize(
    'quaternion', [(0, 0, 0, 0), (0, 0, 0, math.nan), (math.inf, 0, 0, 1), (1e200, 0, 0, 1)])
def test_what_is_no_rotation(quaternion):
    message = transform(7, 'base', 'eye', (1, 2, 3), quaternion).make(NOETIC)
    with pytest.raises(InputError, match='base to eye is no transform'):
        transforms.decode(message)


def test_other_messages():
    with pytest.raises(InputError, match='no TFMessage'):
        transforms.decode(SimpleNamespace())
    with pytest.raises(InputError, match='no sequence'):
        transforms.decode(SimpleNamespace(transforms=3))
    with pytest.raises(InputError, match='no TransformStamped'):
        transforms.decode(SimpleNamespace(transforms=[1]))
    item = empty()
    transforms.fill(item, stamped('a', 'b', np.eye(4)))
    item.transform.rotation.w = 'one'
    with pytest.raises(InputError, match='no numbers'):
        transforms.decode_one(item)


def test_chains_both_ways():
    tree = TransformTree([
        stamped('world', 'base', pose(1, 90)), stamped('base', 'eye', pose(2)),
        stamped('world', 'table', pose(-3)), stamped('moon', 'rock', pose(9))])
    np.testing.assert_allclose(tree.lookup('world', 'eye', 5), pose(1, 90) @ pose(2))
    np.testing.assert_allclose(
        tree.lookup('eye', '/table', 5), np.linalg.inv(pose(1, 90) @ pose(2)) @ pose(-3),
        atol=1e-15)
    np.testing.assert_array_equal(tree.lookup('eye', 'eye'), np.eye(4))
    for target, source in (('world', 'rock'), ('world', 'mars'), ('mars', 'world')):
        assert tree.lookup(target, source, 5) is None
    assert tree.frames == ('world', 'base', 'eye', 'table', 'moon', 'rock')


def test_between_stamps():
    second = SECOND
    tree = TransformTree(moving=[
        stamped('world', 'eye', pose(4, 90), 3 * second),
        stamped('world', 'eye', pose(0), second)])
    np.testing.assert_allclose(tree.lookup('world', 'eye', 2 * second), pose(2, 45), atol=1e-12)
    np.testing.assert_allclose(
        tree.lookup('eye', 'world', 2 * second), np.linalg.inv(pose(2, 45)), atol=1e-12)
    np.testing.assert_array_equal(tree.lookup('world', 'eye', second), pose(0))
    np.testing.assert_array_equal(tree.lookup('world', 'eye', second - 1000), pose(0))
    np.testing.assert_array_equal(tree.lookup('world', 'eye', 3 * second + 1000), pose(4, 90))
    np.testing.assert_array_equal(tree.lookup('world', 'eye'), pose(4, 90))
    assert tree.lookup('world', 'eye', 0) is None
    assert tree.lookup('world', 'eye', 4 * second) is None


def test_rings_and_repeats():
    tree = TransformTree([
        stamped('a', 'b', pose(1)), stamped('b', 'a', pose(-1)), stamped('a', 'a', pose(7))])
    np.testing.assert_array_equal(tree.lookup('a', 'b'), pose(1))
    assert tree.lookup('a', 'c') is None
    again = TransformTree(moving=[stamped('a', 'b', pose(k), 5) for k in range(3)])
    np.testing.assert_array_equal(again.lookup('a', 'b', 5), pose(2))


def moving(tree: TransformTree, seconds: float, x: float, child: str = 'eye') -> None:
    tree.add(stamped('world', child, pose(x), int(seconds * SECOND)))


def test_a_stream_without_end_is_forgotten():
    tree = TransformTree([stamped('base', 'world', pose(1))], span_ns=2 * SECOND)
    for k in range(1000):
        moving(tree, k / 10, k)
        moving(tree, 0.5, 7, 'table')  # has stood still since: another frame's time is no matter
        assert tree.kept <= 1 + 1 + 21
    assert tree.lookup('world', 'eye', 97 * SECOND) is None
    for time, x in ((98, 980), (98.05, 980.5), (99.9, 999)):
        np.testing.assert_allclose(
            tree.lookup('base', 'eye', round(time * SECOND))[0, 3], 1 + x, atol=1e-6)
    np.testing.assert_array_equal(tree.lookup('world', 'table', SECOND // 2), pose(7))


def test_a_clock_set_back_begins_anew():
    tree = TransformTree(span_ns=2 * SECOND)
    moving(tree, 100, 1)
    moving(tree, 99, 2)  # late only
    np.testing.assert_array_equal(tree.lookup('world', 'eye', 99 * SECOND), pose(2))
    moving(tree, 5, 3)
    assert tree.kept == 1
    np.testing.assert_array_equal(tree.lookup('world', 'eye'), pose(3))


def test_how_long_a_transform_holds():
    tree = TransformTree()
    moving(tree, 1, 5)
    at, later = SECOND, SECOND + SECOND // 20
    np.testing.assert_array_equal(tree.lookup('world', 'eye', at, beyond_ns=0), pose(5))
    assert tree.lookup('world', 'eye', later, beyond_ns=0) is None
    np.testing.assert_array_equal(tree.lookup('world', 'eye', later), pose(5))


@pytest.mark.parametrize('kind', FORMATS)
def test_from_recordings(tmp_path, kind):
    records = [
        transform(1, 'world', 'base', (1, 0, 0), topic='/tf_static'),
        transform(2, 'base', 'eye', (0, 1, 0)), transform(SECOND, 'base', 'eye', (0, 2, 0)),
        transform(3, 'cup', 'eye', topic='/exact_poses'), text(4)]
    tree = read_transforms(write_bag(tmp_path, kind, records))
    np.testing.assert_array_equal(tree.lookup('world', 'eye', SECOND)[:3, 3], [1, 2, 0])
    assert tree.lookup('cup', 'eye', SECOND) is None


def test_recording_without_transforms(tmp_path):
    assert read_transforms(write_bag(tmp_path, 'mcap', [text(1)])).frames == ()
    with pytest.raises(InputError, match='cannot be read'):
        read_transforms(tmp_path / 'none.mcap')


@pytest.mark.skipif(not OUSTER.is_file(), reason=f'no recording at {OUSTER}')
def test_real_static_transforms():
    """Ouster's driver: the lidar's frame is turned by half a turn and 36.18 mm up."""
    T = read_transforms(OUSTER).lookup('os1_sensor', 'os1_lidar')
    np.testing.assert_allclose(T[:3, :3], np.diag([-1, -1, 1]), atol=1e-12)
    np.testing.assert_allclose(T[:3, 3], [0, 0, 0.03618])
