# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether a pose stays where it is when it is refined once more.

Surfaces that nearly slide on each other creep: a refinement of so many rounds can end 12 degrees
short of the right pose, at a residual that is believed. From there, or beside it, another one
goes on.
"""

import math

import numpy as np
from ros_rops.core.config import Config
from ros_rops.core.se3 import rigid
from ros_rops.core.search import Candidates, refined_again
from ros_rops.core.station import Known
from ros_rops.core.surface import Surface
from ros_rops.core.types import Bools, Floats, Status
from ros_rops.core.verdict import better, FINALISTS, judge, Verdict
from ros_rops.kernels.verification import centred
from scipy.spatial.transform import Rotation

# A pose that moves by less than both has settled.
SETTLED_ANGLE_RAD = math.radians(1.0)
SETTLED_DISTANCE_MR = 1.0
MOST = 4
# Within the reach of a refinement, and beyond what surfaces that nearly slide creep.
TURN_RAD = math.radians(10.0)


def settled(
    source: Surface,
    target: Surface,
    verdict: Verdict,
    candidates: Candidates,
    config: Config,
    *,
    threads: int = 0,
    known: Known | None = None,
) -> Verdict:
    """
    Refine what was placed, or refused, until it stays; judge it anew where it moved.

    Parameters
    ----------
    source, target : Surface
    verdict : Verdict
        On the best of `candidates`.
    candidates : Candidates
    config : Config
    threads : int
        0 takes all cores; no influence on the result.
    known : Known, optional

    Returns
    -------
    Verdict
        The given one, or that on poses which moved and explain the views better.
    """
    for _ in range(MOST):
        if verdict.status is Status.AMBIGUOUS or not len(candidates.poses):
            break
        before = starts = candidates.poses[:FINALISTS]
        if verdict.T_target_source is not None:
            before = verdict.T_target_source[None]
            starts = np.concatenate([_around(verdict.T_target_source, source), starts])
        candidates = refined_again(source, target, starts, config.pairwise, threads=threads)
        # What is placed stays so while nothing scores better than it; of the rest any may go on.
        after = candidates.poses[:len(before)]
        if not _moved(source, target, before, after).any():
            break
        fresh = judge(source, target, candidates, config.verdict, known, threads=threads)
        if fresh.status is not Status.PLACED or not better(fresh, verdict, config.verdict):
            break
        verdict = fresh
    return verdict


def _around(T_target_source: Floats, source: Surface) -> Floats:
    """Return a pose and those turned a little about the middle of the source, (7, 4, 4)."""
    turns = np.concatenate([np.zeros((1, 3)), TURN_RAD * np.eye(3), -TURN_RAD * np.eye(3)])
    rotations = Rotation.from_rotvec(turns).as_matrix()
    centre = source.evidence.centre
    return T_target_source @ rigid(rotations, centre - rotations @ centre)


def _moved(source: Surface, target: Surface, before: Floats, after: Floats) -> Bools:
    """Tell which of the poses `after` (A, 4, 4) are far from every one `before` (B, 4, 4)."""
    unit = 0.5 * (source.resolution + target.resolution)
    first, second = (
        centred(poses, source.evidence, target.evidence) for poses in (before, after))
    turned = np.einsum('aij,bij->ab', second[:, :3, :3], first[:, :3, :3])
    angle = np.arccos(np.clip(0.5 * (turned - 1.0), -1.0, 1.0))
    gap = np.linalg.norm(second[:, None, :3, 3] - first[None, :, :3, 3], axis=2)
    near = (angle < SETTLED_ANGLE_RAD) & (gap < SETTLED_DISTANCE_MR * unit)
    moved: Bools = ~near.any(axis=1)
    return moved
