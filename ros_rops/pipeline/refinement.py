# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Refine all views of each object together (IV-B), and take back what then turns out wrong."""

from collections.abc import Mapping, Sequence

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.consistency import agreeing_groups, outstanding_view
from ros_rops.core.fine import FineResult, FineView, refine_shape
from ros_rops.core.fine_prior import FinePrior
from ros_rops.core.shape_growing import Shape
from ros_rops.core.verdict import residual_limit
from ros_rops.pipeline.growth import Growth
from ros_rops.pipeline.prepare import PreparedView
from ros_rops.pipeline.station import StationWatch

# What is taken apart could come together again, and so on without end.
RECONSIDERED = 5
# What was said of a station by which fewer views find a place is probably wrong.
LEAST_PLACED = 0.5


class Refinement:
    """
    The end of a session: settle, refine, doubt, and try again what was doubted.

    Parameters
    ----------
    growth : Growth
    watch : StationWatch
    prepared : mapping of str to PreparedView
        The session's, by name; grows with it.
    config : Config
    threads : int
    """

    def __init__(
        self, growth: Growth, watch: StationWatch, prepared: Mapping[str, PreparedView],
        config: Config, threads: int,
    ) -> None:
        self.fits: dict[str, Mapping[str, float]] = {}
        self._growth = growth
        self._watch = watch
        self._prepared = prepared
        self._config = config
        self._threads = threads
        self._looked_at: set[str] = set()

    def run(self) -> None:
        """
        Give waiting views their last chances, then refine; again while views find places.

        Where most views find none with what is known of the station, that is doubted first.
        """
        self._looked_at.clear()
        self._settle()
        if self._watch.active and self._growth.placed_share < LEAST_PLACED:
            self._watch.doubt()
            self._growth.forget_trials()
            self._settle()

    def _settle(self) -> None:
        self._growth.settle()
        self._refine_all()
        for _ in range(RECONSIDERED):
            if not self._growth.reconsider():
                break
            self._refine_all()

    def _refine_all(self) -> None:
        done: set[int] = set()
        while waiting := sorted(self._growth.objects().keys() - done):
            done.add(waiting[0])
            while self._refine(waiting[0]):
                pass

    def _refine(self, object_id: int) -> bool:
        """
        Refine the views of an object; take apart what contradicts itself, and the worst misfit.

        Returns
        -------
        bool
            Whether views were taken away, so that the others want refining again.
        """
        shape = self._growth.objects().get(object_id)
        if shape is None:
            return False
        names = list(shape.members)
        result = self._refined(object_id, shape, names)
        for name, fit in zip(names, result.views, strict=True):
            self.fits[name] = {
                'fine_residual_mr': fit.residual_mr, 'fine_stiffness': fit.stiffness}
        self._growth.move(object_id, dict(zip(names, result.poses, strict=True)))
        return (
            self._take_apart(names, object_id, result)
            or self._take_misfit_back(names, object_id)
            or self._look_again(names, object_id, result))

    def _look_again(self, names: Sequence[str], object_id: int, result: FineResult) -> bool:
        """Let a view that fits far worse than the others try against all of them, once."""
        again = {k for k, name in enumerate(names) if name in self._looked_at}
        worst = outstanding_view(result, again)
        if worst is None:
            return False
        self._looked_at.add(names[worst])
        del self.fits[names[worst]]
        others = [name for name in names if name != names[worst]]
        self._growth.take_apart(object_id, [others, [names[worst]]], (
            'taken back: it fits the other views far worse than they fit each other'))
        return True

    def _take_apart(self, names: Sequence[str], object_id: int, result: FineResult) -> bool:
        surfaces = [self._prepared[name].surface for name in names]
        unit, config = surfaces[0].resolution, self._config.verdict
        groups = agreeing_groups(
            result, config.conflict,
            lambda a, b: residual_limit(surfaces[a], surfaces[b], unit, config))
        if len(groups) == 1:
            return False
        for name in names:
            del self.fits[name]
        self._growth.take_apart(
            object_id, [[names[k] for k in group] for group in groups],
            'taken back: it contradicts other views of the object')
        return True

    def _refined(self, object_id: int, shape: Shape, names: Sequence[str]) -> FineResult:
        """Refine with what the station knows, unless the data speak against it."""
        views = [FineView.of(self._prepared[name].mesh) for name in names]
        poses = [shape.members[name] for name in names]

        def refined(prior: FinePrior | None) -> FineResult:
            return refine_shape(
                views, poses, shape.surface.resolution, self._config.fine, threads=self._threads,
                prior=prior)

        free = refined(None)
        prior = self._watch.fine_prior(
            names, {name: self._prepared[name].surface for name in names})
        if prior is None:
            return free
        bound = refined(prior)
        return bound if self._watch.accept(object_id, free, bound) else free

    def _take_misfit_back(self, names: Sequence[str], object_id: int) -> bool:
        residuals = {name: self.fits[name]['fine_residual_mr'] for name in names}
        worst = max(names, key=lambda name: np.nan_to_num(residuals[name], nan=-1.0))
        surface = self._prepared[worst].surface
        config = self._config.verdict
        limit = config.misfit * residual_limit(surface, surface, surface.resolution, config)
        if not residuals[worst] > limit:
            return False
        del self.fits[worst]
        others = [name for name in names if name != worst]
        self._growth.take_apart(object_id, [others, [worst]], (
            f'taken back: its residual of {residuals[worst]:.2f} mr after fine registration is '
            f'above {limit:.2f}'))
        return True
