# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Local surface patch (Chen and Bhanu 2007) as a descriptor; no library has it."""

from functools import partial

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.rivals.descriptor import Descriptor
from ros_rops.bench.rivals.supports import histograms, shape_indices, supports_of, surface_of
from ros_rops.core.types import Floats, Ints, RangeMesh

# Bins of the shape index and of the cosine (section 3.2).
BINS = (17, 34)
# Points of the 5 x 5 window that a quadratic surface is fitted to (section 3.1).
WINDOW = 25


def lsp(radius_mr: float) -> Descriptor:
    """
    Make histograms of shape index against the cosine to the keypoint's normal, shared bilinearly.

    The article compares histograms by the chi-square divergence: the root of every entry is
    taken, since near equality the squared Euclidean distance of roots is a quarter of it. All
    neighbours within the radius count, however their normals turn.
    """
    return Descriptor('LSP', 'Chen and Bhanu 2007; ours', partial(_describe, radius_mr))


def _describe(
    radius_mr: float, mesh: RangeMesh, indices: Ints, lrfs: Floats, unit: float, threads: int
) -> NDArray[np.float32]:
    points, normals, centres = surface_of(mesh, indices)
    shape = shape_indices(points, normals, WINDOW, threads=threads)
    near = supports_of(points, points[centres], radius_mr * unit, threads=threads)
    cosine = np.einsum('pd,pd->p', normals[near.member], normals[centres][near.owner])
    values = np.stack([shape[near.member], 0.5 * (1.0 + cosine)], axis=1)
    return np.sqrt(histograms(
        near.owner, values, np.ones(len(cosine)), len(centres), BINS))
