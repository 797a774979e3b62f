# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""THRIFT (Flint et al. 2007) as a descriptor; no library has it."""

from functools import partial

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.rivals.descriptor import Descriptor
from ros_rops.bench.rivals.supports import (
    histograms, supports_of, surface_of, window_normals)
from ros_rops.core.types import Floats, Ints, RangeMesh

BINS = 32
# Of the window of the keypoint's normal, as a part of the support.
LARGE = 0.5


def thrift(radius_mr: float) -> Descriptor:
    """
    Make histograms of the angles between the keypoint's normal and those of its neighbours.

    The keypoint's normal is that of a large window, the neighbours' that of a small one (the
    vertex normals); neighbours weigh less with their distance, in a linear way.
    """
    return Descriptor('THRIFT', 'Flint et al. 2007; ours', partial(_describe, radius_mr))


def _describe(
    radius_mr: float, mesh: RangeMesh, indices: Ints, lrfs: Floats, unit: float, threads: int
) -> NDArray[np.float32]:
    points, normals, centres = surface_of(mesh, indices)
    radius = radius_mr * unit
    own = window_normals(points, normals, centres, LARGE * radius, threads=threads)
    near = supports_of(points, points[centres], radius, threads=threads)
    cosine = np.einsum('pd,pd->p', normals[near.member], own[near.owner])
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / np.pi
    return histograms(
        near.owner, angle[:, None], 1.0 - near.distance / radius, len(centres), (BINS,))
