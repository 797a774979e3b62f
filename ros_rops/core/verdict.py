# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a pose is believed, doubted or refused, and why."""

from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np
from ros_rops.core.config import VerdictConfig
from ros_rops.core.search import Candidates, FINAL, final_scores
from ros_rops.core.station import Known
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Status
from ros_rops.kernels.verification import centred, distinct, Examination, examine

# The best candidates, which are refined on vertices before one is chosen.
FINALISTS = 5
# Poses closer than both are one solution, found with less care.
RIVAL_ANGLE_RAD = math.radians(12.0)
RIVAL_DISTANCE_MR = 10.0
# Residuals below this are alike: the meshes are no finer.
FINEST_MR = 0.05
# A shape of so many views has drifted a little until its views are refined together: rays that
# pass by the object, which are exact about its outline, may contradict it by so much more.
DRIFTING_VIEWS = 3
DRIFT = 1.5
ROUNDS = 8
SAMPLES = 2000
# Vertices within two resolutions overlap (III-C); depth contradicts beyond three.
RADIUS_MR = 2.0
FRONT_MR = 3.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """
    The word on one pose.

    Parameters
    ----------
    status : Status
        PLACED, AMBIGUOUS or REFUSED.
    T_target_source : (4, 4) float64 or None
        None unless placed.
    reason : str
    numbers : mapping of str to float
    """

    status: Status
    T_target_source: Floats | None
    reason: str
    numbers: Mapping[str, float]


def judge(
    source: Surface, target: Surface, candidates: Candidates, config: VerdictConfig,
    known: Known | None = None, *, threads: int = 0,
) -> Verdict:
    """
    Judge the best candidate, its rivals in view.

    The best few are refined on vertices and scored again; those that end in one pose are one.

    Parameters
    ----------
    source, target : Surface
    candidates : Candidates
    config : VerdictConfig
    known : Known, optional
        What a pose must not contradict.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    Verdict
    """
    if not len(candidates.poses):
        why = 'a side has no features' if known is None else 'none agrees with what is known'
        return Verdict(Status.REFUSED, None, f'no hypothesis: {why}', {})
    unit = 0.5 * (source.resolution + target.resolution)
    limit = residual_limit(source, target, unit, config)
    drifted = any(
        side.beyond and side.views >= DRIFTING_VIEWS
        for side in (source.evidence, target.evidence))
    most = config.contradiction * (DRIFT if drifted else 1.0)
    finalists = _admitted(source, target, known, sorted(
        _examined(source, target, candidates.poses[:FINALISTS], unit, limit, most, threads),
        key=lambda finalist: _worth(finalist.numbers, config), reverse=True))
    best = finalists[0]
    numbers = best.numbers | {'rival': _rival(source, target, finalists, unit, config)}
    status, reason = _word(numbers, config)
    objection = known.objection(best.T_target_source, source, target) if known else ''
    if status is Status.PLACED and objection:
        status, reason = Status.REFUSED, objection
    placed = best.T_target_source if status is Status.PLACED else None
    return Verdict(status, placed, reason, numbers)


@dataclass(frozen=True, slots=True)
class _Finalist:
    T_target_source: Floats
    numbers: dict[str, float]


def _examined(
    source: Surface, target: Surface, poses: Floats, unit: float, limit: float,
    contradiction: float, threads: int,
) -> list[_Finalist]:
    """Refine and measure each pose, in the order given."""
    exams = examine(
        source.evidence, target.evidence, poses, rounds=ROUNDS, samples=SAMPLES,
        radius=RADIUS_MR * unit, front=FRONT_MR * unit, threads=threads)
    refined = np.stack([exam.T_target_source for exam in exams])
    scores = final_scores(source, target, refined, unit, threads=threads)
    return [
        _Finalist(exam.T_target_source, {
            **_numbers(exam, float(score), unit),
            'residual_most_mr': limit,
            'contradiction_most': contradiction,
            'area_mr2': _area(exam, source, target) / unit**2,
        })
        for exam, score in zip(exams, scores, strict=True)
    ]


def _admitted(
    source: Surface, target: Surface, known: Known | None, finalists: list[_Finalist]
) -> list[_Finalist]:
    """Leave out what contradicts what is known, unless that is all."""
    if known is None:
        return finalists
    return [
        finalist for finalist in finalists
        if not known.objection(finalist.T_target_source, source, target)] or finalists


def _rival(
    source: Surface,
    target: Surface,
    finalists: list[_Finalist],
    unit: float,
    config: VerdictConfig,
) -> float:
    """
    Tell how well the best other pose explains the data, as a share of the best.

    The ratio of the scores, times that of the residuals: over hundreds of matches a residual
    twice as large tells two poses apart as surely as half the overlap.
    """
    poses = centred(
        np.stack([f.T_target_source for f in finalists]), source.evidence, target.evidence)
    best = _worth(finalists[0].numbers, config)
    for k, finalist in enumerate(finalists[1:], start=1):
        apart = len(distinct(
            poses[[0, k]], angle_rad=RIVAL_ANGLE_RAD, distance=RIVAL_DISTANCE_MR * unit,
            most=2)) == 2
        if apart and _believed(finalist.numbers, config):
            return _worth(finalist.numbers, config)[1] / best[1]
    return 0.0


def _believed(numbers: Mapping[str, float], config: VerdictConfig) -> bool:
    return (
        numbers['score'] >= least_score(numbers, config)
        and numbers['residual_mr'] <= numbers['residual_most_mr'])


def _worth(numbers: Mapping[str, float], config: VerdictConfig) -> tuple[bool, float]:
    """Rank of a pose: believed ones by score over residual, then the others by score."""
    believed = _believed(numbers, config)
    fit = max(numbers['residual_mr'], FINEST_MR) if believed else 1.0
    return believed, numbers['score'] / fit


def better(verdict: Verdict, other: Verdict, config: VerdictConfig) -> bool:
    """Tell whether the pose that a verdict is on explains the views better than another's."""
    return _worth(verdict.numbers, config) > _worth(other.numbers, config)


def residual_limit(
    source: Surface, target: Surface, unit: float, config: VerdictConfig
) -> float:
    """
    Most mean distance (mr) that matched points of these two sides may have.

    Two surfaces with noise s1, s2 differ by sqrt(2/pi) sqrt(s1^2 + s2^2) in the mean.
    """
    noise = math.hypot(source.evidence.noise, target.evidence.noise) / unit
    return max(config.residual_mr, config.noise_factor * math.sqrt(2.0 / math.pi) * noise)


def _area(exam: Examination, source: Surface, target: Surface) -> float:
    """Area of the overlap: the mean of what both sides say."""
    shares = exam.numbers[:, 1] / np.maximum(exam.numbers[:, 0], 1.0)
    return float(shares @ (source.evidence.area, target.evidence.area)) / 2.0


def _numbers(exam: Examination, score: float, unit: float) -> dict[str, float]:
    tried, matched, absolute, front, empty, disagree = exam.numbers.sum(axis=0)
    matches = max(matched, 1.0)
    return {
        'score': score,
        'residual_mr': float(absolute / matches / unit),
        'overlap': float(matched / max(tried, 1.0)),
        'overlap_source': float(exam.numbers[0, 1] / max(exam.numbers[0, 0], 1.0)),
        'in_front': float(front / matches),
        'unseen': float(empty / matches),
        'disagree': float(disagree / matches),
        'stiffness': stiffness(exam.hessian, matches),
    }


def self_stiffness(surface: Surface) -> float:
    """How firmly a surface holds itself: near 0 for a plane, a sphere, a cylinder."""
    exam, = examine(
        surface.evidence, surface.evidence, np.eye(4)[None], rounds=0, samples=SAMPLES,
        radius=RADIUS_MR * surface.resolution, front=FRONT_MR * surface.resolution)
    return stiffness(exam.hessian, max(exam.numbers[:, 1].sum(), 1.0))


def stiffness(hessian: Floats, matches: float) -> float:
    """
    Least mean squared distance that a motion of unit mean size brings about.

    Parameters
    ----------
    hessian : (6, 6) float64
        Of the point-to-plane problem by turn and shift.
    matches : float
        Number of matches summed.

    Returns
    -------
    float
        0 for a surface that slides on itself, about 0.1 for a well-held one. The turn is
        measured by the mean motion of the matched points that it causes.
    """
    # Sum of squared lever arms along the normals stands for the mean motion by a turn.
    arm = np.sqrt(max(np.trace(hessian[:3, :3]) / max(np.trace(hessian[3:, 3:]), 1e-300), 1e-300))
    scale = np.diag([1.0 / arm] * 3 + [1.0] * 3)
    values = np.linalg.eigvalsh(scale @ hessian @ scale / matches)
    return float(max(values[0], 0.0))


def least_score(numbers: Mapping[str, float], config: VerdictConfig) -> float:
    """Score that a pose needs: more where little surface speaks for it."""
    if numbers['area_mr2'] <= 0:
        return math.inf
    return config.score_least * max(1.0, config.area_mr2 / numbers['area_mr2'])


def against(numbers: Mapping[str, float]) -> float:
    """Weigh what the rays contradict, as a share of what matches."""
    return FINAL.front * numbers['in_front'] + FINAL.empty * numbers['unseen']


def _word(numbers: Mapping[str, float], config: VerdictConfig) -> tuple[Status, str]:
    least = least_score(numbers, config)
    if numbers['score'] < least:
        return Status.REFUSED, (
            f'best score {numbers["score"]:.3f} is below {least:.3f} for an overlap of '
            f'{numbers["area_mr2"]:.0f} mr^2: no pose explains the data')
    if numbers['residual_mr'] > numbers['residual_most_mr']:
        return Status.REFUSED, (
            f'residual {numbers["residual_mr"]:.2f} mr is above '
            f'{numbers["residual_most_mr"]:.2f}: the surfaces do not fit')
    # The score is an average over whole views: much overlap would buy off a clear objection.
    if against(numbers) > numbers['contradiction_most']:
        return Status.REFUSED, (
            f'what the rays contradict is {against(numbers):.2f} of what matches, above '
            f'{numbers["contradiction_most"]:.2f}')
    if numbers['stiffness'] < config.stiffness:
        return Status.AMBIGUOUS, (
            f'the surface slides on itself: stiffness {numbers["stiffness"]:.4f} is below '
            f'{config.stiffness}')
    if numbers['rival'] > config.rival:
        return Status.AMBIGUOUS, (
            f'another pose explains the data {numbers["rival"]:.0%} as well as the best')
    return Status.PLACED, (
        f'score {numbers["score"]:.2f}, residual {numbers["residual_mr"]:.2f} mr, overlap '
        f'{numbers["overlap"]:.0%}')
