# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A run folder without a registration: views of balls, seen by arithmetic, at exact poses."""

from types import SimpleNamespace

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.types import RangeView, SensorModel, Status
from ros_rops.intake.journal import Journal
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.intake.run_file import RunFile, stamp, write_run_file
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.writers import write_view
from ros_rops.reporting.models import ModelTask
from ros_rops.reporting.run import Run
from ros_rops.reporting.run_folder import prepare_folder, write_run

RADIUS = 40.0
BALLS = (((0.0, 0.0, 0.0), RADIUS), ((0.0, 48.0, 0.0), 22.0))
"""Middle and radius in mm, in the frame of the object."""
PIXELS, FOCAL, AWAY = 56, 90.0, 260.0
TURNS = {0: (0, 60, 120, 180, 240, 300), 1: (0, 50)}
"""Object to the degrees that its views are taken at."""


def pose(degrees):
    """Return T_object_view of a camera that looks at the middle from around."""
    angle = np.deg2rad(degrees)
    T = np.eye(4)
    T[:3, 2] = -np.sin(angle), 0.0, -np.cos(angle)
    T[:3, 1] = 0.0, -1.0, 0.0
    T[:3, 0] = np.cross(T[:3, 1], T[:3, 2])
    T[:3, 3] = (0.0, 10.0, 0.0) - AWAY * T[:3, 2]
    return T


def view(name, degrees, *, units='mm', colors=True):
    """Return what a pinhole camera sees of the balls."""
    T = pose(degrees)
    v, u = np.mgrid[:PIXELS, :PIXELS] - (PIXELS - 1) / 2.0
    rays = np.stack([u / FOCAL, v / FOCAL, np.ones_like(u)], axis=-1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    nearest = np.full(len(rays), np.inf)
    for middle, radius in BALLS:
        m = T[:3, :3].T @ (np.array(middle) - T[:3, 3])
        b = rays @ m
        under = b * b - m @ m + radius * radius
        hit = np.where(under > 0, b - np.sqrt(np.maximum(under, 0.0)), np.inf)
        nearest = np.minimum(nearest, hit)
    seen = np.isfinite(nearest)
    grid = np.full(len(rays), -1, np.int32)
    grid[seen] = np.arange(seen.sum())
    scale = {'mm': 1.0, 'm': 1e-3}[units]
    points = rays[seen] * nearest[seen, None] * scale
    painted = np.tile(np.array([[200, 100, 12]], np.uint8), (len(points), 1)) if colors else None
    return RangeView(
        name, points, grid.reshape(PIXELS, PIXELS), SensorModel('pinhole'), painted, units)


def scene(*, units='mm', colors=True):
    """Return (object, T_object_view in `units`, view) of every view, in the run's order."""
    found = []
    for number, turns in TURNS.items():
        for degrees in turns:
            T = pose(degrees)
            T[:3, 3] *= {'mm': 1.0, 'm': 1e-3}[units]
            seen = view(f'v{number}_{degrees}.ply', degrees, units=units, colors=colors)
            found.append((number, T, seen))
    return found


def make_run(folder, *, journal=True, state='finished', units='mm', colors=True, values=None,
             plain=False):
    """
    Write the first half of a run folder, as a registration leaves it; return what models need.

    Without a journal its inputs lie beside the folder; with `plain` it is that of a run without
    models.
    """
    found = scene(units=units, colors=colors)
    config = Config.from_flat(values or {})
    objects = [
        SimpleNamespace(id=number, views=[
            SimpleNamespace(name=seen.name, T_object_view=T, numbers={})
            for of, T, seen in found if of == number])
        for number in TURNS]
    session = SimpleNamespace(
        reports=[SimpleNamespace(name=seen.name, status=Status.PLACED, object_id=number,
                                 reason='', numbers={}) for number, _, seen in found],
        objects=objects, views={seen.name: seen for _, _, seen in found}, units=units,
        mesh_resolution=2.0, attempts=0, stage_seconds={}, trace=[], station={})
    sources = () if journal else _inputs(folder.with_name(folder.name + '_in'), found)
    prepare_folder(folder)
    write_run_file(folder, RunFile(
        (), sources, 'auto', False, journal, None, config.to_flat(), '0', state))
    if journal:
        with Journal(folder / 'journal.mcap') as kept:
            for _, _, seen in found:
                kept.keep(FrameReport(seen.name, Word.TAKEN, '', (seen.name,)), (seen,))
    document = write_run(folder, Run(
        session, config, [seen.name for _, _, seen in found]), picture=False, clouds=plain)
    return ModelTask(document, session.views, config, 1)


def _inputs(folder, found):
    folder.mkdir()
    for _, _, seen in found:
        write_view(folder / seen.name, seen)
    return tuple(map(stamp, find_views([folder])))
