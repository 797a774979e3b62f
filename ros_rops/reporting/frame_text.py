# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What became of a frame's points, in words."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ros_rops.core.errors import InputError, ParameterError
from ros_rops.reporting.frame_picture import draw_frame
from ros_rops.reporting.frames import FrameRecord, read_frame, reason_of
from ros_rops.reporting.table import columns, number

FRAMES = 'frames'


def frame_of(name: str) -> str:
    """Return the frame that a view of this name may have been cut from: '<frame>/<number>'."""
    frame, slash, last = name.rpartition('/')
    return frame if slash and last.isdigit() else name


def record_of(run: Path, name: str) -> FrameRecord | None:
    """
    Return what a run folder holds of the frame of a view, None if nothing.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    folder = run / FRAMES
    return read_frame(folder, name) or read_frame(folder, frame_of(name))


def frame_text(document: Mapping[str, Any]) -> str:
    """
    Return points by what became of them, the plane, the views and the notes of a frame.

    Raises
    ------
    InputError
        If the document is none of `frame_document`'s.
    """
    try:
        total = sum(document['counts'].values())
        lines = [f'frame {document["name"]}: {total} points\n']
        rows = [
            ['  ' + str(count), f'{100 * count / total:.2f}%', reason_of(label)]
            for label, count in document['counts'].items() if count]
        lines.append(columns(rows) if rows else '')
        lines.append(_plane_text(document['plane'], document['units']))
        lines += [f'view {view["name"]}: {view["points"]} points\n' for view in document['views']]
        lines += [f'note: {note}\n' for note in document['notes']]
        if not document['segmented']:
            lines.append('plane and objects were not looked for (segmentation.when)\n')
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f'is not a frame of this program ({error!r})') from None
    return ''.join(lines)


def _plane_text(plane: Mapping[str, Any] | None, units: str) -> str:
    if plane is None:
        return ''
    normal = ', '.join(f'{value:.4f}' for value in plane['normal'])
    return (
        f'supporting plane: {plane["distance"]:.5g} {units} from the sensor, seen '
        f'{plane["tilt_deg"]:.1f} deg from its normal ({normal}); {plane["inliers"]} points '
        f'within {number(plane["noise"])} {units} rms\n')


def draw_record(path: Path, record: FrameRecord) -> None:
    """
    Draw a frame that was written without a picture, or draw it again.

    Raises
    ------
    InputError
        If the file cannot be written.
    ParameterError
        If its name does not end in .png.
    """
    if path.suffix.lower() != '.png':
        raise ParameterError(f'--picture: must end in .png, got {path}')
    try:
        draw_frame(
            path, record.document, record.depth, record.label_picture, record.object_picture)
    except OSError as error:
        raise InputError(f'{path}: cannot be written ({error.strerror or error})') from error
