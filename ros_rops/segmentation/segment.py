# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
From a raw sensor frame to the views of its objects.

In this order: depth limits, crop box, background frame; then, of raw frames, the supporting
plane, points that hang between surfaces, connected parts above the plane, the objects these
make, and at last their feet, which reach into the noise of the plane.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.config import SegmentationConfig
from ros_rops.core.frame import Frame
from ros_rops.core.types import Bytes, Ints, RangeView, SupportPlane
from ros_rops.segmentation.crop import crop, drop_background, Lookup
from ros_rops.segmentation.cut import Cut, cut_objects
from ros_rops.segmentation.patches import towards_sensor
from ros_rops.segmentation.plane import Support
from ros_rops.segmentation.result import Label, PlaneFound, Segmentation
from ros_rops.segmentation.scan import is_raw, Scan, scan_of
from ros_rops.segmentation.views import make_view, rays_beyond


def segment(
    frame: Frame,
    config: SegmentationConfig,
    *,
    background: Frame | None = None,
    lookup: Lookup | None = None,
    threads: int = 0,
) -> Segmentation:
    """
    Cut a frame into the views of its objects.

    Parameters
    ----------
    frame : Frame
    config : SegmentationConfig
    background : Frame, optional
        The empty station, seen by the same sensor at the same place.
    lookup : callable, optional
        lookup(target_frame, source_frame, stamp_ns) returns T_target_source (4, 4) in metres, or
        None where it is not known; needed for a crop box in another frame than the sensor's.
    threads : int
        0 takes all cores; the result does not depend on it.

    Returns
    -------
    Segmentation
        Without views where nothing was kept. A frame that says which view it is gives that view.
    """
    scan = scan_of(frame)
    if frame.view is not None:
        return _as_said(frame, frame.view, scan)
    labels = np.where(scan.measured, np.uint8(Label.KEPT), np.uint8(Label.HOLE))
    notes: tuple[str, ...] = ()
    cut = Cut(np.where(scan.measured, np.int32(1), np.int32(0)))
    if config.when != 'never':
        notes = crop(scan, labels, frame, config, lookup)
        if background is not None:
            notes += drop_background(scan, labels, background, config, threads)
        cut = replace(cut, numbers=(labels == Label.KEPT).astype(np.int32))
    segmented = config.when == 'always' or (config.when == 'auto' and is_raw(scan))
    if segmented:
        cut = cut_objects(scan, labels, config)
    return _finished(frame, scan, labels, cut, config, segmented, notes + cut.notes, threads)


def _as_said(frame: Frame, view: RangeView, scan: Scan) -> Segmentation:
    labels = np.where(scan.measured, np.uint8(Label.KEPT), np.uint8(Label.HOLE))
    labels = labels.reshape(frame.points.shape[:-1])
    return Segmentation(
        frame, (view,), labels, np.where(labels == Label.KEPT, 0, -1).astype(np.int16),
        _counts(labels))


def _counts(labels: Bytes) -> dict[Label, int]:
    count = np.bincount(labels.ravel(), minlength=len(Label))
    return {label: int(count[label]) for label in Label}


def _finished(
    frame: Frame, scan: Scan, labels: Bytes, cut: Cut, config: SegmentationConfig,
    segmented: bool, notes: tuple[str, ...], threads: int,
) -> Segmentation:
    order, chosen = _chosen(scan, cut.numbers, config.objects if segmented else 'all')
    index = np.full(int(cut.numbers.max(initial=0)) + 1, -1, np.int16)
    index[order[:chosen]] = np.arange(chosen)
    if chosen < len(order):
        labels[np.isin(cut.numbers, order[chosen:])] = Label.OTHER_OBJECT
    objects = index[cut.numbers].reshape(frame.points.shape[:-1])
    found = None if cut.support is None else _plane_found(scan, cut.support)
    plane = None if found is None else found.plane
    # What is at a depth edge, or too little to be an object, may be no surface at all.
    told = ~np.isin(labels, (Label.HOLE, Label.EDGE, Label.SPECK)).reshape(objects.shape)
    views: list[RangeView] = []
    for k in range(chosen):
        name = frame.name if chosen == 1 else f'{frame.name}/{k}'
        views.append(
            make_view(
                frame, name, objects == k, scan.sensor, plane, segmented, config.most_points,
                threads,
                rays_beyond(frame, objects == k, told & (objects != k)) if segmented else None))
    return Segmentation(
        frame, tuple(views), labels.reshape(objects.shape), objects,
        _counts(labels), found, segmented, notes)


def _chosen(scan: Scan, numbers: Ints, which: str) -> tuple[NDArray, int]:
    """Return the objects' numbers in order, and how many of them become views."""
    sizes = np.bincount(numbers)
    sizes[:1] = 0
    there = np.flatnonzero(sizes)
    if which == 'nearest':
        middle = np.bincount(numbers, scan.depth)[there] / sizes[there]
        order = there[np.argsort(middle, kind='stable')]
    else:
        order = there[np.argsort(-sizes[there], kind='stable')]
    return order, len(order) if which == 'all' else min(1, len(order))


def _plane_found(scan: Scan, support: Support) -> PlaneFound:
    x, y, z = support.plane.normal.tolist()
    plane = SupportPlane((x, y, z), support.plane.offset)
    view = towards_sensor(scan, support.middle[None])[0]
    cosine = float(view @ support.plane.normal / max(np.linalg.norm(view), 1e-300))
    above = float(np.dot(scan.sensor.origin, support.plane.normal)) - support.plane.offset
    return PlaneFound(
        plane, float(np.degrees(np.arccos(np.clip(cosine, -1, 1)))), above, support.inliers,
        support.spread)
