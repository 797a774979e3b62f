# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Segmentation; truth: analytic scenes, in which it is known what every pixel shows."""

from dataclasses import replace

import numpy as np
import pytest
from reference.stations import Ball, Box, FIRST_BODY, Post, scores, shoot, TABLE
from ros_rops.core.config import SegmentationConfig
from ros_rops.core.frame import Frame
from ros_rops.core.types import RangeView
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.segment import segment

ALWAYS = SegmentationConfig(when='always')
POST = [Post(0, 0, 0.04, 0.1)]
TWO = [Post(-0.09, 0, 0.035, 0.09), Box((0.04, -0.04, 0), (0.1, 0.03, 0.07))]
NOISY = {'noise': 0.004, 'step': 0.001, 'flying': 0.5, 'lost': 0.01}
SCENES = {
    'table': {}, 'wall': {'wall': 0.3}, 'corner': {'wall': 0.26, 'table': 9},
    'all table': {'table': 9}}


def unorganized(shot):
    seen = np.isfinite(shot.frame.points[..., 2])
    return replace(shot.frame, points=shot.frame.points[seen]), shot.body[seen]


@pytest.mark.parametrize('noise', [{}, NOISY], ids=['exact', 'noisy'])
@pytest.mark.parametrize('scene', SCENES)
def test_one_object(scene, noise):
    shot = shoot(POST, **SCENES[scene], **noise)
    result = segment(shot.frame, ALWAYS)
    precision, recall = scores(result.labels == Label.KEPT, shot.body == FIRST_BODY)
    assert precision > 0.99
    assert recall > 0.99
    assert [view.name for view in result.views] == ['frame']
    angle, height = shot.plane_error(result.views[0].support)
    assert angle < (0.01 if noise else 1e-3)
    assert height < (1e-4 if noise else 1e-6)


@pytest.mark.parametrize('noise', [{}, NOISY], ids=['exact', 'noisy'])
def test_two_objects_become_two_views(noise):
    shot = shoot(TWO, wall=0.3, **noise)
    result = segment(shot.frame, ALWAYS)
    assert [view.name for view in result.views] == ['frame/0', 'frame/1']
    assert len(result.views[0].points) > len(result.views[1].points)
    for k in range(2):
        body = np.argmax(np.bincount(shot.body[result.objects == k] + 1)) - 1
        precision, recall = scores(result.objects == k, shot.body == body)
        assert precision > 0.98
        assert recall > 0.94  # a side of the box is seen too flat
    largest = segment(shot.frame, replace(ALWAYS, objects='largest'))
    assert [view.name for view in largest.views] == ['frame']
    np.testing.assert_array_equal(largest.views[0].points, result.views[0].points)
    assert largest.counts[Label.OTHER_OBJECT] == len(result.views[1].points)


def test_nearest_object():
    shot = shoot([Post(0.08, 0.08, 0.05, 0.1), Post(-0.08, -0.1, 0.02, 0.05)])
    result = segment(shot.frame, replace(ALWAYS, objects='nearest'))
    assert scores(result.labels == Label.KEPT, shot.body == FIRST_BODY + 1)[1] > 0.98
    assert len(result.views) == 1


@pytest.mark.parametrize(('noise', 'share', 'reach_m'), [
    ({}, 0.02, 2e-4), ({'noise': 0.001}, 0.06, 1e-3), (NOISY, 0.25, 2.5e-3)])
def test_foot_is_kept(noise, share, reach_m):
    # Of the wall's lowest 3 mm, while the plane's noise reaches up to 0, 0.6 and 2.6 mm.
    shot = shoot(POST, size=(640, 480), **noise)
    kept = segment(shot.frame, ALWAYS).labels == Label.KEPT
    foot = (shot.body == FIRST_BODY) & (shot.height < 0.003)
    lost = foot & ~kept
    assert foot.sum() > 200
    assert lost.sum() <= share * foot.sum()
    assert shot.height[foot & kept].min() < 2e-4
    assert (shot.height[lost] > reach_m).sum() <= 2  # pixels of the silhouette


def test_hovering_part_belongs_to_what_stands_below():
    # The ball hides the middle of the post: two parts of it hold on to the foot.
    shot = shoot([Post(0, 0.02, 0.03, 0.1), Ball((0, -0.06, 0.09), 0.025)])
    result = segment(shot.frame, ALWAYS)
    assert len(result.views) == 1
    assert scores(result.labels == Label.KEPT, shot.body >= FIRST_BODY)[1] > 0.98


def test_only_what_hovers():
    result = segment(shoot([Ball((0, 0, 0.09), 0.03)]).frame, ALWAYS)
    assert len(result.views) == 1
    assert any('nothing touches' in note for note in result.notes)


def test_what_hovers_far_off_is_no_object():
    shot = shoot([Post(-0.12, 0, 0.02, 0.03), Ball((0.12, 0, 0.1), 0.03)])
    result = segment(shot.frame, ALWAYS)
    assert len(result.views) == 1
    assert result.counts[Label.NOT_STANDING] > 300


def test_flat_plate_on_a_noisy_plane():
    shot = shoot([Box((-0.06, -0.04, 0), (0.06, 0.04, 0.006))], **NOISY)
    precision, recall = scores(
        segment(shot.frame, ALWAYS).labels == Label.KEPT, shot.body == FIRST_BODY)
    assert precision > 0.95
    assert recall > 0.99


def test_flying_pixels_are_dropped():
    shot = shoot([Ball((0, 0, 0.09), 0.06)], flying=1.0, wall=0.6, noise=0.001)
    result = segment(shot.frame, ALWAYS)
    # Depths between both sides of a jump, far from any body.
    wrong = (result.labels == Label.KEPT) & (np.abs(
        np.nan_to_num(shot.frame.points[..., 2]) - shot.exact) > 0.02)
    right = (shot.body < 0) & np.isfinite(shot.frame.points[..., 2])
    assert right.sum() > 100
    assert wrong.sum() <= 0.05 * right.sum()
    assert result.counts[Label.EDGE] > 0


@pytest.mark.parametrize('bodies', [POST, TWO], ids=['one', 'two'])
def test_unorganized(bodies):
    frame, body = unorganized(shoot(bodies, wall=0.3, noise=0.004))
    result = segment(frame, ALWAYS)
    assert len(result.views) == len(bodies)
    assert all(view.grid is None for view in result.views)
    precision, recall = scores(result.labels == Label.KEPT, body >= FIRST_BODY)
    assert precision > 0.97
    assert recall > 0.99


def test_millimetres_and_doubles_give_the_same():
    reference = segment(shoot(TWO, **NOISY).frame, ALWAYS)
    other = segment(shoot(TWO, **NOISY, units='mm', kind=np.float64).frame, ALWAYS)
    assert (reference.labels != other.labels).mean() < 1e-3
    assert other.views[0].units == 'mm'
    assert other.views[0].support.offset == pytest.approx(
        1000 * reference.views[0].support.offset, rel=1e-4)


def test_only_a_plane():
    result = segment(shoot([], noise=0.002).frame, ALWAYS)
    assert result.views == ()
    assert result.plane is not None
    assert result.counts[Label.PLANE] > 30000
    assert any('nothing seems to stand' in note for note in result.notes)


def test_no_plane_in_auto_keeps_all_and_says_so():
    shot = shoot([Ball((0, 0, 0.1), 0.3)], eye=(0.0, -0.5, 0.5), target=(0.0, 0.0, 0.1))
    result = segment(shot.frame, SegmentationConfig(plane_least_share=0.5))
    assert any('no supporting plane' in note for note in result.notes)
    assert result.counts[Label.KEPT] == np.isfinite(shot.frame.points[..., 2]).sum()
    assert len(result.views) == 1


def test_auto_leaves_what_was_cut_out_alone():
    shot = shoot(POST, **NOISY)
    points = np.where((shot.body == FIRST_BODY)[..., None], shot.frame.points, np.nan)
    result = segment(replace(shot.frame, points=points), SegmentationConfig())
    assert result.untouched
    assert not result.segmented
    view = result.views[0]
    assert view.grid.shape == shot.body.shape
    np.testing.assert_array_equal(view.grid >= 0, shot.body == FIRST_BODY)
    raw = shoot(POST, table=9)
    assert segment(raw.frame, SegmentationConfig()).segmented
    never = segment(raw.frame, SegmentationConfig(when='never', near_m=0.4))
    assert never.untouched
    frame, _ = unorganized(raw)
    assert segment(frame, SegmentationConfig()).untouched


def test_frame_that_says_its_view():
    view = RangeView('said', np.ones((3, 3)))
    shot = shoot(POST, table=9)
    result = segment(replace(shot.frame, view=view), ALWAYS)
    assert result.views == (view,)
    assert result.untouched


def test_depth_limits():
    shot = shoot(POST, wall=0.3)
    depth = shot.frame.points[..., 2]
    config = SegmentationConfig(near_m=0.5, far_m=0.6)
    labels = segment(shot.frame, config).labels
    with np.errstate(invalid='ignore'):
        np.testing.assert_array_equal(labels == Label.TOO_NEAR, depth < 0.5)
        np.testing.assert_array_equal(labels == Label.TOO_FAR, depth > 0.6)


def test_crop_box_in_another_frame():
    shot = shoot(POST, wall=0.3)
    asked = []

    def lookup(target, source, stamp_ns):
        asked.append((target, source, stamp_ns))
        return np.linalg.inv(shot.T_sensor_world)

    config = SegmentationConfig(
        when='auto', box_frame='world', box_low_z_m=0.02, box_high_y_m=0.2)
    frame = replace(shot.frame, stamp_ns=7)
    result = segment(frame, replace(config, plane=False, least_points=1), lookup=lookup)
    assert asked == [('world', 'camera', 7)]
    kept = (shot.body == FIRST_BODY) & (shot.height > 0.021)
    assert set(np.unique(result.labels[kept])) <= {Label.KEPT, Label.EDGE}
    assert (result.labels[shot.body == TABLE] == Label.OUTSIDE_BOX).all()
    lost = segment(frame, config, lookup=lambda *_: None)
    assert lost.views == ()
    assert 'world' in lost.notes[0]
    assert lost.counts[Label.KEPT] == 0


def test_crop_box_in_the_sensor_frame():
    shot = shoot(POST)
    result = segment(shot.frame, SegmentationConfig(when='auto', box_low_x_m=0.01))
    with np.errstate(invalid='ignore'):
        np.testing.assert_array_equal(
            result.labels == Label.OUTSIDE_BOX, shot.frame.points[..., 0] < np.float32(0.01))


@pytest.mark.parametrize('plane', [True, False])
def test_background(plane):
    empty = shoot([], noise=0.002, wall=0.3, seed=4).frame
    shot = shoot(POST, noise=0.002, wall=0.3)
    result = segment(shot.frame, replace(ALWAYS, plane=plane), background=empty)
    precision, recall = scores(result.labels == Label.KEPT, shot.body == FIRST_BODY)
    assert precision > 0.999
    assert recall > 0.96
    assert result.counts[Label.BACKGROUND] > 60000
    assert (result.plane is not None) == plane


def test_background_of_another_kind():
    empty, _ = unorganized(shoot([], noise=0.001, wall=0.3, seed=4))
    shot = shoot(POST, noise=0.001, wall=0.3)
    result = segment(shot.frame, ALWAYS, background=empty)
    assert 'another size' in result.notes[0]
    assert scores(result.labels == Label.KEPT, shot.body == FIRST_BODY)[1] > 0.94
    frame, body = unorganized(shot)
    cloud = segment(frame, SegmentationConfig(), background=empty)
    assert min(scores(cloud.labels == Label.KEPT, body == FIRST_BODY)) > 0.9


@pytest.mark.parametrize('most', [500, 1500])
def test_reduced_views(most):
    shot = shoot(POST, size=(640, 480))
    colors = np.full(shot.frame.points.shape, 9, np.uint8)
    frame = replace(shot.frame, colors=colors)
    whole = segment(frame, ALWAYS).views[0]
    view = segment(frame, replace(ALWAYS, most_points=most)).views[0]
    assert most / 2 < len(view.points) <= 1.3 * most
    assert view.support == whole.support
    assert (view.colors == 9).all()
    pixels = view.grid[view.grid >= 0]
    np.testing.assert_array_equal(np.sort(pixels), np.arange(len(view.points)))
    # Means of points of the post lie within it, not far below its surface.
    world = np.linalg.inv(shot.T_sensor_world)
    place = view.points @ world[:3, :3].T + world[:3, 3]
    around = np.hypot(place[:, 0], place[:, 1])
    assert around.max() < 0.0405  # a few of the table at the foot
    assert ((around > 0.037) | (place[:, 2] > 0.095)).mean() > 0.99


def test_reduced_cloud():
    random = np.random.default_rng(0)
    points = random.normal(size=(60000, 3))
    points *= 0.1 / np.linalg.norm(points, axis=1, keepdims=True)
    frame = Frame('cloud', (points + np.array([0, 0, 1])).astype(np.float32))
    view = segment(frame, SegmentationConfig(most_points=4000)).views[0]
    assert 2500 < len(view.points) <= 4800
    radius = np.linalg.norm(view.points - [0, 0, 1], axis=1)
    assert radius.max() < 0.1001
    assert radius.min() > 0.097


def test_threads_and_repetition_change_nothing():
    shot = shoot(TWO, wall=0.3, **NOISY)
    frame, _ = unorganized(shot)
    for one in (shot.frame, frame):
        first, second = (segment(one, ALWAYS, threads=n) for n in (1, 2))
        np.testing.assert_array_equal(first.labels, second.labels)
        for a, b in zip(first.views, second.views, strict=True):
            assert a.points.tobytes() == b.points.tobytes()
            assert a.support == b.support
