# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The volume in NumPy: every voxel of a dense lattice, views looked at one after the other."""

from itertools import product

import numpy as np


def distances(points, sights, band, voxel):
    """Return weighted means in voxels (NaN where unknown) at points (N, 3)."""
    weights, sums = np.zeros(len(points)), np.zeros(len(points))
    for sight in sights:
        far, weight, cosine = (a.astype(np.float64) for a in sight.look(points, reach=band))
        free = np.isposinf(far)
        with np.errstate(invalid='ignore'):
            across = far * cosine
            sure = 0.4 * band
            left = np.clip(1 + across / sure / 2, 0, 1)
            trust = np.clip(2 + far / sure, 0.01 * left**2, 1) * (across > -2 * sure)
        trust = np.where(free, 0.5, np.where(np.isnan(across), 0, weight * trust))
        weights += trust
        sums += trust * np.where(trust > 0, np.where(free, band, np.minimum(across, band)), 0)
    with np.errstate(invalid='ignore'):
        return np.where(weights > 0, sums / weights, np.nan) / voxel


def continued(lattice, band):
    """Fill unknown voxels of a lattice (X, Y, Z) from two known in a row along the surface."""
    wide = np.pad(lattice, 2, constant_values=np.nan)
    inner = tuple(slice(2, -2) for _ in range(3))
    total, count = np.zeros(lattice.shape), np.zeros(lattice.shape)
    for step in product((-1, 0, 1), repeat=3):
        if not any(step):
            continue
        near, next_ = (
            np.roll(wide, [-k * s for s in step], (0, 1, 2))[inner] for k in (1, 2))
        slope = near - next_
        with np.errstate(invalid='ignore'):
            good = (np.abs(slope) <= 0.5 * np.linalg.norm(step)) & (np.abs(near) < 0.9 * band)
        total += np.where(good, near + slope, 0)
        count += good
    with np.errstate(invalid='ignore'):
        return np.where(np.isnan(lattice), total / count, lattice)
