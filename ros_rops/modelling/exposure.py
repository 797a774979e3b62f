# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How much brighter or darker than the others each view shows the same places."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bools, Floats
from ros_rops.modelling.posed import PosedView
from scipy.sparse import coo_matrix

Indices = NDArray[np.signedinteger]

CELL_MR = 2.0
"""Points of two views so near to each other, facing the same way, show the same place."""
DARKEST, BRIGHTEST = 10, 245
"""Beyond these a camera is blind or dazzled, and its colours are in no proportion to the light."""
OUTLIER = 0.1
"""Differences of logarithms count as their square up to this, then linearly (Huber)."""
ROUNDS = 5
PRIOR = 1.0
"""A view that shares no place with others stays as it is: as if so many said that it may."""


def exposures(views: Sequence[PosedView], resolution: float) -> Floats:
    """
    Return by what the colours of each view must be multiplied to agree with the others.

    Least squares of the logarithms, robustly: the colour of a place in a view is the place's own
    colour times the view's gain (Brown and Lowe 2007, 6). Each channel has its own gain, since
    cameras balance white, too.

    Parameters
    ----------
    views : sequence of PosedView
    resolution : float
        dres, in the views' units.

    Returns
    -------
    (V, 3) float64
        Above 0; the geometric mean over the views with colours is 1; 1 for those without.
    """
    coloured = [k for k, view in enumerate(views) if view.view.colors is not None]
    gains = np.ones((len(views), 3))
    if len(coloured) < 2:
        return gains
    cells, owners, logs = _shown([views[k] for k in coloured], CELL_MR * resolution)
    for channel in range(3):
        fair = np.isfinite(logs[:, channel])
        found = _solved(cells[fair], owners[fair], logs[fair, channel], len(coloured))
        gains[coloured, channel] = np.exp(-found)
    return gains


def _shown(views: Sequence[PosedView], side: float) -> tuple[Indices, Indices, Floats]:
    """
    Return cell, view and mean logarithm of the colour of each cell in each view that shows it.

    NaN where a point of them is blind or dazzled.
    """
    cells, logs = zip(*(_shown_by(view, side) for view in views), strict=True)
    owners = np.repeat(np.arange(len(views)), [len(own) for own in cells])
    numbers = np.unique(np.concatenate(cells), return_inverse=True)[1]
    return numbers, owners, np.concatenate(logs)


def _shown_by(view: PosedView, side: float) -> tuple[Indices, Floats]:
    """Return the cells that a view shows, and the mean logarithm of their colours."""
    on = view.weights > 0
    cells, place = np.unique(
        _numbers(view.points[on], view.normals[on], side), return_inverse=True)
    colors = np.asarray(view.view.colors)[on]
    fair = (colors >= DARKEST) & (colors <= BRIGHTEST)
    logs = np.where(fair, np.log(np.maximum(colors, 1)), np.nan)
    count = np.bincount(place, minlength=len(cells))
    return cells, np.stack([
        np.bincount(place, logs[:, a], len(cells)) / count for a in range(3)], axis=1)


def _numbers(points: Floats, normals: Floats, side: float) -> Indices:
    """Return the number of each point's cell: 20 bits an axis and the way that it faces."""
    most = 2**19
    where = np.clip(np.floor(points / side), -most, most - 1).astype(np.int64) + most
    axis = np.argmax(np.abs(normals), axis=1)
    way = 2 * axis + (np.take_along_axis(normals, axis[:, None], 1)[:, 0] < 0)
    numbers: Indices = ((where[:, 0] << 43) | (where[:, 1] << 23) | (where[:, 2] << 3)) + way
    return numbers


def _solved(cells: Indices, owners: Indices, logs: Floats, count: int) -> Floats:
    """Return each view's logarithmic gain (V,) with the mean 0, the cells' colours eliminated."""
    gains, shared = np.zeros(count), _shared(cells)
    cells, owners, logs = cells[shared], owners[shared], logs[shared]
    cells = np.unique(cells, return_inverse=True)[1]
    trust = np.ones(len(cells))
    for _ in range(ROUNDS if len(cells) else 0):
        gains = _step(cells, owners, logs, trust, count)
        rest = logs - gains[owners]
        away = np.abs(rest - _mean(cells, rest, trust))
        trust = OUTLIER / np.maximum(away, OUTLIER)
    centred: Floats = gains - gains.mean()
    return centred


def _shared(cells: Indices) -> Bools:
    shared: Bools = np.bincount(cells)[cells] > 1
    return shared


def _mean(cells: Indices, values: Floats, trust: Floats) -> Floats:
    """Return for each row the weighted mean of its cell, (N,)."""
    mean: Floats = (np.bincount(cells, trust * values) / np.bincount(cells, trust))[cells]
    return mean


def _step(cells: Indices, owners: Indices, logs: Floats, trust: Floats, count: int) -> Floats:
    """Solve the normal equations of the gains for one set of weights."""
    total = np.bincount(cells, trust)
    seen = coo_matrix((trust, (cells, owners)), (len(total), count)).tocsr()
    left = np.diag(np.bincount(owners, trust, count) + PRIOR) - (
        seen.T @ seen.multiply(1 / total[:, None]).tocsr()).toarray()
    right = np.bincount(owners, trust * (logs - _mean(cells, logs, trust)), count)
    gains: Floats = np.linalg.solve(left, right)
    return gains
