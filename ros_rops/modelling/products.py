# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What a model consists of.

All are frozen; lengths are in the units of the views, in the object's frame.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Bytes, Floats, Ints

Floats32 = NDArray[np.float32]
Fact = bool | int | float | str


@dataclass(frozen=True, slots=True)
class ModelCloud:
    """
    The assembled cloud of an object: each place of its surface once, unless `model.view_ids`.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float32
        Unit, outwards.
    colors : (N, 3) uint8 or None
        None if no view has colours.
    weights : (N,) float32
        Sum over the views that saw the place of their points' mean weight there.
    view_ids : (N,) int32
        The view that weighs most in the point.
    directions : (N,) uint8
        How many views saw the point.
    facts : mapping of str to scalar
        Counts: `points_measured` before merging, `points`, `points_without_surface`,
        `specks_removed`, `seen_through_removed`, `views`; lengths: `noise`
        across the surface, `radius` of what was merged.
    """

    points: Floats
    normals: Floats32
    colors: Bytes | None
    weights: Floats32
    view_ids: Ints
    directions: Bytes
    facts: Mapping[str, Fact] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SurfaceMesh:
    """
    The surface of an object.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int32
        Counter-clockwise seen from outside.
    normals : (V, 3) float32
        Unit, outwards.
    colors : (V, 3) uint8 or None
    filled : (F,) bool
        Faces where no view saw a surface.
    facts : mapping of str to scalar
        `voxel`, `method`, `closed`, `manifold`, `components`, `floating_removed`, ...
    """

    vertices: Floats
    faces: Ints
    normals: Floats32
    colors: Bytes | None
    filled: Bools
    facts: Mapping[str, Fact] = field(default_factory=dict)
