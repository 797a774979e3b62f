# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Inliers of poses by SciPy's tree, one pose after another."""

import numpy as np
from scipy.spatial import cKDTree


def count_near(source, target, transforms, radius):
    """Count the source points that each transform takes nearer than `radius` to the target."""
    tree = cKDTree(target)
    moved = [source @ t[:3, :3].T + t[:3, 3] for t in transforms]
    return np.array([(tree.query(points)[0] < radius).sum() for points in moved])
