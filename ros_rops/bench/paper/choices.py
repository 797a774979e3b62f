# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Every stage as Guo et al. 2014 chose it: what config/paper.yaml says, for use without it."""

from collections.abc import Mapping

from ros_rops.bench.settings import derive
from ros_rops.core.config import Config

# Reasons and sections stand in config/paper.yaml.
PAPER_CHOICES: Mapping[str, object] = {
    'keypoints.method': 'paper',
    'keypoints.spacing_mr': 3.0,
    'keypoints.boundary_mr': 1.0,
    'keypoints.eigen_ratio': 1.02,
    'lrf.method': 'rops',
    'lrf.triangles': 'author',
    'rops.radius_mr': 15.0,
    'rops.rotations': 3,
    'rops.bins': 5,
    'rops.convention': 'author',
    'matching.neighbours': 1,
    'matching.both_directions': False,
    'ccv.metric': 'euler',
    'ccv.angle_rad': 0.2,
    'ccv.distance_mr': 10.0,
    'ccv.inlier_mr': 2.0,
    'ccv.verified': 1000000,
    'icp.method': 'paper',
    'icp.reject_mr': 2.0,
    'evidence.grow_mr': 1.0,
    'pairwise.method': 'paper',
    'pairwise.random_starts': 0,
    'verdict.overlap_least': 0.5,
    'fine.method': 'williams',
}


def paper_config(config: Config) -> Config:
    """Return `config` with the paper's choices."""
    return derive(config, PAPER_CHOICES)
