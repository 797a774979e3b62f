# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Rays that pass by an object: cut out, kept and used with it. Truth: a scene made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from ros_rops.core.errors import ShapeError
from ros_rops.core.frame import Frame
from ros_rops.core.types import RangeView
from ros_rops.pipeline.units import in_units
from ros_rops.recordings.frames import frame_view, read_frames
from ros_rops.recordings.mcap_writer import McapStream
from ros_rops.recordings.reader import read_view
from ros_rops.recordings.view_facts import ViewFacts
from ros_rops.recordings.writers import write_view
from ros_rops.segmentation.views import RAYS, rays_beyond

SHAPE = (120, 160)


@pytest.fixture
def scene():
    """Return a frame of a wall at 1 m, an object at 0.5 m in it, and the masks."""
    rows, columns = np.mgrid[:SHAPE[0], :SHAPE[1]]
    kept = (abs(rows - 60) < 15) & (abs(columns - 80) < 20)
    z = np.where(kept, 0.5, 1.0)
    points = np.stack([(columns - 80) / 150 * z, (rows - 60) / 150 * z, z], axis=-1)
    return Frame('f', points.astype(np.float32)), kept


def test_rays_are_those_around_the_object_and_end_where_they_were_measured(scene):
    frame, kept = scene
    rays = rays_beyond(frame, kept, ~kept)
    assert rays.dtype == np.float32
    assert RAYS / 5 < len(rays) <= RAYS
    assert np.allclose(rays[:, 2], 1.0)
    pixels = rays[:, :2] / rays[:, 2:] * 150 + (80, 60)
    inside = (abs(pixels - (80, 60)) < (20, 15)).all(axis=1)
    assert not inside.any()
    # Beside the object as far as it is large.
    assert np.ptp(pixels[:, 0]) == pytest.approx(3 * 39, abs=6)


def test_nothing_told_or_kept_gives_no_rays(scene):
    frame, kept = scene
    assert rays_beyond(frame, kept, np.zeros_like(kept)) is None
    assert rays_beyond(frame, np.zeros_like(kept), ~kept) is None
    loose = Frame('g', frame.points.reshape(-1, 3))
    assert rays_beyond(loose, kept.reshape(-1), ~kept.reshape(-1)) is None


@pytest.fixture
def view(scene):
    frame, kept = scene
    grid = np.full(SHAPE, -1, np.int32)
    grid[kept] = np.arange(kept.sum())
    return RangeView(
        'f', frame.points[kept].astype(float), grid, units='m', stamp_ns=5, frame_id='camera',
        beyond=rays_beyond(frame, kept, ~kept))


def test_a_recording_keeps_them_bit_by_bit(view, tmp_path):
    path = tmp_path / 'one.mcap'
    with path.open('wb') as stream:
        writer = McapStream(stream, name=str(path))
        writer.add_view(view, topic='/points', log_time_ns=5)
        writer.finish()
    back, = (frame_view(frame).view for frame in read_frames(path))
    assert np.array_equal(back.beyond, view.beyond)
    assert back.beyond.dtype == np.float32


def test_a_view_file_keeps_them_bit_by_bit(view, tmp_path):
    path = tmp_path / 'f.ply'
    write_view(path, view, facts=ViewFacts(
        '/points', 'view', view.name, view.units, view.sensor, view.stamp_ns, view.frame_id,
        beyond=view.beyond))
    assert np.array_equal(read_view(path).beyond, view.beyond)


def test_units_go_with_the_points(view):
    assert np.allclose(in_units(view, 'mm').beyond, view.beyond * 1000.0)


@pytest.mark.parametrize('bad', [np.zeros(3), np.zeros((2, 2)), np.full((2, 3), np.nan)])
def test_what_is_no_set_of_points_is_refused(view, bad):
    with pytest.raises(ShapeError, match='beyond'):
        replace(view, beyond=bad)
