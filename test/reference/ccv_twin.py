# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""CCV by its definition: every pair of transforms compared, every group fitted by itself."""

import numpy as np
from scipy.spatial.transform import Rotation


def consistent(first, second, metric, angle, distance, centre):
    """Tell whether two transforms belong together."""
    a, b = first[:3, :3], second[:3, :3]
    if metric == 'euler':
        angles = [Rotation.from_matrix(r).as_euler('xyz') for r in (a, b)]
        turned = np.linalg.norm(angles[0] - angles[1])
        gap = first[:3, 3] - second[:3, 3]
    else:
        turned = Rotation.from_matrix(a.T @ b).magnitude()
        gap = (first - second) @ [*centre, 1.0]
    return turned < angle and np.linalg.norm(gap) < distance


def fitted(source, target):
    """Return the rigid transform that takes `source` to `target`, least squares."""
    turn, _ = Rotation.align_vectors(target - target.mean(axis=0), source - source.mean(axis=0))
    transform = np.eye(4)
    transform[:3, :3] = turn.as_matrix()
    transform[:3, 3] = target.mean(axis=0) - turn.apply(source.mean(axis=0))
    return transform


def averaged(transforms, about):
    """Return the mean rotation, taking `about` where the transforms take it on average."""
    turn = Rotation.from_matrix(transforms[:, :3, :3]).mean().as_matrix()
    transform = np.eye(4)
    transform[:3, :3] = turn
    transform[:3, 3] = (transforms @ [*about, 1.0]).mean(axis=0)[:3] - turn @ about
    return transform


def groups(source, target, transforms, metric, angle, distance, centre):
    """Return the plausible transforms and the sizes of their groups."""
    result, support = [], []
    for one in transforms:
        members = np.array([
            consistent(one, other, metric, angle, distance, centre) for other in transforms])
        support.append(members.sum())
        result.append(
            fitted(source[members], target[members]) if members.sum() >= 3 else
            averaged(transforms[members], np.zeros(3) if metric == 'euler' else centre))
    return np.array(result), np.array(support)
