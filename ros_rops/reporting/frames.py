# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What was cut out of each frame, as files of a run folder's `frames/`.

| file | what |
|---|---|
| `<frame>.json` | points by what became of them, the plane found, the views made, notes |
| `<frame>.npz` | the label of every point, and a depth picture, so that it can be drawn later |
| `<frame>.png` | the frame's depth, its labels, the points kept |
"""

from collections.abc import Mapping
from dataclasses import dataclass
import json
from pathlib import Path
import re
from typing import Any
import zipfile
import zlib

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame, LARGEST
from ros_rops.core.types import Bytes
from ros_rops.reporting.frame_picture import draw_frame
from ros_rops.segmentation.result import Label, PlaneFound, REASONS, Segmentation

WIDEST = 640
"""Depth pictures are thinned to at most this many pixels across."""
DEEPEST = 4094
"""Depths are kept as whole shares of their range; one more is a hole."""


@dataclass(frozen=True, slots=True)
class FrameRecord:
    """
    What `read_frame` finds of a frame.

    Parameters
    ----------
    document : mapping
        The content of the JSON file.
    labels : (H, W) or (N,) uint8
        `ros_rops.segmentation.result.Label` of every point.
    objects : (H, W) or (N,) int16
        Index of the view that each point went to, -1 for none.
    depth, label_picture, object_picture : (h, w)
        Thinned to be drawn; the depth is NaN where nothing was measured, in the frame's units.
    """

    document: Mapping[str, Any]
    labels: Bytes
    objects: NDArray[np.int16]
    depth: NDArray[np.float32]
    label_picture: Bytes
    object_picture: NDArray[np.int16]


def write_frame(folder: Path, segmentation: Segmentation, *, picture: bool = True) -> Path:
    """
    Write what became of a frame into `folder` (made if need be) and return the JSON's path.

    Parameters
    ----------
    folder : Path
        `frames/` of a run folder.
    segmentation : Segmentation
    picture : bool
        Whether to draw the PNG too (a third of a second; it can be drawn later).

    Raises
    ------
    InputError
        If a file cannot be written; the text names it.
    """
    frame = segmentation.frame
    path = folder / f'{file_stem(frame.name)}.json'
    depth, labels, objects = _pictures(segmentation)
    document = frame_document(segmentation)
    record = FrameRecord(
        document, segmentation.labels, segmentation.objects, depth, labels, objects)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write_arrays(path.with_suffix('.npz'), record)
        if picture:
            draw_frame(path.with_suffix('.png'), document, depth, labels, objects)
        text = json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False)
        path.write_text(text + '\n', encoding='utf-8')
    except OSError as error:
        place = error.filename or folder
        raise InputError(f'{place}: cannot be written ({error.strerror or error})') from error
    return path


def read_frame(folder: Path, name: str) -> FrameRecord | None:
    """
    Return what `write_frame` wrote of a frame, None if it wrote nothing.

    Raises
    ------
    InputError
        If the files are there and cannot be read.
    """
    path = folder / f'{file_stem(name)}.json'
    if not path.exists():
        return None
    try:
        document = json.loads(path.read_text(encoding='utf-8'))
        # Opened here: NumPy leaves a damaged file open.
        with path.with_suffix('.npz').open('rb') as stream, np.load(
                stream, allow_pickle=False) as arrays:
            shares = arrays['depth']
            low, high = arrays['limits']
            depth = np.where(
                shares > DEEPEST, np.nan, low + (high - low) * (shares / DEEPEST))
            return FrameRecord(
                document, arrays['labels'], arrays['objects'], depth.astype(np.float32),
                arrays['label_picture'], arrays['object_picture'])
    except (OSError, ValueError, KeyError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f'{path}: cannot be read as a frame ({error})') from None


def frame_names(folder: Path) -> list[str]:
    """Return the names of the frames that were written into a folder, sorted."""
    names = []
    for path in sorted(folder.glob('*.json')):
        try:
            names.append(str(json.loads(path.read_text(encoding='utf-8'))['name']))
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(f'{path}: cannot be read as a frame ({error!r})') from None
    return sorted(names)


def file_stem(name: str) -> str:
    """Return a file name for a frame: its own where that is one, else with a checksum added."""
    plain = re.sub(r'[^A-Za-z0-9@._-]+', '_', name.strip('/')).strip('._')[-120:]
    if plain and plain == name:
        return plain
    return f'{plain or "frame"}-{zlib.crc32(name.encode("utf-8")):08x}'


def frame_document(segmentation: Segmentation) -> dict[str, Any]:
    """Return what the JSON file says; lengths in the frame's units."""
    frame = segmentation.frame
    return {
        'name': frame.name,
        'topic': frame.topic,
        'frame_id': frame.frame_id,
        'stamp_ns': frame.stamp_ns,
        'units': frame.units,
        'shape': list(frame.points.shape[:-1]),
        'segmented': segmentation.segmented,
        'counts': {label.name.lower(): segmentation.counts[label] for label in Label},
        'plane': None if segmentation.plane is None else plane_document(segmentation.plane),
        'views': [
            {'name': view.name, 'points': len(view.points)} for view in segmentation.views],
        'notes': list(segmentation.notes),
    }


def plane_document(found: PlaneFound) -> dict[str, Any]:
    """Return what is said of a supporting plane."""
    return {
        'normal': list(found.plane.normal), 'offset': found.plane.offset,
        'tilt_deg': found.tilt_deg, 'distance': found.distance, 'inliers': found.inliers,
        'noise': found.noise,
    }


def reason_of(label: str) -> str:
    """Return the sentence for a label of a JSON file."""
    return REASONS[Label[label.upper()]]


def _pictures(
    segmentation: Segmentation
) -> tuple[NDArray[np.float32], Bytes, NDArray[np.int16]]:
    """Return depth, labels and objects as images of at most `WIDEST` pixels across."""
    frame = segmentation.frame
    if not frame.organized:
        return _rasters(frame, segmentation.labels, segmentation.objects)
    step = max(1, -(-max(frame.points.shape[:2]) // WIDEST))
    thin = (slice(step // 2, None, step), slice(step // 2, None, step))
    labels = segmentation.labels[thin]
    points = np.where((labels > 0)[..., None], frame.points[thin], np.nan)
    return _distance(points), labels, segmentation.objects[thin]


def _distance(points: NDArray) -> NDArray[np.float32]:
    distance: NDArray[np.float32] = np.sqrt(
        (points.astype(np.float64)**2).sum(axis=-1)).astype(np.float32)
    return distance


def _rasters(
    frame: Frame, labels: Bytes, objects: NDArray[np.int16]
) -> tuple[NDArray[np.float32], Bytes, NDArray[np.int16]]:
    """Return an unorganized frame as seen along z, the nearest point of each pixel."""
    good = np.flatnonzero((np.abs(frame.points) <= LARGEST).all(axis=1))
    height, width = WIDEST * 3 // 8, WIDEST // 2
    depth = np.full(height * width, np.nan, np.float32)
    of_label, of_object = np.zeros(height * width, np.uint8), np.full(
        height * width, -1, np.int16)
    if len(good):
        points = frame.points[good].astype(np.float64)
        ahead = bool((points[:, 2] > 0).all())
        flat = points[:, :2] / (points[:, 2:] if ahead else 1.0)
        low, span = flat.min(axis=0), np.maximum(np.ptp(flat, axis=0), 1e-12)
        scale = min((width - 1) / span[0], (height - 1) / span[1])
        column, row = np.rint((flat - low) * scale).astype(np.int64).T
        distance = _distance(points)
        order = np.argsort(-distance, kind='stable')  # the nearest is written last
        pixel, good = (row * width + column)[order], good[order]
        depth[pixel], of_label[pixel] = distance[order], labels[good]
        of_object[pixel] = objects[good]
    shape = (height, width)
    return depth.reshape(shape), of_label.reshape(shape), of_object.reshape(shape)


def _write_arrays(path: Path, record: FrameRecord) -> None:
    depth = record.depth
    known = np.isfinite(depth)
    low, high = (float(depth[known].min()), float(depth[known].max())) if known.any() else (0, 1)
    shares = (np.where(known, depth, low) - low) / max(high - low, 1e-30) * DEEPEST
    arrays: dict[str, NDArray[Any]] = {
        'labels': record.labels, 'objects': record.objects, 'limits': np.array([low, high]),
        'depth': np.where(known, np.rint(shares), DEEPEST + 1).astype(np.uint16),
        'label_picture': record.label_picture, 'object_picture': record.object_picture}
    # As `np.savez_compressed` does, which knows no faster level; runs wait for this.
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays.items():
            with archive.open(f'{name}.npy', 'w', force_zip64=True) as stream:
                np.lib.format.write_array(stream, np.asarray(array), allow_pickle=False)
