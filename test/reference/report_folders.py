# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Run folders put together by hand: bumpy balls whose residuals and colours are known."""

import json
from pathlib import Path

import numpy as np
from ros_rops.core.config import Config
from ros_rops.pipeline.parameters import dump_config
from ros_rops.reporting.mesh_files import ply_bytes

EVIL = '</script><script>alert("Hänsel & Größe")</script>@3'
RADIUS = 0.04
ERROR = 0.0005
"""How far the last view of each ball lies too far out, in m."""
DIRECTION = [0.0, 0.6, 0.8]


def ball(rows: int = 40, bumps: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, normals and triangles of a ball with bumps and without its underside."""
    theta = np.linspace(0.02, 2.4, rows)
    phi = np.linspace(0, 2 * np.pi, 2 * rows, endpoint=False)
    theta, phi = (grid.reshape(-1) for grid in np.meshgrid(theta, phi, indexing='ij'))
    normals = np.stack([
        np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=1)
    size = RADIUS * (1 + 0.08 * np.sin(bumps * phi) * np.sin(theta) ** 2)
    k = np.arange((rows - 1) * 2 * rows).reshape(rows - 1, 2 * rows)
    right, below = np.roll(k, -1, axis=1), k + 2 * rows
    faces = np.concatenate([
        np.stack([k, right, below], axis=-1).reshape(-1, 3),
        np.stack([right, np.roll(below, -1, axis=1), below], axis=-1).reshape(-1, 3)])
    return normals * size[:, None], normals, faces.astype(np.int32)


def write_folder(
    folder: Path, objects: int = 1, *, models: bool = True, left: bool = True, rows: int = 40,
    name: str = 'view_{}.ply', filled: bool = False, left_out: bool = False,
) -> Path:
    """
    Write a run folder.

    Parameters
    ----------
    folder : Path
    objects : int
        Four views each.
    models : bool
        Whether there are surfaces, residuals and `quality.json`.
    left : bool
        Whether a view is refused, one waits, and one is ambiguous.
    rows : int
        Of points of a ball.
    name : str
        Of a view, by its number.
    filled : bool
        Whether the faces of the lower half are marked as filled.
    left_out : bool
        Whether the last view of each object is left out of its model.
    """
    folder.mkdir(parents=True, exist_ok=True)
    names = [name.format(k) for k in range(4 * objects)]
    views = [_word(one, k // 4) for k, one in enumerate(names)]
    if left:
        views += [_left('blurred.ply', 'refused', 'holds 3 points: too few to mesh'),
                  _left('stranger.ply', 'pending', 'waits for views that overlap it'),
                  _left('plate.ply', 'ambiguous', 'the view slides on itself, like a plane')]
    shapes = [{'id': k, 'views': [
        {'name': one, 'T_object_view': np.eye(4).tolist()} for one in names[4 * k:4 * k + 4]]}
        for k in range(objects)]
    _write(folder / 'poses.json', {
        'units': 'm', 'mesh_resolution': 0.001, 'objects': shapes, 'views': views, 'attempts': 9})
    _write(folder / 'trace.json', {'attempts': [
        _attempt(names[4 * k + j], names[4 * k + j - 1]) for k in range(objects)
        for j in (1, 2, 3)]})
    _write(folder / 'metrics.json', {
        'stage_seconds': {'prepare': 1.5, 'match': 0.5},
        'model_seconds': {'surface': 2.0, 'all': 2.0}, 'seconds': 4.25,
        'inputs': ['scans'], 'machine': {'cpu': 'Abacus'}})
    _write(folder / 'run.json', {'inputs': ['my scans/ä.mcap'], 'units': 'mm', 'sources': []})
    config = Config.from_flat({'rops.bins': 6})
    (folder / 'config.yaml').write_text(dump_config(config), encoding='utf-8')
    for k in range(objects):
        _write_object(folder, k, models, rows, filled)
    if models:
        _write(folder / 'quality.json', {
            'units': 'm', 'objects': [
                _quality(k, names[4 * k:4 * k + 4])
                | ({'left_out': [names[4 * k + 3]]} if left_out else {}) for k in range(objects)]})
    return folder


def _word(name: str, number: int) -> dict:
    return {'name': name, 'status': 'placed', 'object': number, 'reason': 'score 0.69',
            'overlap': 0.6, 'residual_mr': 0.13, 'centroid': [0.0, 0.0, 0.0]}


def _left(name: str, status: str, reason: str) -> dict:
    return {'name': name, 'status': status, 'object': None, 'reason': reason}


def _attempt(source: str, target: str) -> dict:
    return {'source': source, 'target': target, 'source_views': [source],
            'target_views': [target], 'status': 'placed', 'reason': 'score 0.69',
            'numbers': {'matches': 30, 'score': 0.69, 'overlap': 0.6, 'residual_mr': 0.13},
            'seconds': {'match': 0.01}}


def _write_object(folder: Path, number: int, models: bool, rows: int, filled: bool) -> None:
    points, normals, faces = ball(rows, bumps=3 + number % 7)
    quarter = np.floor(np.arctan2(points[:, 2], points[:, 0]) / (np.pi / 2)).astype(int) % 4
    ids = (4 * number + quarter).astype(np.int32)
    red = np.where(points[:, 1] > 0, 220, 40).astype(np.uint8)
    at = dict(zip('xyz', points.T, strict=True))
    turned = dict(zip(('nx', 'ny', 'nz'), normals.T.astype(np.float32), strict=True))
    rgb = {'red': red, 'green': 255 - red, 'blue': np.full(len(red), 60, np.uint8)}
    (folder / f'object_{number}.ply').write_bytes(ply_bytes({**at, **turned, **rgb,
                                                             'view_id': ids}))
    if not models:
        return
    flags = {'filled': (points[faces, 1].mean(axis=1) < 0).astype(np.uint8)} if filled else None
    (folder / f'object_{number}_surface.ply').write_bytes(ply_bytes(
        {**at, **turned, **rgb}, ('units: m',), faces, flags))
    state = np.where(quarter == 3, 2, np.where(points[:, 1] < -0.02, 0, 1)).astype(np.uint8)
    residual = np.where(quarter == 3, ERROR, 0.2 * ERROR * np.sin(40 * points[:, 1] / RADIUS))
    residual = np.where(state == 0, np.nan, residual).astype(np.float32)
    (folder / f'object_{number}_residuals.ply').write_bytes(ply_bytes({
        **at, 'view_id': ids, 'residual': residual, 'state': state, **rgb}))


def _quality(number: int, names: list[str]) -> dict:
    def view(k: int, one: str) -> dict:
        bad = k == 3
        return {'name': one, 'number': 4 * number + k, 'points': 800,
                'residual': {'mean': 1e-4, 'median': 8e-5, 'p90': ERROR if bad else 2e-4,
                             'rms': 2e-4},
                'confirmed': 0.1 if bad else 0.9, 'contradicted': 0.6 if bad else 0.0,
                'alone': 0.1, 'least_constrained': {
                    'kind': 'rotation', 'direction': [0, 1, 0], 'stiffness': 0.02,
                    'text': 'turns about the vertical axis'},
                'flags': ['60% of its points are contradicted'] if bad else []}

    return {
        'id': number, 'mesh_resolution': 0.001,
        'views': [view(k, one) for k, one in enumerate(names)], 'worst_views': [names[3]],
        'edges': [{'source': names[a], 'target': names[b], 'overlap': 0.2 + 0.15 * a,
                   'residual': 1e-4 * (1 + a)} for a in range(4) for b in range(a)],
        'loops': {'count': 3, 'rotation_deg': {'mean': 0.1, 'max': 0.3},
                  'translation': {'mean': 1e-4, 'max': 3e-4},
                  'worst': {'views': names[:3], 'rotation_deg': 0.3, 'translation': 3e-4}},
        'coverage': {'area': 0.02, 'unseen_area': 0.003, 'unseen_share': 0.15, 'holes': 1,
                     'directions': [{'direction': DIRECTION, 'gain_share': 0.08},
                                    {'direction': [0, -1, 0], 'gain_share': 0.05}],
                     'turntable': {'axis': [0, 1, 0], 'angle_deg': 40.0, 'gain_share': 0.03}},
        'surface': {'method': 'volume', 'voxel': 0.001, 'closed': False, 'floating_removed': 2},
        'cloud': {'points_before': 5000, 'outliers_removed': 12}, 'notes': [],
        'summary': 'Three views agree within 0.1 mm, one does not.'}


def _write(path: Path, content: dict) -> None:
    path.write_text(json.dumps(content, ensure_ascii=False), encoding='utf-8')
