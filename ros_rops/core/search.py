# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""From many hypotheses to the few poses worth a verdict (METHOD: what lifts recall)."""

from dataclasses import dataclass
import math

import numpy as np

from ros_rops.core.config import PairwiseConfig
from ros_rops.core.matching import frame_transforms
from ros_rops.core.station import Known
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Ints
from ros_rops.kernels.verification import centred, distinct, refine, score, Scores

# Hypotheses closer than this lead to the same refined pose.
SAME_ANGLE_RAD = math.radians(8.0)
SAME_DISTANCE_MR = 6.0
FAR_ANGLE_RAD = math.radians(30.0)
FAR_DISTANCE_MR = 20.0
# Poses that differ by less after refinement are one.
ONE_ANGLE_RAD = math.radians(5.0)
ONE_DISTANCE_MR = 4.0
# Least cosine between the normals of matched samples while a pose is still coarse.
COARSE_AGREE = 0.3
# Of the hypotheses scored on few samples, this part is scored on more.
LEVEL_SHARE = 4
# Refined poses are judged more sharply than hypotheses.
FINAL_TAU_MR = 3.0
FINAL_FRONT_MR = 4.0
FINAL_SAMPLES = 500


@dataclass(frozen=True, slots=True)
class Weights:
    """What contradictions cost, in shares of the samples."""

    front: float
    empty: float
    disagree: float


COARSE = Weights(front=1.0, empty=0.5, disagree=0.0)
FINAL = Weights(front=3.0, empty=0.5, disagree=0.3)


@dataclass(frozen=True, slots=True)
class Candidates:
    """
    Refined poses, best first, distinct.

    Parameters
    ----------
    poses : (C, 4, 4) float64
        `T_target_source`.
    scores : (C,) float64
    hypotheses, refined : int
        How many went in; how many were refined.
    """

    poses: Floats
    scores: Floats
    hypotheses: int
    refined: int


def random_transforms(
    source: Surface, target: Surface, count: int, rng: np.random.Generator
) -> Floats:
    """
    Pair local frames at random: rough starts without descriptors.

    Returns
    -------
    (count, 4, 4) float64
        `T_target_source`; none if a side has no features.
    """
    a, b = source.features, target.features
    if not len(a.indices) or not len(b.indices):
        return np.empty((0, 4, 4))
    i = rng.integers(0, len(a.indices), count)
    j = rng.integers(0, len(b.indices), count)
    return frame_transforms(a.positions[i], a.lrfs[i], b.positions[j], b.lrfs[j])


def worth(scores: Scores, weights: Weights) -> Floats:
    """One number (H,) a pose: overlap less the contradictions, mean of both directions."""
    both = (
        scores.overlap - weights.front * scores.front - weights.empty * scores.empty
        - weights.disagree * scores.disagree)
    mean: Floats = both.mean(axis=1)
    return mean


def final_scores(
    source: Surface, target: Surface, poses: Floats, unit: float, *, threads: int = 0
) -> Floats:
    """
    Score refined poses (H, 4, 4): the number (H,) that the verdict rests on.

    `unit` is the mean resolution of the two sides.
    """
    return worth(score(
        source.evidence, target.evidence, poses, samples=FINAL_SAMPLES,
        tau=FINAL_TAU_MR * unit, front=FINAL_FRONT_MR * unit, threads=threads), FINAL)


def search(
    source: Surface,
    target: Surface,
    hypotheses: Floats,
    most: int,
    config: PairwiseConfig,
    *,
    threads: int = 0,
    known: Known | None = None,
) -> Candidates:
    """
    Score all hypotheses, refine the best that differ, score again.

    Parameters
    ----------
    source, target : Surface
    hypotheses : (H, 4, 4) float64
        `T_target_source`.
    most : int
        Hypotheses refined at most.
    config : PairwiseConfig
    threads : int
        0 takes all cores; no influence on the result.
    known : Known, optional
        Poses that do not agree with it are no candidates.
    """
    chosen, _ = best_apart(source, target, hypotheses, most, config, threads=threads)
    poses = _refined(source, target, chosen, config, threads)
    if known is not None:
        poses = poses[known.admits(poses, source, target)]
    return _ranked(source, target, poses, len(hypotheses), len(chosen), threads)


def refined_again(
    source: Surface, target: Surface, poses: Floats, config: PairwiseConfig, *, threads: int = 0
) -> Candidates:
    """Refine poses (P, 4, 4) as `search` does, all of them; the distinct ones, best first."""
    again = _refined(source, target, poses, config, threads)
    return _ranked(source, target, again, len(poses), len(poses), threads)


def _refined(
    source: Surface, target: Surface, poses: Floats, config: PairwiseConfig, threads: int
) -> Floats:
    unit = 0.5 * (source.resolution + target.resolution)
    radii = unit * np.linspace(config.radius_start_mr, config.radius_end_mr, config.rounds)
    return refine(
        source.evidence, target.evidence, poses, radii,
        samples=config.samples_refine, agree=COARSE_AGREE, threads=threads)


def _ranked(
    source: Surface, target: Surface, poses: Floats, hypotheses: int, refined: int, threads: int
) -> Candidates:
    """Score refined poses; keep those that differ, best first."""
    unit = 0.5 * (source.resolution + target.resolution)
    values = final_scores(source, target, poses, unit, threads=threads)
    order = np.argsort(-values, kind='stable')
    kept = order[distinct(
        centred(poses[order], source.evidence, target.evidence),
        angle_rad=ONE_ANGLE_RAD, distance=ONE_DISTANCE_MR * unit, most=len(order))]
    return Candidates(poses[kept], values[kept], hypotheses, refined)


def promising(
    source: Surface,
    target: Surface,
    hypotheses: Floats,
    most: int,
    config: PairwiseConfig,
    *,
    threads: int = 0,
) -> tuple[Floats, Floats]:
    """
    Score hypotheses on few samples, the better ones on more, and so on.

    Returns
    -------
    poses : (M, 4, 4) float64
        The best, M at least `most` if there are so many; best first.
    scores : (M,) float64
        On `samples_fine` samples.
    """
    unit = 0.5 * (source.resolution + target.resolution)
    poses, values = hypotheses, np.zeros(len(hypotheses))
    levels = (config.samples_first, config.samples_coarse, config.samples_fine)
    for samples in levels:
        values = worth(score(
            source.evidence, target.evidence, poses, samples=samples,
            tau=config.tau_mr * unit, front=config.front_mr * unit, threads=threads), COARSE)
        order = np.argsort(-values, kind='stable')
        poses, values = poses[order], values[order]
        if samples != levels[-1]:
            keep = max(len(poses) // LEVEL_SHARE, 2 * most)
            far = _far_apart(source, target, poses, most, unit)
            kept = np.union1d(np.arange(min(keep, len(poses))), far)
            poses, values = poses[kept], values[kept]
    return poses, values


def _far_apart(
    source: Surface, target: Surface, poses: Floats, most: int, unit: float
) -> Ints:
    """
    Choose at most `most` of the poses, in their order, that are far apart.

    The neighbours of one good pose are all good; they must not crowd its rivals out.
    """
    return distinct(
        centred(poses, source.evidence, target.evidence),
        angle_rad=FAR_ANGLE_RAD, distance=FAR_DISTANCE_MR * unit, most=most)


def best_apart(
    source: Surface,
    target: Surface,
    hypotheses: Floats,
    most: int,
    config: PairwiseConfig,
    *,
    threads: int = 0,
) -> tuple[Floats, float]:
    """
    Choose at most `most` hypotheses that score best and differ.

    Returns
    -------
    poses : (P, 4, 4) float64
    score : float
        The best of all; -inf without any.
    """
    unit = 0.5 * (source.resolution + target.resolution)
    poses, scores = promising(source, target, hypotheses, most, config, threads=threads)
    about = centred(poses, source.evidence, target.evidence)
    far = _far_apart(source, target, poses, (most + 1) // 2, unit)
    order = np.concatenate([far, np.setdiff1d(np.arange(len(poses)), far)])
    kept = distinct(
        about[order], angle_rad=SAME_ANGLE_RAD, distance=SAME_DISTANCE_MR * unit, most=most)
    chosen: Floats = poses[order[kept]]
    return chosen, float(scores[0]) if len(scores) else -math.inf
