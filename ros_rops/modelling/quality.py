# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
How far the registration of an object may be trusted, per view and on the whole.

Residual maps (`residuals`), views that do not fit (`standing`), the least held motion of each view
(`constraint`), loops (`loops`) and coverage (`coverage`) in one document.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from ros_rops.core import fine_system
from ros_rops.core.config import Config
from ros_rops.core.types import Floats, Units
from ros_rops.modelling.constraint import Constraint, least_constrained
from ros_rops.modelling.coverage import Coverage, coverage_of
from ros_rops.modelling.joint import Joint
from ros_rops.modelling.loops import Loops, loops_of
from ros_rops.modelling.misfits import unheard
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.products import SurfaceMesh
from ros_rops.modelling.residuals import (
    ALONE, CONFIRMED, CONTRADICTED, residuals_of, ViewResiduals)
from ros_rops.modelling.standing import Standing
from ros_rops.modelling.turning import axis_of, ring_of
from ros_rops.modelling.verdicts import flags_of, summary_of


@dataclass(frozen=True, slots=True)
class Edge:
    """
    Two views that overlap, by name.

    Parameters
    ----------
    source, target : str
    overlap : float
        Share of the samples of both that match.
    residual : float
        Mean |point-to-plane distance| of the matches, in units.
    """

    source: str
    target: str
    overlap: float
    residual: float


@dataclass(frozen=True, slots=True)
class ViewQuality:
    """
    How one view fits the others.

    Parameters
    ----------
    name : str
    number : int
    points : int
    residual : mapping or None
        `mean`, `median`, `p90`, `rms` of |residual|, in units; None if no other view saw a place.
    shares : tuple of three floats
        Of the points judged: alone, confirmed, contradicted.
    least_constrained : Constraint or None
    flags : tuple of str
        Sentences.
    left_out : bool
        Whether it does not fit, and neither cloud nor surface is made of it.
    """

    name: str
    number: int
    points: int
    residual: dict[str, float] | None
    shares: tuple[float, float, float]
    least_constrained: Constraint | None
    flags: tuple[str, ...]
    left_out: bool

    def document(self) -> dict[str, Any]:
        """Return it in JSON's own types."""
        held = self.least_constrained
        return {
            'name': self.name, 'number': self.number, 'points': self.points,
            'residual': self.residual, 'confirmed': self.shares[CONFIRMED],
            'contradicted': self.shares[CONTRADICTED], 'alone': self.shares[ALONE],
            'least_constrained': None if held is None else held.document(),
            'flags': list(self.flags), 'left_out': self.left_out}


@dataclass(frozen=True, slots=True)
class Quality:
    """
    How far an object's registration may be trusted; lengths in the units of the views.

    Parameters
    ----------
    resolution : float
    noise : float
        Standard deviation of right views' distances to each other, estimated from the data;
        three times it tells confirmed from contradicted.
    views : tuple of ViewQuality
    residuals : tuple of ViewResiduals
        In the order of the views.
    worst_views : tuple of str
        Those that stand out, worst first.
    left_out : tuple of str
        Those of them that neither cloud nor surface is made of.
    edges : tuple of Edge
    loops : Loops or None
    coverage : Coverage or None
    summary : str
    """

    resolution: float
    noise: float
    views: tuple[ViewQuality, ...]
    residuals: tuple[ViewResiduals, ...]
    worst_views: tuple[str, ...]
    left_out: tuple[str, ...]
    edges: tuple[Edge, ...]
    loops: Loops | None
    coverage: Coverage | None
    summary: str

    def document(self) -> dict[str, Any]:
        """Return what `quality.json` says of the object, in JSON's own types."""
        names = [one.name for one in self.views]
        return {
            'mesh_resolution': self.resolution,
            'noise': self.noise,
            'views': [one.document() for one in self.views],
            'worst_views': list(self.worst_views),
            'left_out': list(self.left_out),
            'edges': [
                {'source': one.source, 'target': one.target, 'overlap': one.overlap,
                 'residual': one.residual} for one in self.edges],
            'loops': None if self.loops is None else self.loops.document(names),
            'coverage': None if self.coverage is None else self.coverage.document(),
            'summary': self.summary}


def assess(
    views: Sequence[PosedView], standing: Standing, surface: SurfaceMesh | None, config: Config,
    *, resolution: float, turntable_axis: Floats | None = None, threads: int = 0,
) -> Quality:
    """
    Judge the registration of an object.

    Parameters
    ----------
    views : sequence of PosedView
        One or more.
    standing : Standing
        What `judge` found of them.
    surface : SurfaceMesh or None
        Tells what is unseen where it is closed; else that is estimated.
    config : Config
        Group `prior`: what a turntable's motions may differ by.
    resolution : float
        Mean of the views' mesh resolutions (dres).
    turntable_axis : (3,) float64, optional
        Direction of the axis that the object was turned about, in its frame; looked for in the
        poses by default.
    threads : int
        0 takes all cores; no influence on the result.
    """
    joint, misfits = standing.joint, standing.misfits
    maps = residuals_of(views, standing.votes, standing.noise, unheard(len(views), misfits))
    right = standing.right(views)
    axis = axis_of(right, turntable_axis, config.prior, resolution)
    ring = () if axis is None else ring_of(views, axis, config.prior.tilt_deg)
    coverage = coverage_of(right, surface, resolution, axis, threads=threads)
    judged = _judged(views, maps, standing, resolution)
    names = [one.name for one in views]
    return Quality(
        resolution, standing.noise, judged, maps, tuple(names[one.index] for one in misfits),
        tuple(names[k] for k in standing.left_out),
        () if joint is None else _edges(joint, names),
        None if joint is None else loops_of(joint, ring, threads=threads),
        coverage,
        summary_of(views, maps, misfits, [one.least_constrained for one in judged], coverage))


def _edges(joint: Joint, names: Sequence[str]) -> tuple[Edge, ...]:
    unit = joint.problem.resolution
    return tuple(
        Edge(names[one.source], names[one.target], one.overlap, one.residual_mr * unit)
        for one in joint.edges)


def _judged(
    views: Sequence[PosedView], maps: Sequence[ViewResiduals], standing: Standing,
    resolution: float,
) -> tuple[ViewQuality, ...]:
    joint = standing.joint
    constraints = (
        [None] * len(views) if joint is None else _constraints(joint, views[0].view.units))
    found = {one.index: one for one in standing.misfits}
    result = []
    for k, (view, one, constraint) in enumerate(zip(views, maps, constraints, strict=True)):
        shares = np.bincount(one.state, minlength=3) / max(len(one.state), 1)
        alone, confirmed, contradicted = (float(share) for share in shares)
        misfit = found.get(k)
        other = None if misfit is None else misfit.rival
        left_out = k in standing.left_out
        flags = flags_of(
            view, misfit, None if other is None else views[other].name, alone, constraint,
            resolution, single=len(views) == 1, left_out=left_out)
        result.append(ViewQuality(
            view.name, view.number, len(view.view.points), _statistics(one),
            (alone, confirmed, contradicted), constraint, flags, left_out))
    return tuple(result)


def _constraints(joint: Joint, units: Units) -> list[Constraint | None]:
    stiffness = fine_system.stiffness_of(joint.system())
    frames = joint.problem.frames()
    return [
        least_constrained(
            values, motions, middle, float(size), joint.problem.config.least_stiffness, units)
        for values, motions, middle, size in zip(
            stiffness.values, stiffness.motions, frames.middles, frames.sizes, strict=True)]


def _statistics(one: ViewResiduals) -> dict[str, float] | None:
    """Return mean, median, 90th percentile and root mean square of |residual|."""
    known = np.abs(one.residual[np.isfinite(one.residual)]).astype(np.float64)
    if not len(known):
        return None
    return {
        'mean': float(known.mean()), 'median': float(np.median(known)),
        'p90': float(np.percentile(known, 90)),
        'rms': float(np.sqrt(np.mean(np.square(known))))}
