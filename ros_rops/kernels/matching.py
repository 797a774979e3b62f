# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Typed face of the matching kernel."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_rops.core.errors import ShapeError
from ros_rops.core.types import Ints
from ros_rops.kernels import _kernels


class Nearest(NamedTuple):
    """
    Nearest descriptors of the other side for each descriptor of one.

    Parameters
    ----------
    index : (K, k) int32
        The nearest first; ties go to the lower index.
    distance : (K, k) float32
        Euclidean, to 1/30000 of the longest descriptor.
    """

    index: Ints  # type: ignore[assignment]  # a tuple's own method, not used here
    distance: NDArray[np.float32]


def nearest_descriptors(
    a: NDArray[np.float32], b: NDArray[np.float32], neighbours: int, *, both: bool,
    threads: int = 0,
) -> tuple[Nearest, ...]:
    """
    Find for each of `a` (Ka, D) the nearest of `b` (Kb, D), and if `both` the reverse.

    Parameters
    ----------
    a, b : (K, D) float32
        Finite; at least one row each.
    neighbours : int
        Fewer if the other side has fewer.
    both : bool
    threads : int
        0 takes all cores; no influence on the result.

    Raises
    ------
    ShapeError
        If the arrays do not fit together, or a side is empty.
    """
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1]:
        raise ShapeError(f'descriptors: {a.shape} do not fit {b.shape}')
    if not len(a) or not len(b) or neighbours < 1:
        raise ShapeError(f'descriptors: {neighbours} of {len(b)} asked for {len(a)}')
    return tuple(
        Nearest(*side) for side in _kernels._nearest_descriptors(a, b, neighbours, both, threads))
