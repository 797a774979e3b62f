# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Table I: correct pairs by the way from matches to a pose, at several thresholds."""

from collections.abc import Sequence
from dataclasses import dataclass, field
import time
from typing import Any

import numpy as np
from ros_rops.bench.ablation_variants import PAPER
from ros_rops.bench.contest import errors_in
from ros_rops.bench.errors import CORRECT_DEG, PairErrors
from ros_rops.bench.experiment import Experiment, Laboratory
from ros_rops.bench.paper.engine_pairs import engine_pairs
from ros_rops.bench.paper.table1_show import notes, show, THRESHOLDS
from ros_rops.bench.rivals.estimator import Estimator
from ros_rops.bench.rivals.estimators import ESTIMATORS
from ros_rops.bench.settings import derive
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.core.hypotheses import Matched, matched
from ros_rops.core.icp import paper_icp
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats
from ros_rops.pipeline.prepare import prepare

OURS = 'ours'
STAGES = ('coarse', 'fine')
# With our features the cheaper ones are enough to tell what the features change.
FEW = ('CCV', 'CCV, refit', 'LSF', 'RANSAC-1000', 'RANSAC [17]')
# What makes a feature; the rest stays as the paper has it, so that estimators alone differ.
FEATURES = ('keypoints.', 'lrf.', 'rops.')


@dataclass(slots=True)
class Score:
    """What became of the pairs of one set by one estimator: correct ones by stage, seconds."""

    correct: dict[str, list[int]] = field(
        default_factory=lambda: {stage: [0] * len(THRESHOLDS) for stage in STAGES})
    seconds: list[float] = field(default_factory=list)
    none: int = 0

    def add(self, seconds: float, coarse: PairErrors | None, fine: PairErrors | None) -> None:
        """Count one pair; errors are None without a pose."""
        self.seconds.append(seconds)
        self.none += coarse is None
        for counts, error in zip(self.correct.values(), (coarse, fine), strict=True):
            for k, threshold in enumerate(THRESHOLDS):
                counts[k] += error is not None and within(error, threshold)

    def case(self, dataset: str, features: str, estimator: str) -> dict[str, Any]:
        """Return the line of the result."""
        return {
            'set': dataset, 'features': features, 'estimator': estimator,
            'pairs': len(self.seconds), 'none': self.none, **self.correct,
            'seconds_median': float(np.median(self.seconds)),
            'seconds_sum': float(np.sum(self.seconds))}


def within(error: PairErrors, dres: float) -> bool:
    """Tell whether a pose is correct at a threshold of translation, rotation within 5 degrees."""
    return error.rotation_deg < CORRECT_DEG and error.translation_dres < dres


def features_of(config: Config, whose: str) -> Config:
    """Return the paper's choices, with the features of `config` where these are asked for."""
    return derive(config, {
        name: value for name, value in PAPER.items()
        if whose == 'paper' or not name.startswith(FEATURES)})


def refined(
    source: Surface, target: Surface, pose: Floats | None, config: Config
) -> Floats | None:
    """Refine a pose by the paper's ICP (III-D), None without one."""
    if pose is None:
        return None
    unit = 0.5 * (source.resolution + target.resolution)
    return paper_icp(
        source.evidence.vertices().points, target.evidence.vertices().points, pose, unit,
        config.icp).T_target_source


def timed(
    estimator: Estimator, source: Surface, target: Surface, pairs: Matched, config: Config,
    seed: Sequence[int],
) -> tuple[Floats | None, float]:
    """Return an estimator's pose and the seconds that it took."""
    start = time.perf_counter()
    pose = estimator.estimate(source, target, pairs, config, np.random.default_rng(seed))
    return pose, time.perf_counter() - start


def estimates(
    laboratory: Laboratory, dataset: ReferenceSet, whose: str, estimators: Sequence[Estimator],
) -> list[dict[str, Any]]:
    """Give the same matches of every evaluated pair to all estimators."""
    config = features_of(laboratory.config, whose)
    surfaces = {
        name: prepare(view, config, threads=laboratory.threads).surface
        for name, view in dataset.views.items()}
    truths = [pair for pair in laboratory.pairs(dataset) if pair.evaluated]
    scores = {estimator.name: Score() for estimator in estimators}
    errors_of = errors_in(dataset)
    for number, truth in enumerate(truths):
        laboratory.tell(f'{dataset.name}, features {whose}: pair {number + 1} of {len(truths)}')
        source, target = surfaces[truth.name_i], surfaces[truth.name_j]
        pairs = matched(source, target, config, threads=laboratory.threads)
        for estimator in estimators:
            pose, seconds = timed(
                estimator, source, target, pairs, config, (laboratory.seed, number))
            errors = [
                None if T is None else errors_of(truth, T)
                for T in (pose, refined(source, target, pose, config))]
            scores[estimator.name].add(seconds, *errors)
    return [score.case(dataset.name, whose, name) for name, score in scores.items()]


def ours(laboratory: Laboratory, dataset: ReferenceSet) -> dict[str, Any]:
    """Return the engine's line: its own search, of what it accepts only."""
    score = Score()
    for pair in engine_pairs(laboratory, dataset).pairs:
        if pair.truth.evaluated:
            score.add(pair.seconds, pair.errors, pair.errors)
    return score.case(dataset.name, OURS, OURS)


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Measure all estimators on all real sets, with the paper's features and with ours."""
    cases: list[dict[str, Any]] = []
    few = [estimator for estimator in ESTIMATORS if estimator.name in FEW]
    for dataset in laboratory.sets:
        cases += [
            *estimates(laboratory, dataset, 'paper', ESTIMATORS),
            *estimates(laboratory, dataset, OURS, few), ours(laboratory, dataset)]
    return cases


EXPERIMENT = Experiment(
    'table1', 'Table I: from matches to a pose',
    'Share of the evaluated pairs (overlap at least 10%) within 5 degrees and so many dres. The '
    'same matches go to all: the nearest feature of the target for each of the source. Poses '
    'count whether or not anything would accept them; *ours* is the engine as it is, with its '
    'own features and matches, and counts only what it accepts. In brackets the paper on its '
    'four sets (457 pairs). *Fine*: after the ICP of III-D. Seconds are of the estimate on one '
    'thread, without matching and ICP; of *ours* of all that follows preparation.',
    run, show, notes=notes)
