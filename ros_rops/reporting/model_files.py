# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The files of an object's model: assembled cloud, surface, residuals."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from ros_rops.modelling.model import Model
from ros_rops.modelling.products import ModelCloud
from ros_rops.reporting.mesh_files import ply_bytes, write_surface
from ros_rops.reporting.residual_colours import reach_of, residual_colors

MOST_RESIDUALS = 300_000


def write_model(folder: Path, model: Model, *, units: str, formats: tuple[str, ...]) -> list[str]:
    """
    Write what there is of a model; return the names of the files.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    names = []
    stem = f'object_{model.object_id}'
    if model.cloud is not None:
        names.append(f'{stem}.ply')
        (folder / names[-1]).write_bytes(_cloud(model.cloud, units))
    if model.surface is not None:
        for suffix in formats:
            names.append(f'{stem}_surface.{suffix}')
            write_surface(folder / names[-1], model.surface, units=units, about=_about(model))
    if model.quality is not None and model.quality.residuals:
        names.append(f'{stem}_residuals.ply')
        (folder / names[-1]).write_bytes(_residuals(model, units))
    return names


def files_of(folder: Path, object_id: int) -> Iterator[Path]:
    """Yield the files of an object's model that are there."""
    yield from folder.glob(f'object_{object_id}.ply')
    yield from sorted(folder.glob(f'object_{object_id}_surface.*'))
    yield from folder.glob(f'object_{object_id}_residuals.ply')


def _about(model: Model) -> str:
    facts = model.surface.facts if model.surface is not None else {}
    said = [f'frame: object_{model.object_id}']
    said += [f'{name}: {facts[name]:.6g}' if isinstance(facts[name], float)
             else f'{name}: {facts[name]}' for name in ('method', 'voxel') if name in facts]
    return ', '.join(said)


def _cloud(cloud: ModelCloud, units: str) -> bytes:
    columns = dict(zip('xyz', cloud.points.T, strict=True))
    columns |= dict(zip(('nx', 'ny', 'nz'), cloud.normals.T, strict=True))
    if cloud.colors is not None:
        columns |= dict(zip(('red', 'green', 'blue'), cloud.colors.T, strict=True))
    columns |= {'view_id': cloud.view_ids, 'directions': cloud.directions,
                'weight': cloud.weights}
    return ply_bytes(columns, (
        f'units: {units}', 'view_id: place of the view in poses.json, of the view that weighs '
        'most; directions: how many views saw the point'))


def _residuals(model: Model, units: str) -> bytes:
    parts = model.quality.residuals if model.quality is not None else ()
    total = sum(len(part.points) for part in parts)
    points, ids, residual, state = [], [], [], []
    for part in parts:
        # Evenly over each view's points, the same share of each.
        count = len(part.points)
        pick = np.arange(count)
        if total > MOST_RESIDUALS:
            pick = np.linspace(0, count, count * MOST_RESIDUALS // total, False).astype(np.int64)
        points.append(part.points[pick])
        residual.append(part.residual[pick].astype(np.float32))
        state.append(part.state[pick].astype(np.uint8))
        ids.append(np.full(len(pick), part.number, np.int32))
    values, states = np.concatenate(residual), np.concatenate(state)
    columns = dict(zip('xyz', np.concatenate(points).astype(np.float64).T, strict=True))
    columns |= {'view_id': np.concatenate(ids), 'residual': values, 'state': states}
    reach = reach_of(values, states)
    colors = residual_colors(values, states, reach)
    columns |= dict(zip(('red', 'green', 'blue'), colors.T, strict=True))
    return ply_bytes(columns, (
        f'units: {units}', 'residual: distance to what the other views saw, in front positive; '
        'state: 0 alone, 1 confirmed, 2 contradicted',
        f'colours: blue {-reach:.4g}, red {reach:.4g}; grey alone, magenta contradicted'))
