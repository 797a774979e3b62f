# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Feature matching and the rigid transform of every match (Guo et al. 2014, III-B)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.config import MatchingConfig
from ros_rops.core.errors import ShapeError
from ros_rops.core.se3 import rigid
from ros_rops.core.types import Features, Floats, frozen, Ints

# Entries of the table of distances held at once: stays in the cache of a core.
_BLOCK = 1 << 19
# Pairs whose descriptors are held side by side at once.
_PAIRS = 1 << 14
# Short lists this many times too long: a plane, say, whose descriptors are all the same.
_CROWD = 8


@dataclass(frozen=True, slots=True)
class Matches:
    """
    Matched features, the nearest first.

    Parameters
    ----------
    source, target : (M,) int32
        Rows of the two views' features; no pair occurs twice.
    distance : (M,) float32
        Euclidean distance of the descriptors.
    """

    source: Ints
    target: Ints
    distance: NDArray[np.float32]

    def __len__(self) -> int:
        """Return the number of matches."""
        return len(self.source)


def match(source: Features, target: Features, config: MatchingConfig) -> Matches:
    """
    Match features by the distance of their descriptors (III-B, eq. 5).

    The paper takes the nearest feature of `target` for each of `source`: `neighbours` 1,
    `both_directions` off.

    Parameters
    ----------
    source, target : Features
        Of the two views; either may hold none.
    config : MatchingConfig

    Returns
    -------
    Matches
        By (distance, source, target). Equal distances go to the lower index; neither the number
        of threads nor the BLAS library changes the result.

    Raises
    ------
    ShapeError
        If the descriptors of the two views differ in length.
    """
    a, b = source.descriptors, target.descriptors
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1]:
        raise ShapeError(f'descriptors: {a.shape} of source do not fit {b.shape} of target')
    if not len(a) or not len(b):
        return _matches(*(np.zeros(0, np.intp),) * 2, np.zeros(0))
    rows, columns, squared = _nearest(a, b, config.neighbours)
    if config.both_directions:
        back, ahead, other = _nearest(b, a, config.neighbours)
        rows, columns = np.concatenate([rows, ahead]), np.concatenate([columns, back])
        _, first = np.unique(rows * len(b) + columns, return_index=True)
        squared = np.concatenate([squared, other])[first]
        rows, columns = rows[first], columns[first]
    order = np.lexsort((columns, rows, squared))
    return _matches(rows[order], columns[order], np.sqrt(squared[order]))


def match_transforms(source: Features, target: Features, matches: Matches) -> Floats:
    """
    Turn every match into a rigid transform by its two frames (eqs. 6-7).

    Parameters
    ----------
    source, target : Features
    matches : Matches

    Returns
    -------
    (M, 4, 4) float64
        `T_target_source`: R = Lt^T Ls with the axes of the frames as rows, t = pt - R ps.
    """
    frames, others = source.lrfs[matches.source], target.lrfs[matches.target]
    rotations = np.einsum('mki,mkj->mij', others, frames)
    moved = np.einsum('mij,mj->mi', rotations, source.positions[matches.source])
    return rigid(rotations, target.positions[matches.target] - moved)


def _matches(source: NDArray, target: NDArray, distance: NDArray) -> Matches:
    return Matches(
        frozen(source, np.int32), frozen(target, np.int32), frozen(distance, np.float32))


def _nearest(a: NDArray, b: NDArray, k: int) -> tuple[NDArray, NDArray, Floats]:
    """
    Find the `k` nearest rows of `b` for each row of `a`: rows, columns, squared distances.

    A float32 product gives a short list, wide enough for its rounding; float64 decides.
    """
    k = min(k, len(b))
    # Distances lose digits to the norms, so those should be small.
    centre = b.mean(axis=0, dtype=np.float64)
    near_a, near_b = (a - centre).astype(np.float32), (b - centre).astype(np.float32)
    norm_a = np.einsum('ij,ij->i', near_a, near_a)
    norm_b = np.einsum('ij,ij->i', near_b, near_b)
    # The worst that rounding can do to a squared distance, on both sides of the limit.
    slack = 4 * (a.shape[1] + 4) * np.finfo(np.float32).eps * (norm_a + norm_b.max())
    near_b *= -2
    found = []
    size = max(_BLOCK // len(b), 1)
    for start in range(0, len(a), size):
        stop = start + size
        # The norm of a is the same for all of a row: left out.
        table = near_a[start:stop] @ near_b.T
        table += norm_b
        limit = np.partition(table, k - 1, axis=1)[:, k - 1] + slack[start:stop]
        rows, columns = np.divmod(np.flatnonzero(table <= limit[:, None]), len(b))
        found.append(_best(a, b, rows + start, columns, k))
    rows, columns, squared = (np.concatenate(part) for part in zip(*found, strict=True))
    return rows, columns, squared


def _best(
    a: NDArray, b: NDArray, rows: NDArray, columns: NDArray, k: int
) -> tuple[NDArray, NDArray, Floats]:
    """Keep the `k` nearest of each row, judged in float64; every row has at least k."""
    starts = np.flatnonzero(np.diff(rows, prepend=-1))
    squared = (_squared if len(rows) < _CROWD * k * len(starts) else _squared_of_equals)(
        a, b, rows, columns)
    # Stable: among equal distances the columns go on rising.
    order = np.lexsort((squared, rows))
    keep = order[(starts[:, None] + np.arange(k)).reshape(-1)]
    return rows[keep], columns[keep], squared[keep]


def _squared(a: NDArray, b: NDArray, rows: NDArray, columns: NDArray) -> Floats:
    """Return the squared distances of pairs of rows of `a` and `b`."""
    result = np.empty(len(rows))
    for start in range(0, len(rows), _PAIRS):
        part = slice(start, start + _PAIRS)
        difference = np.subtract(a[rows[part]], b[columns[part]], dtype=np.float64)
        result[part] = np.einsum('ij,ij->i', difference, difference)
    return result


def _squared_of_equals(a: NDArray, b: NDArray, rows: NDArray, columns: NDArray) -> Floats:
    """Do the same once for all pairs of equal descriptors."""
    different_a, row = np.unique(a[rows[0]:rows[-1] + 1], axis=0, return_inverse=True)
    different_b, column = np.unique(b, axis=0, return_inverse=True)
    code = row.reshape(-1)[rows - rows[0]] * len(different_b) + column.reshape(-1)[columns]
    pairs, place = np.unique(code, return_inverse=True)
    first, second = np.divmod(pairs, len(different_b))
    return _squared(different_a, different_b, first, second)[place.reshape(-1)]
