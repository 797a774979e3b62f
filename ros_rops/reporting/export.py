# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The result of a run as an MCAP recording that RViz, Foxglove and PlotJuggler open.

| topic | what |
|---|---|
| `/tf_static` | TFMessage: `object_<id>` to `object_<id>/view_<n>`, n counting in `poses.json` |
| `/object_<id>/cloud` | PointCloud2: x, y, z, rgb, normal_x, normal_y, normal_z, view_id, ... |
| `/view_reports` | String, JSON of one view: its word and its numbers, as in `poses.json` |

The clouds are those of `object_<id>.ply`: of a model they have weight and directions, too (how
many views saw the point). Lengths are in metres, as ROS has them. Each object is a tree of frames
of its own: where objects stand to each other, no registration tells.
"""

from collections.abc import Mapping
import json
import os
from pathlib import Path
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import InputError
from ros_rops.recordings.cdr import Transform
from ros_rops.recordings.cloud import FormatError
from ros_rops.recordings.files import read_bytes
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.mcap_writer import McapStream
from ros_rops.recordings.ply import parse_vertices
from ros_rops.reporting.poses_file import read_document

Columns = Mapping[str, NDArray[Any]]

REPORT_TOPIC = '/view_reports'
COLORS = ('red', 'green', 'blue')
NEEDED = ('x', 'y', 'z', 'nx', 'ny', 'nz', 'view_id')
OF_MODELS = {'weight': np.float32, 'directions': np.int32}
"""Columns that the cloud of a model has, and a plain one has not; in four bytes, so that all lie
even."""
LOG_TIME = re.compile(r'@(\d{1,19})(?!.*@\d)')


def export_run(folder: str | os.PathLike[str], path: str | os.PathLike[str]) -> dict[str, Any]:
    """
    Write the result in a run folder as an MCAP file; return the content of its `poses.json`.

    Raises
    ------
    InputError
        If the folder holds no whole result, or the file cannot be written.
    """
    document = read_document(Path(folder) / 'poses.json')
    clouds = {
        int(shape['id']): _read_cloud(Path(folder), int(shape['id']))
        for shape in document['objects']}
    with create_mcap(path) as mcap:
        write_result(mcap, document, clouds)
    return document


def write_result(
    mcap: McapStream, document: Mapping[str, Any], clouds: Mapping[int, Columns]
) -> None:
    """
    Write poses, clouds and reports.

    Parameters
    ----------
    mcap : McapStream
    document : mapping
        Content of `poses.json` (`poses_document`).
    clouds : mapping of int to mapping of str to (N,) arrays
        The columns of its file by the number of the object; in the document's units.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    scale = 0.001 if document['units'] == 'mm' else 1.0
    place = {view['name']: k for k, view in enumerate(document['views'])}
    stamp = _stamp([str(view['name']) for view in document['views']])
    transforms, frames = [], {}
    for shape in document['objects']:
        for view in shape['views']:
            T = np.array(view['T_object_view'], np.float64)
            T[:3, 3] *= scale
            frames[view['name']] = f'object_{shape["id"]}/view_{place[view["name"]]:03d}'
            transforms.append(Transform(T, f'object_{shape["id"]}', frames[view['name']]))
    if transforms:
        mcap.add_transforms(transforms, stamp_ns=stamp, topic='/tf_static')
    for number, cloud in clouds.items():
        _add_cloud(mcap, number, cloud, scale, stamp)
    for view in document['views']:
        report = {**view, 'frame_id': frames.get(view['name'], '')}
        mcap.add_text(json.dumps(report), topic=REPORT_TOPIC, log_time_ns=stamp)


def _add_cloud(mcap: McapStream, number: int, cloud: Columns, scale: float, stamp: int) -> None:
    extra = {f'normal_{axis}': cloud[f'n{axis}'].astype(np.float32) for axis in 'xyz'}
    extra['view_id'] = cloud['view_id'].astype(np.int32)
    extra |= {name: cloud[name].astype(kind) for name, kind in OF_MODELS.items() if name in cloud}
    points = np.stack([cloud[axis] for axis in 'xyz'], axis=1).astype(np.float64) * scale
    colors = None
    if 'red' in cloud:
        colors = np.stack([cloud[name] for name in COLORS], axis=1).astype(np.uint8)
    # Tools read float32 only; it resolves a hundredth of a micrometre at 0.1 m.
    mcap.add_cloud(
        points.astype(np.float32), topic=f'/object_{number}/cloud', stamp_ns=stamp,
        frame_id=f'object_{number}', colors=colors, extra=extra, latched=True)


def _stamp(names: list[str]) -> int:
    """Return the last log time that the views are named after, or 0."""
    found = [LOG_TIME.search(name) for name in names]
    return max((int(one[1]) for one in found if one), default=0)


def _read_cloud(folder: Path, number: int) -> Columns:
    path = folder / f'object_{number}.ply'
    if not path.exists():
        raise InputError(f'{path}: is not there; `rops model {folder}` makes it')
    try:
        columns = parse_vertices(read_bytes(path))
    except FormatError as error:
        raise InputError(f'{path}: is not the object of a run ({error})') from None
    missing = {*NEEDED, *(COLORS if 'red' in columns else ())} - set(columns)
    if missing:
        raise InputError(
            f'{path}: is not the object of a run (it lacks {", ".join(sorted(missing))})')
    return columns
