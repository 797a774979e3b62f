# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Poses that matched features propose, alone or in consistent groups (III-B and III-C)."""

from dataclasses import dataclass

from ros_rops.core.ccv import ccv_transforms, CcvGroups
from ros_rops.core.config import CcvConfig, Config
from ros_rops.core.matching import match, match_transforms, Matches
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
