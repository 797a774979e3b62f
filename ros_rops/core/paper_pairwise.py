# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Pairwise registration as the paper does it (Guo et al. 2014, III-B to III-D, IV-A)."""

import numpy as np
from ros_rops.core.ccv import best_by_count, CcvGroups, count_inliers
from ros_rops.core.config import CcvConfig, Config
from ros_rops.core.hypotheses import consistent, matched
from ros_rops.core.icp import IcpResult, paper_icp, point_to_plane_icp
from ros_rops.core.pair_result import Lap, PairResult
from ros_rops.core.se3 import move
from ros_rops.core.simplify import simplify
from ros_rops.core.surface import Surface
from ros_rops.core.types import Floats, Ints, Status
from ros_rops.kernels.evidence import Vertices
from scipy.spatial import cKDTree


def register_paper(
    source: Surface,
    target: Surface,
    config: Config,
    *,
    threads: int = 0,
    lap: Lap = lambda stage: None,
) -> PairResult:
    """
    Register by the best group of consistent correspondences, refined by ICP.

    Match features; fit a transform to every match's group (CCV); take the one that brings the
    most points of the simplified surfaces together; refine it; accept it if more than
    `verdict.overlap_least` of the source's vertices lie on the target (IV-A).

    Parameters
    ----------
    source, target : Surface
    config : Config
        Groups `matching`, `ccv`, `icp`; `verdict.overlap_least`.
    threads : int
        0 takes all cores; no influence on the result.
    lap : callable
        Called with 'match', 'ccv', 'icp' when that stage has ended.

    Returns
    -------
    PairResult
        PLACED or REFUSED: the paper knows no ambiguity.
    """
    unit = 0.5 * (source.resolution + target.resolution)
    pairs = matched(source, target, config, threads=threads)
    numbers = {
        'keypoints_source': float(len(source.features.indices)),
        'keypoints_target': float(len(target.features.indices)),
        'matches': float(len(pairs.matches))}
    lap('match')
    groups = _best_supported(consistent(source, target, pairs, config.ccv), config.ccv.verified)
    points, surface = source.evidence.vertices().points, target.evidence.vertices()
    inliers = _inliers(points, surface.points, groups.transforms, unit, config.ccv, threads)
    best = best_by_count(inliers, groups.support)
    numbers |= {'ccv_groups': float(len(inliers)), 'inliers': float(inliers.max(initial=0))}
    lap('ccv')
    T, reason = None, 'no group of correspondences brings the surfaces together'
    if best is not None:
        fine, overlap = _refined(
            points, surface, groups.transforms[best], unit, config, threads)
        numbers |= {'residual_mr': fine.residual_mr, 'overlap': overlap}
        T, reason = _word(fine, overlap, config.verdict.overlap_least)
        lap('icp')
    status = Status.REFUSED if T is None else Status.PLACED
    return PairResult(source.name, target.name, status, T, reason, numbers)


def _best_supported(groups: CcvGroups, most: int) -> CcvGroups:
    """Keep at most `most` groups, those with the most members, in the order of the matches."""
    order = np.sort(np.argsort(-groups.support, kind='stable')[:most])
    return CcvGroups(groups.transforms[order], groups.support[order])


def _inliers(
    source: Floats, target: Floats, transforms: Floats, unit: float, config: CcvConfig,
    threads: int,
) -> Ints:
    """Count the points of the simplified source on the simplified target (III-C)."""
    cell = config.simplify_mr * unit
    return count_inliers(
        simplify(source, cell), simplify(target, cell), transforms, config.inlier_mr * unit,
        threads=threads)


def _refined(
    points: Floats, surface: Vertices, start: Floats, unit: float, config: Config, threads: int
) -> tuple[IcpResult, float]:
    """Refine by ICP (III-D); return the share of all `points` on the surface, too (IV-A)."""
    tree = cKDTree(surface.points)
    if config.icp.method == 'paper':
        fine = paper_icp(points, surface.points, start, unit, config.icp, tree=tree)
    else:
        fine = point_to_plane_icp(
            points, surface.points, surface.normals, start, unit, config.icp, tree=tree)
    gap, _ = tree.query(move(fine.T_target_source, points), workers=threads or -1)
    return fine, float(np.mean(gap < config.ccv.inlier_mr * unit))


def _word(fine: IcpResult, overlap: float, least: float) -> tuple[Floats | None, str]:
    """Return the pose where it is accepted, and why or why not."""
    if overlap > least:
        return fine.T_target_source, (
            f'{overlap:.0%} of the vertices overlap, residual {fine.residual_mr:.2f} mr')
    return None, f'{overlap:.0%} of the vertices overlap: not more than {least:.0%}'
