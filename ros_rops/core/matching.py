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
from ros_rops.kernels.matching import Nearest, nearest_descriptors


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


def match(
    source: Features, target: Features, config: MatchingConfig, *, threads: int = 0
) -> Matches:
    """
    Match features by the distance of their descriptors (III-B, eq. 5).

    The paper takes the nearest feature of `target` for each of `source`: `neighbours` 1,
    `both_directions` off.

    Parameters
    ----------
    source, target : Features
        Of the two views; either may hold none.
    config : MatchingConfig
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    Matches
        At most `most`: nearest neighbours go before second nearest, and so on; then by
        (distance, source, target).

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
    sides = nearest_descriptors(
        a, b, config.neighbours, both=config.both_directions, threads=threads)
    rows, columns, ranks, distance = _listed(sides)
    order = np.lexsort((columns, rows, distance, ranks))
    _, first = np.unique(rows[order] * np.int64(len(b)) + columns[order], return_index=True)
    order = order[np.sort(first)[:config.most]]
    order = order[np.lexsort((columns[order], rows[order], distance[order]))]
    return _matches(rows[order], columns[order], distance[order])


def _listed(sides: tuple[Nearest, ...]) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Rows of source and target, rank and distance of every match, both sides in one list."""
    rows, columns, ranks = [], [], []
    for k, side in enumerate(sides):
        own, rank = np.indices(side.index.shape)
        pair = (own.reshape(-1), side.index.reshape(-1))
        rows.append(pair[k])
        columns.append(pair[1 - k])
        ranks.append(rank.reshape(-1))
    distance = np.concatenate([side.distance.reshape(-1) for side in sides])
    return np.concatenate(rows), np.concatenate(columns), np.concatenate(ranks), distance


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
        `T_target_source`.
    """
    i, j = matches.source, matches.target
    return frame_transforms(
        source.positions[i], source.lrfs[i], target.positions[j], target.lrfs[j])


def frame_transforms(
    source_positions: Floats, source_lrfs: Floats, target_positions: Floats, target_lrfs: Floats
) -> Floats:
    """
    Bring each source frame on its target frame: R = Lt^T Ls, t = pt - R ps (eqs. 6-7).

    Parameters
    ----------
    source_positions, target_positions : (M, 3) float64
    source_lrfs, target_lrfs : (M, 3, 3) float64
        Rows are the axes.

    Returns
    -------
    (M, 4, 4) float64
    """
    rotations = np.swapaxes(target_lrfs, 1, 2) @ source_lrfs
    moved = (rotations @ source_positions[:, :, None])[:, :, 0]
    return rigid(rotations, target_positions - moved)


def _matches(source: NDArray, target: NDArray, distance: NDArray) -> Matches:
    return Matches(
        frozen(source, np.int32), frozen(target, np.int32), frozen(distance, np.float32))
