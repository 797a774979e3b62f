# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a pose is believed, doubted or refused, and why."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ros_rops.core.config import VerdictConfig
from ros_rops.core.search import Candidates
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Status
from ros_rops.kernels.verification import examine, Examination

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
    source: Surface, target: Surface, candidates: Candidates, config: VerdictConfig
) -> Verdict:
    """
    Judge the best candidate, its rivals in view.

    Parameters
    ----------
    source, target : Surface
    candidates : Candidates
    config : VerdictConfig

    Returns
    -------
    Verdict
    """
    if not len(candidates.poses):
        return Verdict(Status.REFUSED, None, 'no hypothesis: a side has no features', {})
    unit = 0.5 * (source.resolution + target.resolution)
    exam = examine(
        source.evidence, target.evidence, candidates.poses[0], rounds=ROUNDS, samples=SAMPLES,
        radius=RADIUS_MR * unit, front=FRONT_MR * unit)
    numbers = _numbers(exam, candidates, unit)
    status, reason = _word(numbers, config)
    placed = exam.T_target_source if status is Status.PLACED else None
    return Verdict(status, placed, reason, numbers)


def _numbers(exam: Examination, candidates: Candidates, unit: float) -> dict[str, float]:
    tried, matched, absolute, front, empty, disagree = exam.numbers.sum(axis=0)
    matches = max(matched, 1.0)
    rival = candidates.scores[1] / candidates.scores[0] if len(candidates.scores) > 1 else 0.0
    return {
        'score': float(candidates.scores[0]),
        'rival': float(rival) if candidates.scores[0] > 0 else 1.0,
        'residual_mr': float(absolute / matches / unit),
        'overlap': float(matched / max(tried, 1.0)),
        'overlap_source': float(exam.numbers[0, 1] / max(exam.numbers[0, 0], 1.0)),
        'in_front': float(front / matches),
        'unseen': float(empty / matches),
        'disagree': float(disagree / matches),
        'stiffness': stiffness(exam.hessian, matches),
    }


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


def _word(numbers: Mapping[str, float], config: VerdictConfig) -> tuple[Status, str]:
    if numbers['score'] < config.score_least:
        return Status.REFUSED, (
            f'best score {numbers["score"]:.3f} is below {config.score_least}: no pose explains '
            f'the data')
    if numbers['residual_mr'] > config.residual_mr:
        return Status.REFUSED, (
            f'residual {numbers["residual_mr"]:.2f} mr is above {config.residual_mr}: the '
            f'surfaces do not fit')
    if numbers['stiffness'] < config.stiffness:
        return Status.AMBIGUOUS, (
            f'the surface slides on itself: stiffness {numbers["stiffness"]:.4f} is below '
            f'{config.stiffness}')
    if numbers['rival'] > config.rival:
        return Status.AMBIGUOUS, (
            f'another pose scores {numbers["rival"]:.0%} of the best')
    return Status.PLACED, (
        f'score {numbers["score"]:.2f}, residual {numbers["residual_mr"]:.2f} mr, overlap '
        f'{numbers["overlap"]:.0%}')
