# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What drops points by their place alone: depth limits, a crop box, a background frame."""

from collections.abc import Callable

import numpy as np
from ros_rops.core.config import SegmentationConfig
from ros_rops.core.frame import Frame
from ros_rops.core.types import Bytes, Floats
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.scan import Scan, scan_of
from scipy import ndimage
from scipy.spatial import cKDTree

Lookup = Callable[[str, str, int | None], Floats | None]
UNBOUNDED_M = 1e6


def crop(
    scan: Scan, labels: Bytes, frame: Frame, config: SegmentationConfig, lookup: Lookup | None
) -> tuple[str, ...]:
    """
    Label what lies outside of the depth limits and of the box; return notes.

    Where the box's frame is not known at the frame's time, everything is outside of the box.
    """
    depth = scan.depth
    if config.near_m > 0:
        labels[scan.measured & (depth < config.near_m * scan.scale)] = Label.TOO_NEAR
    if config.far_m < UNBOUNDED_M:
        labels[scan.measured & (depth > config.far_m * scan.scale)] = Label.TOO_FAR
    limits = [(getattr(config, f'box_low_{axis}_m'), getattr(config, f'box_high_{axis}_m'))
              for axis in 'xyz']
    if all(low <= -UNBOUNDED_M and high >= UNBOUNDED_M for low, high in limits):
        return ()
    pose = _pose(frame, config.box_frame, lookup)
    kept = labels == Label.KEPT
    if pose is None:
        labels[kept] = Label.OUTSIDE_BOX
        return (f'no transform from {frame.frame_id!r} to {config.box_frame!r} at its '
                'time: the crop box cannot be placed and everything is outside of it',)
    inside = np.ones(len(kept), bool)
    for row, (low, high) in zip(pose, limits, strict=True):
        value = scan.along(row[:3]) + scan.z.dtype.type(row[3] * scan.scale)
        if low > -UNBOUNDED_M:
            inside &= value >= low * scan.scale
        if high < UNBOUNDED_M:
            inside &= value <= high * scan.scale
    labels[kept & ~inside] = Label.OUTSIDE_BOX
    return ()


def _pose(frame: Frame, target: str, lookup: Lookup | None) -> Floats | None:
    """Return the sensor's pose in the box's frame (3, 4), in metres; None where unknown."""
    if target in ('', frame.frame_id):
        return np.eye(4)[:3]
    found = None if lookup is None else lookup(target, frame.frame_id, frame.stamp_ns)
    return None if found is None else found[:3]


def drop_background(
    scan: Scan, labels: Bytes, background: Frame, config: SegmentationConfig, threads: int
) -> tuple[str, ...]:
    """
    Label what the background frame shows too; return notes.

    Organized frames of one size are compared pixel by pixel: a point is background unless it is
    nearer than the nearest background within a pixel, which forgives edges that flicker. Others
    are compared by the distance to the nearest point of the background.
    """
    known = scan_of(background)
    if scan.shape is not None and scan.shape == known.shape:
        limit = scan.scale / known.scale * np.where(known.measured, known.depth, np.inf)
        limit = ndimage.minimum_filter(known.image(limit), size=3, mode='nearest').ravel()
        metres = scan.depth / scan.scale
        tolerance = config.background_m * scan.scale * np.maximum(metres, metres**2)
        # Where the background was not measured within a pixel, nothing is known.
        same = np.isfinite(limit) & (scan.depth >= limit - tolerance)
        labels[same & (labels == Label.KEPT)] = Label.BACKGROUND
        return ()
    kept = np.flatnonzero(labels == Label.KEPT)
    points = known.take(known.measured) * (scan.scale / known.scale)
    if len(kept) and len(points):
        reach = config.background_m * scan.scale
        distance, _ = cKDTree(points).query(
            scan.take(kept), distance_upper_bound=reach, workers=threads or -1)
        labels[kept[np.isfinite(distance)]] = Label.BACKGROUND
    if scan.shape is None and known.shape is None:
        return ()
    return ('the background frame has another size: compared by the nearest point',)
