# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the verification kernels: poses judged by the evidence of two surfaces."""

from typing import NamedTuple

import numpy as np
from ros_rops.core.types import Floats, Ints
from ros_rops.kernels import _kernels
from ros_rops.kernels.evidence import about_centres, Evidence


class Scores(NamedTuple):
    """
    Soft scores of H poses, each (H, 2): source samples on the target, and the reverse.

    Parameters
    ----------
    overlap : (H, 2) float64
        Sum of (1 - d^2/tau^2)^2 times the agreement of the normals, per sample.
    front, empty, disagree : (H, 2) float64
        Shares of the samples in front of what the other side saw; facing its sensor where it
        saw nothing; on a surface that faces another way.
    """

    overlap: Floats
    front: Floats
    empty: Floats
    disagree: Floats


class Examination(NamedTuple):
    """
    One pose refined and measured on vertices.

    Parameters
    ----------
    T_target_source : (4, 4) float64
    numbers : (2, 6) float64
        Source on target and the reverse: vertices tried, matched, sum of absolute distances,
        in front, empty, normals disagreeing.
    hessian : (6, 6) float64
        Of the point-to-plane problem by turn and shift about the target's centre.
    """

    T_target_source: Floats
    numbers: Floats
    hessian: Floats


def score(
    source: Evidence,
    target: Evidence,
    poses: Floats,
    *,
    samples: int,
    tau: float,
    front: float,
    facing: float = 0.5,
    threads: int = 0,
) -> Scores:
    """
    Score poses (H, 4, 4) `T_target_source` on at most `samples` samples of each side.

    Parameters
    ----------
    source, target : Evidence
    poses : (H, 4, 4) float64
    samples : int
    tau : float
        Distance at which a sample counts no more.
    front : float
        Depth by which a sample must lie in front of what was seen to contradict it.
    facing : float
        Cosine to the ray above which a surface would have been seen.
    threads : int
        0 takes all cores; no influence on the result.
    """
    table = _kernels._score(
        source.kernel, target.kernel, about_centres(poses, source.centre, target.centre),
        samples, tau, front, facing, threads)
    return Scores(*(table[:, :, k] for k in range(4)))


def refine(
    source: Evidence,
    target: Evidence,
    poses: Floats,
    radii: Floats,
    *,
    samples: int,
    agree: float,
    threads: int = 0,
) -> Floats:
    """
    Refine poses (H, 4, 4) by point-to-plane rounds with the given matching radii.

    Parameters
    ----------
    source, target : Evidence
    poses : (H, 4, 4) float64
    radii : (R,) float64
        One a round, in the units of the points.
    samples : int
        Of each side.
    agree : float
        Least cosine between matched normals.
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    (H, 4, 4) float64
    """
    moved = _kernels._refine(
        source.kernel, target.kernel, about_centres(poses, source.centre, target.centre),
        samples, radii, agree, threads)
    return about_centres(moved, -source.centre, -target.centre)


def examine(
    source: Evidence,
    target: Evidence,
    poses: Floats,
    *,
    rounds: int,
    samples: int,
    radius: float,
    front: float,
    facing: float = 0.5,
    threads: int = 0,
) -> list[Examination]:
    """
    Refine each pose (H, 4, 4) on vertices for `rounds` rounds and measure what speaks for it.

    Parameters
    ----------
    source, target : Evidence
    poses : (H, 4, 4) float64
    rounds, samples : int
        `samples` vertices of each side.
    radius : float
        Vertices farther apart do not match; at most a cell.
    front, facing : float
        As in `score`.
    threads : int
        0 takes all cores; no influence on the result.
    """
    moved, numbers, hessians = _kernels._examine(
        source.kernel, target.kernel, about_centres(poses, source.centre, target.centre),
        rounds, samples, radius, front, facing, threads)
    back = about_centres(moved, -source.centre, -target.centre)
    return [Examination(*exam) for exam in zip(back, numbers, hessians, strict=True)]


def distinct(poses: Floats, *, angle_rad: float, distance: float, most: int) -> Ints:
    """
    Choose at most `most` of the poses, in their order, that differ from those chosen before.

    Parameters
    ----------
    poses : (H, 4, 4) float64
        Best first; translations about a common centre near the points.
    angle_rad, distance : float
        Poses closer than both are the same.
    most : int

    Returns
    -------
    (M,) int32
    """
    kept: Ints = _kernels._distinct(poses, float(np.cos(angle_rad)), distance, most)
    return kept


def centred(poses: Floats, source: Evidence, target: Evidence) -> Floats:
    """Express `T_target_source` about the centres of both sides."""
    return about_centres(poses, source.centre, target.centre)
