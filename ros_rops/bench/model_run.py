# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Makes a surface in a process of its own, so that its memory and seconds are known."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
import multiprocessing
import time
from typing import Any

import numpy as np
from ros_rops.bench.machine import peak_rss_mib
from ros_rops.core.config import Config
from ros_rops.core.errors import ModelError, RopsError
from ros_rops.core.types import Floats, RangeView
from ros_rops.modelling.posed import pose_views, PosedView
from ros_rops.modelling.products import SurfaceMesh

Posed = tuple[PosedView, ...]


@dataclass(frozen=True, slots=True)
class ModelJob:
    """
    Views in their places, of which a surface is to be made.

    Parameters
    ----------
    views : tuple of (RangeView, (4, 4) float64)
        With `T_world_view`; their names are distinct.
    dres : float
    config : Config
    threads : int
    repeats : int
        Times it is made again, warm.
    """

    views: tuple[tuple[RangeView, Floats], ...]
    dres: float
    config: Config = field(default_factory=Config)
    threads: int = 0
    repeats: int = 0

    def posed(self) -> Posed:
        """Mesh and weight the views."""
        names = [view.name for view, _ in self.views]
        return pose_views(
            [(view.name, T) for view, T in self.views],
            {view.name: view for view, _ in self.views},
            {name: number for number, name in enumerate(names)}, self.config)


@dataclass(frozen=True, slots=True)
class Maker:
    """
    What makes a surface: `prepare` (its time does not count), then `make`.

    Parameters
    ----------
    name : str
    prepare : callable
        Of the job; what it returns goes to `make`.
    make : callable
        Of the job and what was prepared; returns a `SurfaceMesh`.
    """

    name: str
    prepare: Callable[[ModelJob], Any]
    make: Callable[[ModelJob, Any], SurfaceMesh]


@dataclass(frozen=True, slots=True)
class Made:
    """
    A surface made, or why not.

    Parameters
    ----------
    surface : SurfaceMesh or None
    seconds : tuple of float
        Of each time; the first one is cold.
    base_mib, peak_mib : float
        Peak memory of the process before and after the first time.
    error : str
    """

    surface: SurfaceMesh | None
    seconds: tuple[float, ...] = ()
    base_mib: float = 0.0
    peak_mib: float = 0.0
    error: str = ''

    @property
    def warm_s(self) -> float | None:
        """Median seconds of the repeats; of the only time, if it was not repeated."""
        seconds = self.seconds[1:] or self.seconds
        return float(np.median(seconds)) if seconds else None


def made(maker: Maker, job: ModelJob) -> Made:
    """Make a surface `1 + repeats` times in this process."""
    try:
        prepared = maker.prepare(job)
        base, seconds = peak_rss_mib(), []
        surface, peak = None, 0.0
        for time_number in range(1 + job.repeats):
            start = time.perf_counter()
            surface = maker.make(job, prepared)
            seconds.append(time.perf_counter() - start)
            peak = peak_rss_mib() if time_number == 0 else peak
    except Exception as error:  # whatever ends one maker must not end the others' measuring
        kind = '' if isinstance(error, RopsError) else f'{type(error).__name__}: '
        return Made(None, error=f'{kind}{error}')
    return Made(surface, tuple(seconds), base, peak)


def made_apart(maker: Maker, job: ModelJob) -> Made:
    """Make a surface in a fresh process; as `made`."""
    context = multiprocessing.get_context('spawn')
    try:
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            return pool.submit(made, maker, job).result()
    except BrokenProcessPool:
        return Made(None, error='its process was ended, or crashed')


def nothing(job: ModelJob) -> None:
    """Prepare nothing: our own makers are timed from the views on."""


def make_volume(job: ModelJob, _: None) -> SurfaceMesh:
    """Make the surface from signed distances along the lines of sight."""
    from ros_rops.modelling.posed import resolution_of
    from ros_rops.modelling.volume import volumetric_surface

    posed = job.posed()
    return volumetric_surface(
        posed, job.config.model, resolution=resolution_of(posed), threads=job.threads)


def make_poisson(job: ModelJob, _: None) -> SurfaceMesh:
    """Make the watertight surface of the assembled cloud."""
    from ros_rops.modelling.cloud import assemble_cloud
    from ros_rops.modelling.poisson import poisson_surface
    from ros_rops.modelling.posed import resolution_of

    posed, model = job.posed(), job.config.model
    resolution = resolution_of(posed)
    cloud = assemble_cloud(posed, model, resolution=resolution, threads=job.threads)
    return poisson_surface(cloud, model, resolution=resolution)


def make_filled(job: ModelJob, _: None) -> SurfaceMesh:
    """Make the surface as `make_volume`, its holes filled."""
    return make_volume(varied(job, holes='filled'), None)


def make_whole(job: ModelJob, _: None) -> SurfaceMesh:
    """
    Make all of the model: cloud, surface, quality.

    Raises
    ------
    ModelError
        If it came without a surface.
    """
    from ros_rops.modelling.model import build_model

    model = build_model(0, job.posed(), job.config, threads=job.threads)
    if model.surface is None:
        raise ModelError('; '.join(model.notes))
    return model.surface


def varied(job: ModelJob, **changes: Any) -> ModelJob:
    """Return the job with parameters of group `model` changed."""
    return replace(job, config=replace(job.config, model=replace(job.config.model, **changes)))


OURS = {
    maker.name: maker for maker in (
        Maker('volume', nothing, make_volume), Maker('volume, filled', nothing, make_filled),
        Maker('poisson', nothing, make_poisson), Maker('whole model', nothing, make_whole))}
