# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What rival strategies for many views share with ours, so that the strategy alone differs.

Views are prepared, registered and refined together by the engine; a registration counts once for
every pair of views that is matched, refined and judged, as in a session. Which pairs are asked
for, and what becomes of the answers, is the strategy's.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from ros_rops.bench.multiview import Job
from ros_rops.core.config import Config
from ros_rops.core.errors import ViewError
from ros_rops.core.fine import FineView, refine_shape
from ros_rops.core.pairwise import PairResult, register
from ros_rops.core.search import COARSE, worth
from ros_rops.core.types import Floats, RangeView, Status
from ros_rops.kernels.verification import score
from ros_rops.pipeline.prepare import prepare, PreparedView
from ros_rops.pipeline.reports import ObjectModel, PlacedView
from ros_rops.pipeline.units import in_units

SAMPLES = 500
# Two views contradict each other if the rays speak against their poses by more than the overlap
# speaks for them, and by this share of the samples: chains of coarse poses drift.
CONTRADICTION = 0.05

# Poses `T_object_view` by the place of the view, of one object.
Part = dict[int, Floats]


@dataclass(slots=True)
class Book:
    """
    Views prepared and pairs registered, by name: sessions that share views share these.

    Sessions with one book must have the same first view, which sets the mesh resolution.
    """

    prepared: dict[str, PreparedView] = field(default_factory=dict)
    results: dict[tuple[str, str], PairResult] = field(default_factory=dict)


class Pairs:
    """
    Registrations between views, counted.

    Parameters
    ----------
    views : sequence of PreparedView
    config : Config
    threads : int
    book : Book
        Results known from elsewhere; asked for here, they count here.
    """

    def __init__(
        self, views: Sequence[PreparedView], config: Config, threads: int, book: Book
    ) -> None:
        self.views = views
        self._config = config
        self._threads = threads
        self._book = book
        self._asked: set[tuple[int, int]] = set()

    @property
    def attempts(self) -> int:
        """Pairs of views registered."""
        return len(self._asked)

    def pose(self, i: int, j: int) -> Floats | None:
        """Register two views; return `T_j_i` (4, 4), None where the verdict is not `placed`."""
        if i > j:
            back = self.pose(j, i)
            return None if back is None else np.linalg.inv(back)
        result = self.result(i, j)
        return result.T_target_source if result.status is Status.PLACED else None

    def result(self, i: int, j: int) -> PairResult:
        """Register view i to view j, i < j."""
        source, target = self.views[i].surface, self.views[j].surface
        self._asked.add((i, j))
        key = (source.name, target.name)
        if key not in self._book.results:
            self._book.results[key] = register(
                source, target, self._config, threads=self._threads)
        return self._book.results[key]

    def consistent(self, i: int, j: int, T_j_i: Floats) -> bool:
        """
        Whether two views may lie so: neither has surface where the other saw past it.

        The surface consistency of Huber and Hebert (free space and occupied space), by the
        engine's evidence with the tolerances of its coarse search. It is no registration.
        """
        source, target = self.views[i].surface, self.views[j].surface
        unit = 0.5 * (source.resolution + target.resolution)
        pairwise = self._config.pairwise
        scores = score(
            source.evidence, target.evidence, T_j_i[None], samples=SAMPLES,
            tau=pairwise.tau_mr * unit, front=pairwise.front_mr * unit, threads=self._threads)
        return bool(worth(scores, COARSE)[0] >= -CONTRADICTION)

    def agree(self, part: Mapping[int, Floats], other: Mapping[int, Floats]) -> bool:
        """Whether every view of one part may lie so to every view of another, in one frame."""
        return all(
            self.consistent(i, j, np.linalg.inv(T_j) @ T_i)
            for i, T_i in other.items() for j, T_j in part.items())


class GraphSession:
    """
    What `run_job` needs of a session: views in, objects out.

    Parameters
    ----------
    job : Job
    arrange : callable
        The strategy: pairs to the parts of two or more views, with their coarse poses.
    book : Book, optional
        To share with other sessions.

    Attributes
    ----------
    objects : tuple of ObjectModel
        After `finish`.
    attempts : int
        Pairwise registrations, after `finish`.
    """

    def __init__(
        self, job: Job, arrange: Callable[[Pairs], list[Part]], book: Book | None = None
    ) -> None:
        self.objects: tuple[ObjectModel, ...] = ()
        self.attempts = 0
        self._job = job
        self._arrange = arrange
        self._book = book or Book()
        self._views: list[PreparedView] = []

    @property
    def mesh_resolution(self) -> float:
        """Mean of the views' mesh resolutions; 0 without views."""
        return float(np.mean([view.mesh.resolution for view in self._views] or [0.0]))

    def add(self, view: RangeView) -> None:
        """Prepare a view as a session does; what cannot be prepared is left out."""
        if view.name not in self._book.prepared:
            resolution = self._views[0].surface.resolution if self._views else None
            try:
                self._book.prepared[view.name] = prepare(
                    in_units(view, self._job.units), self._job.config, resolution=resolution,
                    threads=self._job.threads)
            except ViewError:
                return
        self._views.append(self._book.prepared[view.name])

    def finish(self) -> None:
        """Run the strategy, then refine the views of each part together."""
        pairs = Pairs(self._views, self._job.config, self._job.threads, self._book)
        parts = self._arrange(pairs)
        self.attempts = pairs.attempts
        self.objects = tuple(
            ObjectModel(number, self._refined(part)) for number, part in enumerate(parts))

    def _refined(self, part: Part) -> tuple[PlacedView, ...]:
        result = refine_shape(
            [FineView.of(self._views[k].mesh) for k in part], list(part.values()),
            self._views[next(iter(part))].surface.resolution, self._job.config.fine,
            threads=self._job.threads)
        return tuple(
            PlacedView(self._views[k].view.name, pose, {})
            for k, pose in zip(part, result.poses, strict=True))
