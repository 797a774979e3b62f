# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What of an object has not been seen, and where to look from next."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ros_rops.core.types import Floats
from ros_rops.modelling.closure import areas_of, close_views, count_groups
from ros_rops.modelling.outlook import Suggestion, suggestions
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.products import SurfaceMesh
from ros_rops.modelling.turning import next_turn, Turn


@dataclass(frozen=True, slots=True)
class Coverage:
    """
    How much of the closed surface was seen.

    Parameters
    ----------
    area, unseen_area : float
        Of the closed surface, in squared units.
    holes : int
        Connected pieces of what is unseen.
    cell : float
        Holes narrower than about three times this length are not told.
    directions : tuple of Suggestion
    turn : Turn or None
        None without a turntable.
    """

    area: float
    unseen_area: float
    holes: int
    cell: float
    directions: tuple[Suggestion, ...]
    turn: Turn | None

    @property
    def unseen_share(self) -> float:
        """Share of the closed surface that no view saw."""
        return self.unseen_area / self.area if self.area > 0 else 0.0

    def document(self) -> dict[str, Any]:
        """Return it in JSON's own types."""
        return {
            'area': self.area, 'unseen_area': self.unseen_area,
            'unseen_share': self.unseen_share, 'holes': self.holes, 'cell': self.cell,
            'directions': [
                {'direction': list(one.direction), 'gain_share': one.gain_share}
                for one in self.directions],
            'turntable': None if self.turn is None else {
                'axis': list(self.turn.axis), 'angle_deg': self.turn.angle_deg,
                'gain_share': self.turn.gain_share}}


def coverage_of(
    views: Sequence[PosedView], surface: SurfaceMesh | None, resolution: float,
    axis: Floats | None, *, threads: int = 0,
) -> Coverage | None:
    """
    Estimate what has not been seen, and where it would be.

    Areas and holes are those of the model's surface where that is closed, what no view saw being
    `filled`; else those of a closed surface estimated for this alone (`closure`), on which the
    directions are always tried.

    Parameters
    ----------
    views : sequence of PosedView
        Those that fit; a wrong one would close what is open.
    surface : SurfaceMesh or None
    resolution : float
    axis : (3,) float64 or None
        Of a turntable, in the object's frame, as `turning.axis_of` returns it.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    Coverage or None
        None if no closed surface comes of the views.
    """
    closure = close_views(views, resolution, threads=threads)
    if closure is None:
        return None
    turn = None if axis is None else next_turn(closure, views, axis)
    areas, unseen, holes, cell = closure.areas, closure.unseen, closure.holes, closure.cell
    directions = suggestions(closure)
    if surface is not None and surface.facts.get('closed'):
        areas, unseen = areas_of(surface.vertices, surface.faces), surface.filled
        holes, cell = count_groups(surface.faces, unseen), resolution
        if not unseen.any():  # the model knows better than the coarse estimate
            directions, turn = (), None
    return Coverage(
        float(areas.sum()), float(areas[unseen].sum()), holes, cell, directions, turn)
