# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A raw frame's objects: above the supporting plane, standing on it, feet included."""

from dataclasses import dataclass, replace

import numpy as np
from ros_rops.core.config import SegmentationConfig
from ros_rops.core.types import Bools, Bytes, Ints
from ros_rops.segmentation.cells import spacing_of
from ros_rops.segmentation.ground import Ground, ground_of
from ros_rops.segmentation.objects import group_parts, look_at_parts, Part
from ros_rops.segmentation.parts import Parts, parts_of_pixels, parts_of_points
from ros_rops.segmentation.patches import patches_of
from ros_rops.segmentation.plane import find_support, Support
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.scan import dot, Image, pitch_of, Scan

SMALLEST_IMAGE = 12
"""An organized frame with a shorter side is treated as an unorganized one."""


@dataclass(frozen=True, slots=True)
class Cut:
    """Object of every point (N,) from 1 on, 0 for none; the plane; what is to be said."""

    numbers: Ints
    support: Support | None = None
    notes: tuple[str, ...] = ()


def cut_objects(scan: Scan, labels: Bytes, config: SegmentationConfig) -> Cut:
    """
    Find the plane and the objects on it; label the points that are on none.

    Parameters
    ----------
    scan : Scan
    labels : (N,) uint8
        Changed in place; points labelled KEPT may be of an object, BACKGROUND ones still tell
        where the plane is.
    config : SegmentationConfig
    """
    if scan.shape is not None and min(scan.shape) < SMALLEST_IMAGE:
        scan = replace(scan, shape=None)
    usable = labels == Label.KEPT
    pitch = pitch_of(scan) if scan.shape else (0.0, 0.0)
    support, notes = _support(scan, labels, pitch, config)
    if support is None and config.plane and config.when == 'auto':
        return Cut(usable.astype(np.int32), None, (*notes, 'all that is measured was kept'))
    heights, band = _above(scan, support, config.plane_band)
    up = usable & (heights > band)
    if support is not None:
        _label_plane(scan, labels, heights, band, support)
    if scan.shape:
        step = sum(pitch) / 2
        parts = parts_of_pixels(scan, usable, up, band / config.plane_band, pitch, config)
    else:
        step = spacing_of(scan.take(usable))
        parts = parts_of_points(scan, up, step)
    labels[up & parts.hanging] = Label.EDGE
    numbers, more = _objects(scan, labels, heights, band, support, step, parts, config)
    if support is not None:
        parts.grow_feet(numbers, usable, heights, band, step)
    labels[numbers > 0] = Label.KEPT
    labels[up & (numbers == 0) & (labels == Label.KEPT)] = Label.SPECK
    return Cut(numbers, support, notes + more)


def _support(
    scan: Scan, labels: Bytes, pitch: tuple[float, float], config: SegmentationConfig
) -> tuple[Support | None, tuple[str, ...]]:
    if not config.plane:
        return None, ()
    seen = (labels == Label.KEPT) | (labels == Label.BACKGROUND)
    support = find_support(scan, patches_of(scan, seen, pitch), seen, config.plane_least_share)
    if support is None:
        return None, ('no supporting plane found',)
    if not support.carries:
        return support, ('nothing seems to stand on the largest plane',)
    return support, ()


def _above(scan: Scan, support: Support | None, times: float) -> tuple[Image, Image]:
    """Return the height of every point over the plane, and how far the plane's noise reaches."""
    if support is None:
        return np.ones_like(scan.z), np.zeros_like(scan.z)
    heights = scan.along(support.plane.normal) - scan.z.dtype.type(support.plane.offset)
    return heights, support.noise.at(scan.depth) * scan.z.dtype.type(times)


def _label_plane(
    scan: Scan, labels: Bytes, heights: Image, band: Image, support: Support
) -> None:
    kept = labels == Label.KEPT
    labels[kept & (heights < -band)] = Label.BELOW_PLANE
    flat = np.flatnonzero(kept & (np.abs(heights) <= band))
    u, v = (scan.along(axis, flat) for axis in support.extent.axes)
    over = support.extent.holds_about(u, v)
    labels[flat] = np.where(over, np.uint8(Label.PLANE), np.uint8(Label.BESIDE_PLANE))


def _objects(
    scan: Scan, labels: Bytes, heights: Image, band: Image, support: Support | None, step: float,
    found: Parts, config: SegmentationConfig,
) -> tuple[Ints, tuple[str, ...]]:
    """Return the object of every point, the parts that make none labelled; and notes."""
    numbers = found.numbers
    parts = look_at_parts(
        scan, numbers, found.count, heights, band, support, step, labels)
    doubt = any(not part.stands and part.size >= config.least_points for part in parts)
    if support is not None and doubt:
        parts = _with_ground(parts, ground_of(scan, labels, support))
    plane = scan.image(labels == Label.PLANE) if scan.shape else None
    objects, lost = group_parts(parts, config.gap_m * scan.scale, config.least_points, plane)
    table = np.zeros(found.count + 1, np.int32)
    fate = np.zeros(found.count + 1, np.uint8)
    for part in lost:
        fate[list(part.numbers)] = Label.NOT_STANDING
    for part in objects:
        if part.size < config.least_points:
            fate[list(part.numbers)] = Label.SPECK
        else:
            table[list(part.numbers)] = table.max() + 1
    dropped: Bools = fate[numbers] > 0
    labels[dropped] = fate[numbers[dropped]]
    result: Ints = table[numbers]
    return result, _notes([part for part in objects if part.size >= config.least_points], lost)


def _with_ground(parts: list[Part], ground: Ground) -> list[Part]:
    """Tell of parts where they are on the plane, and how much of it is hidden by what hovers."""
    return [
        replace(
            part, places=np.stack([dot(part.sample, axis) for axis in ground.axes], axis=1),
            hidden=0.0 if part.stands else ground.hidden_below(part.sample))
        for part in parts]


def _notes(objects: list[Part], lost: list[Part]) -> tuple[str, ...]:
    """Say what was taken or left in doubt."""
    notes = []
    if any(not part.stands for part in objects):
        notes.append('nothing touches the plane: what hovers over it was taken')
    if any(part.reaches for part in objects):
        notes.append('an object reaches out of the image')
    if any(part.reaches for part in lost):
        notes.append('what reaches into the image and touches nothing was left out')
    return tuple(notes)
