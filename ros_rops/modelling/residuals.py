# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What the other views say of every point of a view: that it is there, that it is not, or nothing.

Another view knows a place where its line of sight through it meets its own surface (Curless and
Levoy 1996, 3: signed distance along the line of sight) or is known to pass by. Its distance there,
times the cosine between ray and surface, is its vote: how far the point lies in front (positive)
or behind. Of all votes the weighted median counts, and views found wrong (`misfits`) have
none on the others' points, so that a wrong view spoils its own map only.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.types import Bytes, Floats, frozen
from ros_rops.kernels.sight import Look
from ros_rops.modelling.posed import PosedView

Floats32 = NDArray[np.float32]

ALONE, CONFIRMED, CONTRADICTED = 0, 1, 2

POINTS = 12_000
"""Most points of a view that are judged; taken evenly."""
UNKNOWN_POINTS = 2_500
"""The same where a sensor is unknown: nearest surfaces in space take longer to find than rays."""
OBJECT_POINTS = 300_000
"""The same of an object."""
REACH_MR = 5.0
"""Surfaces farther apart do not speak of the same place; those that are seen through count so."""
FACING = 0.2
"""A view cannot have seen what looks away from it, nor trust what it sees this flat (cosine)."""
SIGMAS = 3.0
"""Votes farther out than so many standard deviations contradict."""
ROUGH = 4.0
"""Registered surfaces differ by no more than so many times their own roughness."""
FINEST_MR = 0.02
"""Scale below which distances are a matter of triangles that cut corners."""
_MEDIAN = 0.6745


@dataclass(frozen=True, slots=True)
class ViewResiduals:
    """
    The residual map of a view.

    Parameters
    ----------
    name : str
    number : int
    points : (N, 3) float64
        In the object's frame; every point of the view, or evenly fewer.
    residual : (N,) float32
        Signed distance to what the other views saw there, positive in front (outside), in the
        points' units, at most the reach either way; NaN where none saw the place.
    state : (N,) uint8
        0 alone: no other view knows the place. 1 confirmed. 2 contradicted: most of the others
        saw their surface elsewhere, or through the point.
    """

    name: str
    number: int
    points: Floats
    residual: Floats32
    state: Bytes


@dataclass(frozen=True, slots=True)
class Votes:
    """
    What the V views say of the points of one.

    Parameters
    ----------
    points : (N, 3) float64
        In the object's frame.
    distance : (V, N) float32
        Positive in front of that view's surface, kept within the reach; NaN for no vote.
    weight : (V, N) float32
    """

    points: Floats
    distance: Floats32
    weight: Floats32


def thinned(view: PosedView, most: int) -> NDArray[np.intp]:
    """Return the points of a view that have a face, evenly fewer if more than `most`."""
    faced = np.flatnonzero(view.mesh.normals.any(axis=1))
    if len(faced) <= most:
        return faced
    return faced[(np.arange(most) * len(faced)) // most]


def collect_votes(
    views: Sequence[PosedView], resolution: float, *, threads: int = 0
) -> tuple[Votes, ...]:
    """
    Ask every view about the points of every other.

    Parameters
    ----------
    views : sequence of PosedView
    resolution : float
    threads : int
        0 takes all cores; no influence on the result.

    Returns
    -------
    tuple of Votes
        One for each view, its own row all NaN.
    """
    reach = REACH_MR * resolution
    sights = [one.sight() for one in views]
    known = all(one.view.sensor.kind != 'unknown' for one in views)
    most = min(POINTS if known else UNKNOWN_POINTS, OBJECT_POINTS // max(len(views), 1))
    result = []
    for i, one in enumerate(views):
        chosen = thinned(one, most)
        points, normals = one.points[chosen], one.normals[chosen]
        distance = np.full((len(views), len(points)), np.nan, np.float32)
        weight = np.zeros_like(distance)
        for j, sight in enumerate(sights):
            if j == i:
                continue
            look = sight.look(points, reach=reach, threads=threads)
            distance[j] = _vote(look, _facing(points, normals, views[j]), reach)
            weight[j] = np.maximum(look.weight, np.float32(1e-3))
        result.append(Votes(points, distance, weight))
    return tuple(result)


def _vote(look: Look, facing: Floats, reach: float) -> Floats32:
    """Keep what the view can have seen, or saw through, kept within the reach."""
    with np.errstate(invalid='ignore'):
        across = look.distance * look.cosine
        seen = (np.abs(across) <= reach) & (facing > FACING)
        through = (across > reach) | np.isposinf(look.distance)
    return np.where(
        through, np.float32(reach), np.where(seen, across, np.float32(np.nan)))


def _facing(points: Floats, normals: Floats, view: PosedView) -> Floats:
    """Return the cosines between normals and the way to a view's sensor."""
    turn = view.T_object_view[:3, :3]
    local = (points - view.T_object_view[:3, 3]) @ turn
    towards = view.view.sensor.to_sensor(local) @ turn.T
    cosines: Floats = np.einsum('ij,ij->i', normals, towards)
    return cosines


def scale_of(votes: Sequence[Votes], roughness: float, resolution: float) -> float:
    """
    Return the standard deviation of right views' distances, estimated from the data.

    The normalised median of all votes; where wrong views are so many that they widen it, no more
    than `ROUGH` times what the views' own roughness (standard deviation across their surface)
    explains.
    """
    sizes = [np.abs(one.distance[np.isfinite(one.distance)]) for one in votes]
    together = np.concatenate([np.empty(0, np.float32), *sizes])
    finest = FINEST_MR * resolution
    most = max(ROUGH * np.sqrt(2.0) * roughness, finest)
    if not len(together):
        return float(most)
    return float(np.clip(np.median(together) / _MEDIAN, finest, most))


def residuals_of(
    views: Sequence[PosedView], votes: Sequence[Votes], scale: float,
    unheard: Sequence[Collection[int]],
) -> tuple[ViewResiduals, ...]:
    """
    Return each view's map: the weighted median of the votes, and whether it confirms.

    Parameters
    ----------
    views : sequence of V PosedView
    votes : sequence of V Votes
    scale : float
        As `scale_of` returns it.
    unheard : sequence of V collections of int
        The views that have no vote on the points of each: those that are wrong themselves.
    """
    result = []
    for view, one, deaf in zip(views, votes, unheard, strict=True):
        residual = weighted_median(silenced(one.distance, deaf), one.weight)
        with np.errstate(invalid='ignore'):
            state = np.where(np.abs(residual) <= SIGMAS * scale, CONFIRMED, CONTRADICTED)
        state[np.isnan(residual)] = ALONE
        result.append(ViewResiduals(
            view.name, view.number, frozen(one.points, np.float64),
            frozen(residual, np.float32), frozen(state, np.uint8)))
    return tuple(result)


def silenced(distance: Floats32, unheard: Collection[int]) -> Floats32:
    """Return the votes (V, N) without those of some views."""
    if not unheard:
        return distance
    heard = distance.copy()
    heard[list(unheard)] = np.nan
    return heard


def weighted_median(values: Floats32, weights: Floats32) -> Floats32:
    """
    Return the weighted lower median of each column, by size of the value's sign and amount.

    Parameters
    ----------
    values, weights : (V, N) float32
        NaN has no weight.

    Returns
    -------
    (N,) float32
        NaN for a column of NaN.
    """
    if not values.size:
        return np.full(values.shape[1], np.nan, np.float32)
    order = np.argsort(values, axis=0, kind='stable')  # NaN last
    sorted_values = np.take_along_axis(values, order, axis=0)
    heavy = np.where(np.isnan(values), np.float32(0.0), weights)
    below = np.cumsum(np.take_along_axis(heavy, order, axis=0), axis=0)
    middle = (below >= 0.5 * below[-1]).argmax(axis=0)
    chosen: Floats32 = np.take_along_axis(sorted_values, middle[None], axis=0)[0]
    return chosen
