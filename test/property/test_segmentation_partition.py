# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What holds of every frame. Truth: the definition of labels and views."""

from hypothesis import given, HealthCheck, settings, strategies
import numpy as np
from reference.stations import Box, Post, shoot
from ros_rops.core.config import SegmentationConfig, SelectionConfig
from ros_rops.core.frame import Frame
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.segment import segment
from ros_rops.segmentation.selection import Selector

CHECKS = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@strategies.composite
def frames(draw):
    """Draw a scene with holes, a random cloud, or odd numbers, of any small shape."""
    random = np.random.default_rng(draw(strategies.integers(0, 2**32 - 1)))
    kind = draw(strategies.sampled_from(['scene', 'scene', 'random', 'odd']))
    shape = draw(strategies.sampled_from(
        [(0,), (1,), (7,), (300,), (1, 1), (1, 40), (11, 50), (30, 40), (48, 64), (0, 5)]))
    if kind == 'scene':
        points = shoot(
            [Post(0, 0, 0.05, 0.1), Box((0.1, 0.05, 0), (0.15, 0.1, 0.05))], size=(64, 48),
            wall=0.3, noise=0.003, lost=draw(strategies.floats(0, 0.9)),
            seed=int(random.integers(99))).frame.points
    else:
        points = random.normal(size=(*shape, 3)).astype(np.float32)
        if kind == 'odd' and points.size:
            odd = np.array([np.nan, np.inf, -np.inf, 0, 1e30, -1e30, 1e-30, 5], np.float32)
            mask = random.random(points.shape) < 0.3
            points[mask] = random.choice(odd, mask.sum())
    colors = None
    if draw(strategies.booleans()):
        colors = random.integers(0, 255, points.shape).astype(np.uint8)
    return Frame('f', points, colors)


CONFIGS = strategies.builds(
    SegmentationConfig, when=strategies.sampled_from(['auto', 'always', 'never']),
    near_m=strategies.sampled_from([0.0, 0.3]), far_m=strategies.sampled_from([1e6, 0.6]),
    box_low_x_m=strategies.sampled_from([-1e6, 0.0]), plane=strategies.booleans(),
    objects=strategies.sampled_from(['all', 'largest', 'nearest']),
    least_points=strategies.sampled_from([1, 30]))


@CHECKS
@given(frames(), CONFIGS, strategies.booleans())
def test_labels_partition_the_frame(frame, config, with_background):
    result = segment(frame, config, background=frame if with_background else None)
    points, labels, objects = (
        frame.points.reshape(-1, 3), result.labels.ravel(), result.objects.ravel())
    assert sum(result.counts.values()) == len(points)
    assert labels.shape == objects.shape == points.shape[:1]
    holes = ~(np.abs(points) <= 1e15).all(axis=1)
    np.testing.assert_array_equal(labels == Label.HOLE, holes)
    np.testing.assert_array_equal(objects >= 0, labels == Label.KEPT)
    assert len(result.views) == objects.max(initial=-1) + 1
    for k, view in enumerate(result.views):
        np.testing.assert_array_equal(view.points, points[objects == k].astype(np.float64))
        if frame.colors is not None:
            np.testing.assert_array_equal(view.colors, frame.colors.reshape(-1, 3)[objects == k])
        if frame.organized:
            pixels = view.grid[view.grid >= 0]
            np.testing.assert_array_equal(pixels, np.arange(len(view.points)))


@CHECKS
@given(strategies.lists(frames(), max_size=4))
def test_selection_takes_any_frame(stream):
    for method in ('every', 'stride', 'still'):
        first, second = (Selector(SelectionConfig(method=method)) for _ in range(2))
        assert [first.decide(frame) for frame in stream] == [
            second.decide(frame) for frame in stream]
