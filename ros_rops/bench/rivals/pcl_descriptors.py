# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Spin image, SHOT and USC of the Point Cloud Library as descriptors."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.rivals.descriptor import Descriptor
from ros_rops.bench.rivals.pcl import pcl_features, pcl_missing
from ros_rops.core.types import Floats, Ints, RangeMesh

Rows = NDArray[np.float32]


def spin_image(radius_mr: float) -> Descriptor:
    """
    Make spin images (Johnson and Hebert 1999) about the vertex normals.

    15 bins along the radius and 15 on either side of the tangent plane, no limit to the angle of
    support. Spin images are compared by correlation: rows of mean 0 and length 1 have the
    Euclidean distance sqrt(2 - 2 correlation).
    """
    return _descriptor('spin image', 'Johnson and Hebert 1999', 'spin', radius_mr, standardised)


def shot(radius_mr: float) -> Descriptor:
    """Make SHOT (Tombari et al. 2010, ECCV) in the frames of the engine; of length 1."""
    return _descriptor('SHOT', 'Tombari et al. 2010a', 'shot', radius_mr, of_unit_length)


def usc(radius_mr: float) -> Descriptor:
    """
    Make unique shape contexts (Tombari et al. 2010, 3DOR) in the frames of the engine.

    PCL has 14 x 14 x 10 bins where the article has 12 x 11 x 15 (1960 and 1980 entries); least
    radius 0.1 and density radius 0.2 of the support; of length 1.
    """
    return _descriptor('USC', 'Tombari et al. 2010b', 'usc', radius_mr, of_unit_length)


def standardised(rows: Rows) -> Rows:
    """Return rows (K, D) of mean 0 and length 1, zero where all values of a row are equal."""
    return of_unit_length(rows - rows.mean(axis=1, keepdims=True))


def of_unit_length(rows: Rows) -> Rows:
    """Return rows (K, D) of length 1, zero where they were."""
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    unit: Rows = rows / np.where(length > 0, length, 1)
    return unit


def _descriptor(
    name: str, article: str, feature: str, radius_mr: float, finish: Callable[[Rows], Rows]
) -> Descriptor:
    describe = partial(_describe, feature, radius_mr, finish)
    return Descriptor(name, f'{article}; PCL', describe, pcl_missing)


def _describe(
    feature: str, radius_mr: float, finish: Callable[[Rows], Rows],
    mesh: RangeMesh, indices: Ints, lrfs: Floats, unit: float, threads: int,
) -> Rows:
    found = pcl_features(
        feature, mesh, indices, lrfs, radius_mr * unit, unit, threads=threads)
    return finish(found.descriptors)
