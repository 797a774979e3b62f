# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whatever the bytes, a reader returns a sound view or raises InputError. Truth: invariance."""

import io
from pathlib import Path
import tempfile
from types import SimpleNamespace

from hypothesis import given, settings, strategies as st
from msg_adapters import point_cloud2
import numpy as np
import pytest
from ros_rops.core.errors import InputError
from ros_rops.core.types import RangeView
from ros_rops.recordings import lzf
from ros_rops.recordings.cloud import Cloud, drop_holes, FormatError
from ros_rops.recordings.reader import PARSERS, read_view
from ros_rops.recordings.writers import write_view

QUICK = settings(max_examples=60, deadline=None)


def organized_view() -> RangeView:
    grid = np.array([[0, -1, 1], [2, 3, -1]], np.int32)
    points = np.arange(12.0).reshape(4, 3)
    return RangeView('v', points, grid, colors=np.full((4, 3), 9, np.uint8))


def samples() -> dict[str, bytes]:
    view, buffer = organized_view(), io.BytesIO()
    np.savez(buffer, points=view.points, grid=view.grid)
    with tempfile.TemporaryDirectory() as folder:
        write_view(Path(folder) / 'v.ply', view)
        ply = (Path(folder) / 'v.ply').read_bytes()
    head = ('# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n'
            'WIDTH 2\nHEIGHT 2\nPOINTS 4\nDATA {}\n')
    floats = view.points.astype('<f4').T.tobytes()
    packed = b''.join(bytes([15]) + floats[k:k + 16] for k in range(0, 48, 16))
    sizes = np.array([len(packed), 48], '<u4').tobytes()
    return {
        'ply': ply,
        'pcd': head.format('binary').encode() + floats,
        'pcd ': head.format('binary_compressed').encode() + sizes + packed,
        'pcd  ': head.format('ascii').encode() + b'1 2 3\n' * 4,
        'npz': buffer.getvalue(),
        'xyz': b'# a\n1 2 3 4 5 6\n7,8,9,1,1,1\n',
        'ply ': (b'ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 1\n'
                 b'element vertex 1\nproperty float x\nproperty float y\nproperty float z\n'
                 b'element range_grid 2\nproperty list uchar int vertex_indices\nend_header\n'
                 b'1 2 3\n0\n1 0\n'),
    }


SAMPLES = samples()


def outcome(suffix: str, data: bytes) -> RangeView | None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f'v.{suffix.strip()}'
        path.write_bytes(data)
        try:
            return read_view(path)
        except InputError as error:
            text = str(error)
        assert str(path) in text
        return None


@pytest.mark.parametrize('suffix', SAMPLES)
def test_samples_are_sound(suffix):
    assert outcome(suffix, SAMPLES[suffix]) is not None


@pytest.mark.parametrize('suffix', SAMPLES)
@given(edits=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=6),
       cut=st.integers(0, 60), doubled=st.booleans())
@QUICK
def test_damage(suffix, edits, cut, doubled):
    data = bytearray(SAMPLES[suffix])
    for at, value in edits:
        data[at % len(data)] = value
    data = data[:len(data) - cut] if cut < len(data) else data
    view = outcome(suffix, bytes(data * 2 if doubled else data))
    if view is not None:
        assert np.isfinite(view.points).all()
        assert view.grid is None or view.grid.min(initial=-1) >= -1


@pytest.mark.parametrize('suffix', sorted({s.strip() for s in SAMPLES}))
@given(data=st.binary(max_size=300))
@QUICK
def test_noise(suffix, data):
    for parse_header in (b'', SAMPLES[suffix][:SAMPLES[suffix].find(b'end_header') + 11]):
        try:
            PARSERS[f'.{suffix}'](parse_header + data)
        except FormatError:
            pass


@given(st.binary(max_size=200), st.integers(0, 1000))
@QUICK
def test_lzf_never_overruns(data, size):
    try:
        assert len(lzf.decompress(data, size)) == size
    except FormatError:
        pass


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 2**32 - 1))
@QUICK
def test_channels_stay_aligned(height, width, seed):
    """After holes are dropped, every pixel still leads to its own point and colour."""
    rng = np.random.default_rng(seed)
    points = np.repeat(np.arange(height * width, dtype=float)[:, None], 3, axis=1)
    colors = np.repeat(np.arange(height * width, dtype=np.uint8)[:, None], 3, axis=1)
    holes = rng.random(points.shape) < 0.15
    points[holes] = rng.choice([np.nan, np.inf, -np.inf], holes.sum())
    grid = np.arange(height * width, dtype=np.int32).reshape(height, width)
    clean = drop_holes(Cloud(points, grid, colors))
    np.testing.assert_array_equal(clean.points[:, 0], clean.colors[:, 0])
    whole = ~holes.any(axis=1).reshape(height, width)
    np.testing.assert_array_equal(clean.grid >= 0, whole)
    np.testing.assert_array_equal(clean.points[clean.grid[whole], 0], grid[whole])


small = st.integers(-2, 70)
fields = st.lists(
    st.builds(SimpleNamespace, name=st.sampled_from(['x', 'y', 'z', 'rgb', 'r', 'g', 'b', 'i']),
              offset=small, datatype=st.integers(-1, 10), count=st.integers(-1, 5)),
    max_size=8)
messages = st.builds(
    SimpleNamespace, height=small, width=small, fields=fields, is_bigendian=st.booleans(),
    point_step=small, row_step=st.integers(-2, 5000), data=st.binary(max_size=2000),
    is_dense=st.booleans())


@given(messages)
@settings(max_examples=300, deadline=None)
def test_any_message_decodes_or_is_refused(message):
    try:
        xyz, rgb = point_cloud2.decode(message)
    except InputError:
        return
    assert xyz.shape[-1] == 3
    assert rgb is None or rgb.shape == xyz.shape
    count = message.height * message.width
    assert xyz.size == 3 * count


@given(st.integers(1, 7), st.integers(1, 7), st.permutations('xyz'), st.integers(0, 9),
       st.integers(0, 9), st.booleans())
@QUICK
def test_layout_does_not_matter(height, width, order, gap, pad, big):
    rng = np.random.default_rng(height * width)
    xyz = rng.normal(size=(height, width, 3)).astype(np.float32)
    kind = '>f4' if big else '<f4'
    offsets = {name: gap + k * (4 + gap) for k, name in enumerate(order)}
    step = 3 * (4 + gap) + gap
    data = np.zeros((height, width * step + pad), np.uint8)
    for name, at in offsets.items():
        for u in range(width):
            column = np.ascontiguousarray(xyz[:, u, 'xyz'.index(name)]).astype(kind)
            low = u * step + at
            data[:, low:low + 4] = column.view(np.uint8).reshape(height, 4)
    message = SimpleNamespace(
        height=height, width=width, is_bigendian=big, point_step=step,
        row_step=width * step + pad, data=data.tobytes(), is_dense=True,
        fields=[SimpleNamespace(name=n, offset=at, datatype=7, count=1)
                for n, at in offsets.items()])
    decoded, _ = point_cloud2.decode(message)
    np.testing.assert_array_equal(decoded.reshape(xyz.shape), xyz)
