# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""How well a surface agrees with a reference mesh: accuracy and completeness (EVALUATION)."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.model_distance import Closest, Triangles
from ros_rops.core.errors import ShapeError
from ros_rops.core.se3 import move
from ros_rops.core.types import Bools, Floats, Ints, RangeView
from ros_rops.modelling.products import SurfaceMesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

ACCURACY_SHARE = 0.9
COMPLETE_DRES = 2.0
SEEN_DRES = 1.0
"""
A reference point is seen where a scan point lies so near, taken from its outer side: samples are
1 dres apart, so what was sampled has one within 0.71, and noise and poses take the rest.
"""
SAMPLES = 100_000
CLOSE_DRES = 5.0
"""Bias and normals are told of points so near only: far ones have no counterpart."""


@dataclass(frozen=True, slots=True)
class ModelScore:
    """
    A model against its reference; lengths in dres, shares 0 to 1.

    Parameters
    ----------
    accuracy : float
        90% of points spread evenly over the model's area lie so near to the reference.
    accuracy_vertices : float
        The same of the model's vertices.
    accuracy_inner : float
        The same of the points whose nearest place is not on the edge of a hole of the reference:
        where it ends it cannot judge.
    median, p99, worst : float
    bias : float
        Mean of the signed distance, positive outside of the reference, of points within 5 dres.
    completeness : float
        Share of the reference's vertices within 2 dres of the model.
    completeness_seen : float or None
        The same, of those that the scans saw.
    seen_share : float or None
        Share of the reference's vertices that the scans saw.
    normals_deg : float
        Median angle between the model's and the reference's normals.
    turned_share : float
        Share of points whose normal points to the wrong side.
    """

    accuracy: float
    accuracy_vertices: float
    accuracy_inner: float
    median: float
    p99: float
    worst: float
    bias: float
    completeness: float
    completeness_seen: float | None
    seen_share: float | None
    normals_deg: float
    turned_share: float

    def numbers(self) -> dict[str, float | None]:
        """Return everything as plain JSON values."""
        return asdict(self)


def judge_surface(
    surface: SurfaceMesh, reference: Triangles, T_world_object: Floats, dres: float,
    seen: Bools | None = None, *, samples: int = SAMPLES, seed: int = 0,
) -> ModelScore:
    """
    Measure a surface against its reference (Seitz et al. 2006, as EVALUATION has it).

    Parameters
    ----------
    surface : SurfaceMesh
    reference : Triangles
        In the world's frame, in the units of the surface.
    T_world_object : (4, 4) float64
    dres : float
    seen : (V,) bool or None
        Vertices of the reference that the scans saw (`seen_by`).
    samples : int
        Points on the model.
    seed : int
        Of these.

    Raises
    ------
    ShapeError
        If the surface has no face, `dres` is not positive, or `seen` does not fit.
    """
    if not dres > 0:
        raise ShapeError(f'dres: expected a positive length, got {dres!r}')
    if seen is not None and seen.shape != (len(reference.vertices),):
        raise ShapeError(f'seen: expected ({len(reference.vertices)},), got {seen.shape}')
    model = Triangles(move(T_world_object, surface.vertices), surface.faces)
    points, faces = model.samples(samples, seed)
    closest = reference.closest(points)
    gaps = closest.distance / dres
    of_vertices = reference.closest(model.vertices).distance / dres
    inner = gaps[~on_edge(reference, closest)]
    covered = model.closest(reference.vertices).distance <= COMPLETE_DRES * dres
    return ModelScore(
        accuracy=_quantile(gaps, ACCURACY_SHARE),
        accuracy_vertices=_quantile(of_vertices, ACCURACY_SHARE),
        accuracy_inner=_quantile(inner, ACCURACY_SHARE),
        median=_quantile(gaps, 0.5), p99=_quantile(gaps, 0.99), worst=float(gaps.max()),
        bias=_bias(points, closest, reference, dres),
        completeness=float(covered.mean()),
        completeness_seen=float(covered[seen].mean()) if seen is not None and seen.any() else None,
        seen_share=None if seen is None else float(seen.mean()),
        **_normals(model.normals[faces], closest, reference, dres))


def _quantile(values: Floats, share: float) -> float:
    return float(np.quantile(values, share)) if len(values) else float('nan')


def signed(points: Floats, closest: Closest, reference: Triangles) -> Floats:
    """Return the distances of points, positive outside of the reference, (N,)."""
    outwards = np.einsum(
        'nd,nd->n', points - closest.foot, reference.normals_at(closest))
    result: Floats = np.where(outwards < 0, -closest.distance, closest.distance)
    return result


def _bias(points: Floats, closest: Closest, reference: Triangles, dres: float) -> float:
    near = closest.distance < CLOSE_DRES * dres
    return float(signed(points, closest, reference)[near].mean() / dres) if near.any() else np.nan


def _normals(
    normals: Floats, closest: Closest, reference: Triangles, dres: float
) -> dict[str, float]:
    near = closest.distance < CLOSE_DRES * dres
    cosine = np.einsum('nd,nd->n', normals, reference.normals[closest.face])[near]
    if not len(cosine):
        return {'normals_deg': np.nan, 'turned_share': np.nan}
    return {
        'normals_deg': float(np.degrees(np.median(np.arccos(np.clip(cosine, -1, 1))))),
        'turned_share': float((cosine < 0).mean())}


def on_edge(reference: Triangles, closest: Closest) -> Bools:
    """Tell which points are nearest to the edge of a hole of the reference, (N,) bool."""
    sides = np.sort(reference.faces[:, [[1, 2], [2, 0], [0, 1]]], axis=2)  # opposite corner k
    keys = sides[..., 0] * len(reference.vertices) + sides[..., 1]
    _, back, counts = np.unique(keys, return_inverse=True, return_counts=True)
    rim = (counts == 1)[back].reshape(keys.shape)
    rims = np.zeros(len(reference.vertices), bool)
    rims[sides[rim].reshape(-1)] = True
    # On an open side: the opposite corner weighs nothing; at a corner two of them do not.
    off = closest.weights < 1e-9
    side = (off & rim[closest.face]).any(axis=1)
    corner = (off.sum(axis=1) == 2) & rims[
        reference.faces[closest.face, closest.weights.argmax(axis=1)]]
    edge: Bools = side | corner
    return edge


def seen_by(
    reference: Triangles, views: Iterable[tuple[RangeView, Floats]], dres: float,
    *, reach_dres: float = SEEN_DRES,
) -> Bools:
    """
    Tell which vertices of the reference the scans saw.

    Parameters
    ----------
    reference : Triangles
        In the world's frame.
    views : iterable of (RangeView, (4, 4) float64)
        With their `T_world_view`.
    dres : float
    reach_dres : float
        A scan point so near counts if it was taken from the vertex's outer side.

    Returns
    -------
    (V,) bool
    """
    seen = np.zeros(len(reference.vertices), bool)
    for view, T in views:
        tree = cKDTree(move(T, view.points))
        away, found = tree.query(
            reference.vertices, distance_upper_bound=reach_dres * dres)
        near = np.flatnonzero(np.isfinite(away))
        to_sensor = view.sensor.to_sensor(view.points[found[near]]) @ T[:3, :3].T
        outer = np.einsum('nd,nd->n', to_sensor, reference.vertex_normals[near]) > 0
        seen[near[outer]] = True
    return seen


def cloud_accuracy(
    views: Iterable[tuple[RangeView, Floats]], reference: Triangles, dres: float
) -> float:
    """Return within which distance 90% of the posed scans' points lie, in dres: the floor."""
    points = np.concatenate([move(T, view.points) for view, T in views])
    return _quantile(reference.closest(points).distance / dres, ACCURACY_SHARE)


def surface_facts(surface: SurfaceMesh) -> Mapping[str, Any]:
    """
    Return what can be counted on a surface, without asking whoever made it.

    Returns
    -------
    mapping
        `vertices`, `faces`, `filled_share`, `components`, `floating` (components with less than
        1% of the faces of the largest), `open_edges`, `branching_edges` (more than two faces),
        `turned_edges` (two faces that disagree about the outside), `holes` (rings of open
        edges), `closed`.
    """
    faces = np.asarray(surface.faces, dtype=np.int64)
    count = len(surface.vertices)
    arrows = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    sides = np.sort(arrows, axis=1)
    _, back, counts = np.unique(
        sides[:, 0] * count + sides[:, 1], return_inverse=True, return_counts=True)
    forward = np.bincount(back.reshape(-1), weights=arrows[:, 0] < arrows[:, 1])
    sizes = np.sort(_component_sizes(faces, arrows, count))[::-1]
    rims = sides[(counts == 1)[back.reshape(-1)]]
    return {
        'vertices': count, 'faces': len(faces),
        'filled_share': float(surface.filled.mean()) if len(surface.filled) else 0.0,
        'components': len(sizes), 'floating': int((sizes < 0.01 * sizes[0]).sum()),
        'open_edges': int((counts == 1).sum()), 'branching_edges': int((counts > 2).sum()),
        'turned_edges': int(((counts == 2) & (forward != 1)).sum()),
        'holes': _ring_count(rims, count), 'closed': not len(rims)}


def _component_sizes(
    faces: NDArray[np.int64], arrows: NDArray[np.int64], count: int
) -> NDArray[np.intp]:
    labels = _labels(arrows, count)
    sizes = np.bincount(labels[faces[:, 0]])
    return sizes[sizes > 0]


def _ring_count(rims: NDArray[np.int64], count: int) -> int:
    return len(np.unique(_labels(rims, count)[np.unique(rims)])) if len(rims) else 0


def _labels(pairs: NDArray[np.int64], count: int) -> Ints:
    graph = coo_matrix((np.ones(len(pairs), np.int8), pairs.T), shape=(count, count))
    labels: Ints = connected_components(graph, directed=False)[1]
    return labels
