# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What a session learns of its station while views are placed, and what that says of new poses."""

from collections.abc import Mapping, Sequence
import itertools
import math
from typing import Any

import numpy as np
from ros_rops.core.config import PriorConfig
from ros_rops.core.fine_prior import FinePrior
from ros_rops.core.fine_types import FineResult
from ros_rops.core.shape_growing import Shape
from ros_rops.core.station import Known
from ros_rops.core.station_axis import AxisFit, find_axis
from ros_rops.core.surface import Surface
from ros_rops.core.types import Units

METRE: Mapping[Units, float] = {'m': 1.0, 'mm': 1000.0}


class StationWatch:
    """
    Keeps what is known of the station: the order of arrival, the axis once it is found.

    Parameters
    ----------
    config : PriorConfig
    """

    def __init__(self, config: PriorConfig) -> None:
        self._config = config
        self._order: dict[str, int] = {}
        self._middles: dict[str, Any] = {}
        self._unit = 0.0
        self.fit: AxisFit | None = None
        self._way = 0
        self._doubted = False
        self._planes = 0
        self._posed = 0
        self._metre: float | None = None
        self.unused: dict[int, str] = {}

    @property
    def turntable(self) -> bool:
        """Whether the poses are said to turn about one axis."""
        return self._config.axis or self._config.order or self._config.step_deg > 0

    @property
    def said(self) -> bool:
        """Whether anything is said of the station."""
        return self._config.plane or self.turntable or bool(self._config.fixed_frame)

    @property
    def active(self) -> bool:
        """Whether what is said speaks of the views."""
        return self._config.plane or self.turntable or self._posed > 0

    def arrive(self, surface: Surface, units: Units) -> None:
        """Note a view that came in; `units` are the session's."""
        self._metre = METRE.get(units)
        if self._config.fixed_frame and self._metre is not None:
            self._posed += surface.T_fixed_surface is not None
        self._order[surface.name] = len(self._order)
        self._middles[surface.name] = surface.evidence.centre
        self._unit = self._unit or surface.resolution
        self._planes += surface.support is not None

    def learn(self, objects: Mapping[int, Shape]) -> None:
        """Find the axis anew from what is placed now."""
        if not self.turntable:
            return
        self.fit = find_axis(
            [list(shape.members.values()) for shape in objects.values()],
            np.mean(list(self._middles.values()), axis=0), self._config.tilt_deg,
            self._config.distance_mr * self._unit)
        self._way = self._direction(objects)

    def known(self, source: Shape, target: Shape) -> Known | None:
        """Return what is known of the pose of `source` in the frame of `target`."""
        if not self.active or self._doubted:
            return None
        axis = self.fit.axis if self.fit else None
        # A pose takes the source to the target: the table has turned on from the latter.
        since = self._order[source.first] - self._order[target.first]
        turns = None
        if self._config.step_deg > 0:
            turn = math.radians(self._config.step_deg) * since
            turns = (self._way * turn,) if self._way else (turn, -turn)
        way = self._way * since if self._config.order and abs(since) == 1 else 0
        return Known(self._config, axis, turns, way, self._metre)

    def fine_prior(
        self, names: Sequence[str], surfaces: Mapping[str, Surface]
    ) -> FinePrior | None:
        """Return what the views of an object have in common."""
        planes = [surfaces[name].support if self._config.plane else None for name in names]
        if self._doubted:
            return None
        axis = self.fit.axis if self.fit else None
        if axis is None and sum(plane is not None for plane in planes) < 2:
            return None
        return FinePrior(planes, axis, self._config.weight)

    def doubt(self) -> None:
        """Go on without what was said of the station."""
        self._doubted = True

    def accept(self, object_id: int, free: FineResult, bound: FineResult) -> bool:
        """Whether the poses refined with what is known explain the data about as well."""
        self.unused.pop(object_id, None)
        if bound.residual_mr <= self._config.harm * free.residual_mr:
            return True
        self.unused[object_id] = (
            f'it would raise the residual from {free.residual_mr:.3f} to '
            f'{bound.residual_mr:.3f} mr')
        return False

    def facts(self, objects: Mapping[int, Shape]) -> dict[str, Any]:
        """Return what was known, found and used, in JSON's own types."""
        said: dict[str, Any] = {
            'plane': self._config.plane, 'axis': self.turntable, 'order': self._config.order,
            'step_deg': self._config.step_deg,
        }
        if self._config.plane:
            said['planes_seen'] = self._planes
        if self._config.fixed_frame:
            said['fixed_frame'] = self._config.fixed_frame
            said['sensor_poses'] = self._posed
        if self.fit is not None:
            axis = self.fit.axis
            said['axis_found'] = {
                'direction': list(axis.direction), 'point': list(axis.point),
                'share_of_motions': self.fit.share, 'tilt_deg': self.fit.tilt_deg,
                'distance': self.fit.distance,
            }
            said['turns_deg'] = {
                name: math.degrees(axis.angle(np.linalg.inv(first) @ pose))
                for shape in objects.values()
                for first in [shape.members[shape.first]]
                for name, pose in shape.members.items()
            }
        elif self.turntable:
            said['axis_found'] = None
        if self._doubted:
            said['not_believed'] = (
                'fewer than half of the views found a place with it, so the rest was tried '
                'without')
        if self.unused:
            said['not_used_to_refine'] = {str(k): why for k, why in self.unused.items()}
        return said

    def _direction(self, objects: Mapping[int, Shape]) -> int:
        """Tell which way the table turns from a view to the next, +1 or -1; 0 if unknown."""
        if self.fit is None:
            return 0
        votes = 0
        for shape in objects.values():
            names = sorted(shape.members, key=self._order.__getitem__)
            for a, b in itertools.pairwise(names):
                if self._order[b] - self._order[a] == 1:
                    motion = np.linalg.inv(shape.members[a]) @ shape.members[b]
                    votes += 1 if self.fit.axis.angle(motion) > 0 else -1
        return (votes > 0) - (votes < 0)
