# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
An object's model, all of it: cloud, surface, and how far they may be trusted (IV-C).

First of all its views are judged: of those that stand wrong neither cloud nor surface is made.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
import time

from ros_rops.core.config import Config
from ros_rops.core.errors import ModelError, RopsError
from ros_rops.core.types import Floats
from ros_rops.modelling.cloud import assemble_cloud
from ros_rops.modelling.posed import PosedView, resolution_of
from ros_rops.modelling.products import ModelCloud, SurfaceMesh
from ros_rops.modelling.quality import assess, Quality
from ros_rops.modelling.standing import judge
from ros_rops.modelling.verdicts import notes_of

Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Model:
    """
    What was made of an object; parts that could not be made are None, and `notes` say why.

    Parameters
    ----------
    object_id : int
    views : tuple of PosedView
    resolution : float
        Mean of the mesh resolutions (dres) of the views that it is made of; 0 without views.
    cloud : ModelCloud or None
    surface : SurfaceMesh or None
    quality : Quality or None
    notes : tuple of str
        A sentence for each part that could not be made, and on views that do not fit.
    seconds : mapping of str to float
        By stage: `cloud`, `surface`, `quality`.
    """

    object_id: int
    views: tuple[PosedView, ...]
    resolution: float = 0.0
    cloud: ModelCloud | None = None
    surface: SurfaceMesh | None = None
    quality: Quality | None = None
    notes: tuple[str, ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)


def build_model(
    object_id: int, views: Sequence[PosedView], config: Config, *,
    turntable_axis: Floats | None = None, threads: int = 0, say: Say | None = None,
) -> Model:
    """
    Make the model of an object; a part that cannot be made does not touch the others.

    Parameters
    ----------
    object_id : int
    views : sequence of PosedView
        All of the object's that could be meshed.
    config : Config
    turntable_axis : (3,) float64, optional
        Direction of the axis that the object was turned about, in its frame.
    threads : int
        0 takes all cores; no influence on the result.
    say : callable, optional
        Is told what is done next, and what is known before it is done (voxel, memory).
    """
    if not views:
        return Model(object_id, (), notes=('no view of it can be meshed',))
    stages = _Stages(say or _nothing)
    right: Sequence[PosedView] = views
    standing = cloud = surface = quality = None
    with stages.take('quality', f'judging how {_counted(len(views), "view")} fit'):
        standing = judge(views, config, resolution=resolution_of(views), threads=threads)
        right = standing.right(views)
        stages.notes += notes_of(views, standing)
    resolution = resolution_of(right)
    with stages.take('cloud', f'assembling the cloud of {_counted(len(right), "view")}'):
        cloud = _cloud(right, config, resolution, threads)
    if config.model.surface != 'none':
        with stages.take('surface', f'making the surface ({config.model.surface})'):
            surface = _surface(right, cloud, config, resolution, threads, stages.say)
    if standing is not None:
        with stages.take('quality', 'judging the registration'):
            quality = assess(
                views, standing, surface, config, resolution=resolution,
                turntable_axis=turntable_axis, threads=threads)
    return Model(
        object_id, tuple(views), resolution, cloud, surface, quality, tuple(stages.notes),
        stages.seconds)


def _cloud(
    views: Sequence[PosedView], config: Config, resolution: float, threads: int
) -> ModelCloud:
    cloud = assemble_cloud(views, config.model, resolution=resolution, threads=threads)
    if not len(cloud.points):
        # Nothing to put in the place of the points as they were registered.
        raise ModelError('no point of the views can be trusted')
    return cloud


def _surface(
    views: Sequence[PosedView], cloud: ModelCloud | None, config: Config, resolution: float,
    threads: int, say: Say,
) -> SurfaceMesh:
    if config.model.surface == 'poisson':
        from ros_rops.modelling.poisson import poisson_surface

        if cloud is None:
            raise ModelError('there is no cloud to make it of')
        return poisson_surface(cloud, config.model, resolution=resolution)
    from ros_rops.modelling.volume import volumetric_surface

    return volumetric_surface(
        views, config.model, resolution=resolution, threads=threads, say=say)


class _Stages:
    """Stages one after the other: timed, and none of them ends the others."""

    def __init__(self, say: Say) -> None:
        self.say = say
        self.notes: list[str] = []
        self.seconds: dict[str, float] = {}

    @contextmanager
    def take(self, name: str, what: str) -> Iterator[None]:
        self.say(what)
        started = time.perf_counter()
        try:
            yield
        except Exception as error:  # whatever it is: poses and the other parts are worth more
            kind = '' if isinstance(error, RopsError) else f' ({type(error).__name__})'
            self.notes.append(f'no {name}: {error}{kind}')
        finally:
            spent = time.perf_counter() - started
            self.seconds[name] = self.seconds.get(name, 0.0) + spent


def _counted(count: int, what: str) -> str:
    return f'{count} {what}{"" if count == 1 else "s"}'


def _nothing(text: str) -> None:
    pass
