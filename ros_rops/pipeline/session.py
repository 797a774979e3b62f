# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The engine's state: unordered views come in, one shape per object grows (IV)."""

from collections.abc import Mapping, Sequence
import time
from types import MappingProxyType

import numpy as np

from ros_rops.core.config import Config
from ros_rops.core.consistency import agreeing_groups
from ros_rops.core.errors import ParameterError, ViewError
from ros_rops.core.fine import FineResult, FineView, refine_shape
from ros_rops.core.fine_prior import FinePrior
from ros_rops.core.shape_growing import seed_shape, Shape
from ros_rops.core.types import RangeView, Status, Units
from ros_rops.core.verdict import residual_limit, self_stiffness
from ros_rops.pipeline.attempt import Attempt
from ros_rops.pipeline.growth import Growth
from ros_rops.pipeline.prepare import prepare, PreparedView
from ros_rops.pipeline.reports import ObjectModel, PlacedView, ViewReport
from ros_rops.pipeline.station import StationWatch
from ros_rops.pipeline.units import in_units

# What is taken apart could come together again, and so on without end.
RECONSIDERED = 5
SECONDS = ('prepare', 'screen', 'match', 'ccv', 'icp', 'quick', 'thorough', 'grow', 'fine')


class Session:
    """
    Register range views incrementally into one model per object.

    Synchronous and deterministic: the state is a function of the views added, in their order,
    and of the parameters; threads do not change it.

    Parameters
    ----------
    config : Config
    threads : int
        0 takes all cores.
    units : {'m', 'mm'}, optional
        Of everything that comes out; by default those of the first view that states its units.

    Examples
    --------
    >>> session = Session()
    >>> session.objects
    ()
    """

    def __init__(
        self, config: Config | None = None, *, threads: int = 0, units: Units | None = None
    ) -> None:
        self.config = config or Config()
        self.threads = threads
        self._units = None if units == 'unknown' else units
        self._prepared: dict[str, PreparedView] = {}
        self._views: dict[str, RangeView] = {}
        self._aside: dict[str, ViewReport] = {}
        self._fits: dict[str, Mapping[str, float]] = {}
        self._seconds = dict.fromkeys(SECONDS, 0.0)
        self._watch = StationWatch(self.config.prior)
        self._growth = Growth(self.config, threads, self._seconds, self._watch)

    def add(self, view: RangeView) -> ViewReport:
        """
        Take a view and place it, if it can be placed now.

        Parameters
        ----------
        view : RangeView
            Its name must be new to the session.

        Returns
        -------
        ViewReport
            The word on this view; the word on earlier ones may have changed too (`reports`).

        Raises
        ------
        ParameterError
            If a view of this name was added before.
        """
        if view.name in self._views:
            raise ParameterError(f'view {view.name!r} was added before')
        view = in_units(view, self._agree_on_units(view))
        self._views[view.name] = view
        started = time.perf_counter()
        try:
            prepared = prepare(
                view, self.config, resolution=self._resolution(), threads=self.threads)
        except ViewError as error:
            self._aside[view.name] = ViewReport(
                view.name, Status.REFUSED, None,
                str(error).removeprefix(f'view {view.name!r}: '))
            return self._aside[view.name]
        finally:
            self._seconds['prepare'] += time.perf_counter() - started
        self._prepared[view.name] = prepared
        firmness = self_stiffness(prepared.surface)
        if firmness < self.config.verdict.stiffness:
            self._aside[view.name] = ViewReport(
                view.name, Status.AMBIGUOUS, None,
                f'the view slides or turns on itself, like a plane, a sphere or a cylinder: '
                f'stiffness {firmness:.4f} is below {self.config.verdict.stiffness}',
                {'stiffness': firmness})
            return self._aside[view.name]
        self._growth.arrive(seed_shape(prepared.surface))
        return self._report(view.name)

    def finish(self) -> None:
        """
        Give waiting views their last chances, then refine all views of each object together.

        What did not fit an object may fit it now that its poses are better: as long as views
        wait, and find a place, this begins again. More views may be added afterwards.
        """
        self._growth.settle()
        self._refine_all()
        for _ in range(RECONSIDERED):
            if not self._growth.reconsider():
                break
            self._refine_all()

    def remove(self, name: str) -> None:
        """
        Take a view back, as if it had not been placed; what it held together stays together.

        Raises
        ------
        ParameterError
            If there is no such view.
        """
        if name not in self._views:
            raise ParameterError(f'no view {name!r} in the session')
        del self._views[name]
        self._fits.pop(name, None)
        self._prepared.pop(name, None)
        if self._aside.pop(name, None) is None:
            self._growth.take_back(name)

    @property
    def reports(self) -> tuple[ViewReport, ...]:
        """Return the current word on every view, in order of arrival."""
        return tuple(self._report(name) for name in self._views)

    @property
    def objects(self) -> tuple[ObjectModel, ...]:
        """Objects of two or more views, by id."""
        return tuple(
            ObjectModel(object_id, tuple(
                PlacedView(name, shape.members[name], self._report(name).numbers)
                for name in self._views if name in shape.members))
            for object_id, shape in sorted(self._growth.objects().items())
        )

    @property
    def views(self) -> Mapping[str, RangeView]:
        """All views by name, in the session's units."""
        return MappingProxyType(self._views)

    @property
    def prepared(self) -> Mapping[str, PreparedView]:
        """Return the views that could be meshed, by name."""
        return MappingProxyType(self._prepared)

    @property
    def units(self) -> Units:
        """Units of poses and points."""
        return self._units or 'unknown'

    @property
    def mesh_resolution(self) -> float:
        """Mean of the views' mesh resolutions; 0 without views."""
        found = [item.mesh.resolution for item in self._prepared.values()]
        return float(np.mean(found)) if found else 0.0

    @property
    def station(self) -> Mapping[str, object]:
        """Return what was known of the station, found and used; empty if nothing was said."""
        return self._watch.facts(self._growth.objects()) if self._watch.active else {}

    @property
    def attempts(self) -> int:
        """Pairwise registrations attempted: a view or shape against a shape."""
        return len(self._growth.trace)

    @property
    def trace(self) -> tuple[Attempt, ...]:
        """Every registration attempted, in order."""
        return tuple(self._growth.trace)

    @property
    def stage_seconds(self) -> Mapping[str, float]:
        """Wall seconds by stage."""
        return MappingProxyType(self._seconds)

    def _agree_on_units(self, view: RangeView) -> Units:
        if self._units is None and view.units != 'unknown':
            self._units = view.units
        return self._units or 'unknown'

    def _resolution(self) -> float | None:
        """Return what `mr` means in this session: the resolution of its first sound view."""
        # A wall or a ball says nothing of the objects, so it must not set the scale for them.
        first = next(
            (item for name, item in self._prepared.items() if name not in self._aside), None)
        return first.surface.resolution if first else None

    def _refine_all(self) -> None:
        started = time.perf_counter()
        done: set[int] = set()
        while waiting := sorted(self._growth.objects().keys() - done):
            done.add(waiting[0])
            while self._refine(waiting[0]):
                pass
        self._seconds['fine'] += time.perf_counter() - started

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
            self._fits[name] = {
                'fine_residual_mr': fit.residual_mr, 'fine_stiffness': fit.stiffness}
        self._growth.move(object_id, dict(zip(names, result.poses, strict=True)))
        return (
            self._take_apart(names, object_id, result)
            or self._take_misfit_back(names, object_id))

    def _take_apart(self, names: Sequence[str], object_id: int, result: FineResult) -> bool:
        surfaces = [self._prepared[name].surface for name in names]
        unit, config = surfaces[0].resolution, self.config.verdict
        groups = agreeing_groups(
            result, config.conflict,
            lambda a, b: residual_limit(surfaces[a], surfaces[b], unit, config))
        if len(groups) == 1:
            return False
        for name in names:
            del self._fits[name]
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
                views, poses, shape.surface.resolution, self.config.fine, threads=self.threads,
                prior=prior)

        free = refined(None)
        prior = self._watch.fine_prior(
            names, {name: self._prepared[name].surface for name in names})
        if prior is None:
            return free
        bound = refined(prior)
        return bound if self._watch.accept(object_id, free, bound) else free

    def _take_misfit_back(self, names: Sequence[str], object_id: int) -> bool:
        residuals = {name: self._fits[name]['fine_residual_mr'] for name in names}
        worst = max(names, key=lambda name: np.nan_to_num(residuals[name], nan=-1.0))
        surface = self._prepared[worst].surface
        config = self.config.verdict
        limit = config.misfit * residual_limit(surface, surface, surface.resolution, config)
        if not residuals[worst] > limit:
            return False
        del self._fits[worst]
        others = [name for name in names if name != worst]
        self._growth.take_apart(object_id, [others, [worst]], (
            f'taken back: its residual of {residuals[worst]:.2f} mr after fine registration is '
            f'above {limit:.2f}'))
        return True

    def _report(self, name: str) -> ViewReport:
        if name in self._aside:
            return self._aside[name]
        report = self._growth.report(name)
        numbers = {**report.numbers, **self._fits.get(name, {})}
        return ViewReport(name, report.status, report.object_id, report.reason, numbers)
