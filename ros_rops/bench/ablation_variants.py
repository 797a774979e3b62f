# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The choices of the engine that the paper made otherwise, and what each is exchanged for."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ros_rops.bench.contest import Answer, Contestant, engine
from ros_rops.bench.settings import derive, MODES
from ros_rops.core.config import Config
from ros_rops.core.types import RangeView, SensorModel, Status

# Parameters of these groups change what is prepared of a view.
PREPARED_BY = ('mesh.', 'keypoints.', 'lrf.', 'rops.', 'evidence.')

FEATURES: Mapping[str, object] = {
    'keypoints.method': 'paper', 'keypoints.eigen_ratio': 1.02, 'lrf.method': 'rops',
    'rops.radius_mr': 15.0, 'matching.neighbours': 1, 'matching.both_directions': False,
    'pairwise.half_turns': False}
# The preset config/paper.yaml, where it differs from the defaults.
PAPER: Mapping[str, object] = {
    **FEATURES, 'ccv.metric': 'euler', 'ccv.verified': 1000000, 'icp.method': 'paper',
    'pairwise.method': 'paper', 'pairwise.random_starts': 0, 'fine.method': 'williams'}
# Every pose passes, so that something else may judge it.
CREDULOUS: Mapping[str, object] = {
    'verdict.score_least': 0.0, 'verdict.residual_mr': 2.0, 'verdict.contradiction': 100.0,
    'verdict.rival': 1.0, 'verdict.stiffness': 0.0}
ALONE: Mapping[str, object] = MODES['features-only']


@dataclass(frozen=True, slots=True)
class Variant:
    """
    One choice exchanged.

    Parameters
    ----------
    label : str
        What is exchanged for what, ours in parentheses.
    changes : mapping of str to object
        Parameters (dotted names).
    rays : bool
        Whether the sensors' lines of sight testify.
    by_overlap : bool
        Whether a pose is accepted by its overlap alone (`verdict.overlap_least`, IV-A).
    """

    label: str
    changes: Mapping[str, object] = field(default_factory=dict)
    rays: bool = True
    by_overlap: bool = False

    def preparation(self) -> tuple[object, ...]:
        """Return what tells whether two variants may share prepared views."""
        return (self.rays, *sorted(
            (name, value) for name, value in self.changes.items()
            if name.startswith(PREPARED_BY)))

    def contestant(
        self, config: Config, changes: Mapping[str, object], *, threads: int = 0
    ) -> Contestant:
        """Return the engine with this choice exchanged and the `changes` made before it."""
        settings = derive(config, {**changes, **self.changes})
        one = engine(settings, threads=threads)
        prepare = one.prepare if self.rays else _without_rays(one.prepare, settings)
        register = one.register
        if self.by_overlap:
            register = _judged_by_overlap(register, settings.verdict.overlap_least)
        return Contestant(self.label, prepare, register)


# Measured on RoPS alone: what the random starts would make up for shows there.
ON_FEATURES: tuple[Variant, ...] = (
    Variant('ours'),
    Variant('keypoints near a simplified mesh (all vertices)', {'keypoints.method': 'paper'}),
    Variant('eigenvalue ratio above 1.02 (1)', {'keypoints.eigen_ratio': 1.02}),
    Variant('margin to the boundary 5 mr (1 mr)', {'keypoints.boundary_mr': 5.0}),
    Variant('frame of RoPS (TOLDI)', {'lrf.method': 'rops'}),
    Variant('radius 15 mr (10 mr)', {'rops.radius_mr': 15.0}),
    Variant('nearest neighbour (3)', {'matching.neighbours': 1}),
    Variant('source to target (both ways)', {'matching.both_directions': False}),
    Variant('poses of matches as they are (half-turned, too)', {'pairwise.half_turns': False}),
    Variant('CCV groups (each match)', {'pairwise.hypotheses': 'ccv'}),
    Variant('all features and matches as the paper', FEATURES),
    # A fifth of the starts joins the quick search, which is all there is with 20 poses refined.
    Variant('random starts instead, 2,000 scored', {
        'pairwise.matches': False, 'pairwise.random_starts': 10000}),
    Variant('random starts instead, 10,000 scored', {
        'pairwise.matches': False, 'pairwise.random_starts': 50000}),
)
# Measured on the whole engine.
ON_SEARCH: tuple[Variant, ...] = (
    Variant('ours'),
    Variant('no random starts (10,000)', {'pairwise.random_starts': 0}),
    Variant('20 poses refined (1000)', {'pairwise.refined': 20}),
    Variant('300 poses refined (1000)', {'pairwise.refined': 300}),
    Variant('lines of sight unknown (known)', rays=False),
    Variant('accepted by overlap above 0.5 (score, residual, rays)', CREDULOUS, by_overlap=True),
    Variant('all features and matches as the paper', FEATURES),
    Variant('everything as the paper', PAPER),
)
GROUPS: Mapping[str, tuple[Mapping[str, object], tuple[Variant, ...]]] = {
    'RoPS alone': (ALONE, ON_FEATURES), 'whole engine': ({}, ON_SEARCH)}


def _without_rays(
    prepare: Callable[[RangeView], Any], config: Config
) -> Callable[[RangeView], Any]:
    """Prepare a view, then forget where its sensor was: the mesh needs it, nothing after it."""
    from ros_rops.core.surface import make_surface

    def blind(view: RangeView) -> Any:
        prepared = prepare(view)
        surface = make_surface(
            view.name, prepared.mesh, SensorModel('unknown'), config,
            resolution=prepared.surface.resolution, threads=1)
        return replace(prepared, surface=surface)

    return blind


def _judged_by_overlap(
    register: Callable[[Any, Any], Answer], least: float
) -> Callable[[Any, Any], Answer]:
    def judged(source: Any, target: Any) -> Answer:
        answer = register(source, target)
        overlap = answer.numbers.get('overlap_source', 0.0)
        if answer.status is not Status.PLACED or overlap > least:
            return answer
        return Answer(Status.REFUSED, None, f'overlap {overlap:.0%}', answer.numbers)

    return judged
