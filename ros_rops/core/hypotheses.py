# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Poses that matched features propose: alone, in consistent groups, half-turned (III-B and III-C).

The x axis of a frame leans to where its support is heavier. Views that overlap little see the
surroundings of a common keypoint on opposite sides, and the two x axes point away from each
other: half of them by 140 degrees and more (docs/experiments.md, 'RoPS alone'). Such features
match all the same, since what is bent alike on both sides looks alike when turned by 180 degrees
about its normal; only the pose is turned by so much.
"""

from dataclasses import dataclass

import numpy as np
from ros_rops.core.ccv import ccv_transforms, CcvGroups
from ros_rops.core.config import CcvConfig, Config
from ros_rops.core.matching import match, match_transforms, Matches
from ros_rops.core.se3 import rigid
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats


@dataclass(frozen=True, slots=True)
class Matched:
    """
    The matches of two surfaces and the pose that each alone proposes (eqs. 5-7).

    Parameters
    ----------
    matches : Matches
        M of them.
    transforms : (M, 4, 4) float64
        `T_target_source`.
    """

    matches: Matches
    transforms: Floats


def matched(
    source: Surface, target: Surface, config: Config, *, threads: int = 0
) -> Matched:
    """
    Match the features of two surfaces (III-B).

    Parameters
    ----------
    source, target : Surface
    config : Config
        Group `matching`.
    threads : int
        0 takes all cores; no influence on the result.
    """
    matches = match(source.features, target.features, config.matching, threads=threads)
    return Matched(matches, match_transforms(source.features, target.features, matches))


def half_turned(target: Surface, pairs: Matched) -> Floats:
    """
    Turn the pose of every match by 180 degrees about the z axis of the target's frame.

    Parameters
    ----------
    target : Surface
    pairs : Matched

    Returns
    -------
    (M, 4, 4) float64
        `T_target_source`, in the order of the matches; the keypoints stay where they met.
    """
    rows = pairs.matches.target
    axes, points = target.features.lrfs[rows, 2], target.features.positions[rows]
    turns = 2.0 * axes[:, :, None] * axes[:, None, :] - np.eye(3)
    shifts = points - np.einsum('mij,mj->mi', turns, points)
    turned: Floats = rigid(turns, shifts) @ pairs.transforms
    return turned


def consistent(
    source: Surface, target: Surface, pairs: Matched, config: CcvConfig
) -> CcvGroups:
    """
    Replace the pose of every match by that of its group of consistent matches (III-C).

    Parameters
    ----------
    source, target : Surface
    pairs : Matched
        Of the two.
    config : CcvConfig

    Returns
    -------
    CcvGroups
        In the order of the matches.
    """
    return ccv_transforms(
        source.features.positions[pairs.matches.source],
        target.features.positions[pairs.matches.target],
        pairs.transforms, config, 0.5 * (source.resolution + target.resolution),
        source.evidence.centre)
