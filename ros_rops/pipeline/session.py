# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The engine's state: unordered views come in, one shape per object grows (IV)."""

from collections.abc import Callable, Mapping
import time
from types import MappingProxyType

import numpy as np

from ros_rops.core.config import Config
from ros_rops.core.errors import ParameterError, ViewError
from ros_rops.core.shape_growing import seed_shape
from ros_rops.core.types import RangeView, Status, Units
from ros_rops.core.verdict import self_stiffness
from ros_rops.pipeline.attempt import Attempt
from ros_rops.pipeline.growth import Growth
from ros_rops.pipeline.prepare import prepare, PreparedView
from ros_rops.pipeline.refinement import Refinement
from ros_rops.pipeline.reports import ObjectModel, PlacedView, ViewReport
from ros_rops.pipeline.station import StationWatch
from ros_rops.pipeline.units import in_units

SECONDS = (
    'prepare', 'screen', 'match', 'ccv', 'icp', 'glance', 'quick', 'thorough', 'settle', 'grow',
    'fine')


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

    Attributes
    ----------
    joined : callable
        Called within `add` and `finish` when views have found their place, while others are still
        tried: `objects` and `reports` may be read then.

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
        self._seconds = dict.fromkeys(SECONDS, 0.0)
        self._watch = StationWatch(self.config.prior)
        self.joined: Callable[[], None] = lambda: None
        self._growth = Growth(
            self.config, threads, self._seconds, self._watch, lambda: self.joined())
        self._refinement = Refinement(
            self._growth, self._watch, self._prepared, self.config, threads)

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
        self._growth.arrive(seed_shape(prepared.surface), self.units)
        return self._report(view.name)

    def settle(self) -> None:
        """
        Give waiting views their last chances; the poses of objects stay as they grew (IV-A).

        `finish` does so first of all: only who asks for the coarse poses calls this.
        """
        self._growth.settle()

    def finish(self) -> None:
        """
        Give waiting views their last chances, then refine all views of each object together.

        What did not fit an object may fit it now that its poses are better: as long as views
        wait, and find a place, this begins again. More views may be added afterwards.
        """
        started = time.perf_counter()
        spent = sum(self._seconds.values())
        self._refinement.run()
        self._seconds['fine'] += (
            time.perf_counter() - started - (sum(self._seconds.values()) - spent))

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
        self._refinement.fits.pop(name, None)
        self._prepared.pop(name, None)
        if self._aside.pop(name, None) is None:
            self._growth.take_back(name)

    def give_up(self, name: str, reason: str) -> ViewReport:
        """
        Refuse a view in whose registration something failed, and go on as if it had not come.

        Raises
        ------
        ParameterError
            If there is no such view.
        """
        if name not in self._views:
            raise ParameterError(f'no view {name!r} in the session')
        self._refinement.fits.pop(name, None)
        self._prepared.pop(name, None)
        if self._growth.holds(name):
            self._growth.take_back(name)
        self._aside[name] = ViewReport(name, Status.REFUSED, None, reason)
        return self._aside[name]

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
        return self._watch.facts(self._growth.objects()) if self._watch.said else {}

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

    def _report(self, name: str) -> ViewReport:
        if name in self._aside:
            return self._aside[name]
        report = self._growth.report(name)
        numbers = {**report.numbers, **self._refinement.fits.get(name, {})}
        return ViewReport(name, report.status, report.object_id, report.reason, numbers)
