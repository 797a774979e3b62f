# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Reference sets made worse: noise on every coordinate (V-A4), fewer vertices (V-A5).

Poses, names and dres stay those of the set as it was: the same pairs are evaluated, and errors
are judged by the same length, however rough the views have become.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math
from typing import Any

import numpy as np
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import MeshConfig
from ros_rops.core.errors import ParameterError
from ros_rops.core.mesh import build_mesh
from ros_rops.core.types import RangeView


def noisy(dataset: ReferenceSet, sigma_dres: float, seed: int) -> ReferenceSet:
    """
    Add gaussian noise along x, y and z to every point of every view (V-A4).

    Grids and sensors are kept: a pixel keeps its neighbours, its point leaves its ray. At one seed
    the errors of a stronger noise are those of a weaker one, scaled.

    Parameters
    ----------
    dataset : ReferenceSet
    sigma_dres : float
        Standard deviation on each coordinate, in dres.
    seed : int
        Each view has a stream of its own, by its place in the set.

    Raises
    ------
    ParameterError
        If `sigma_dres` is negative or not finite.
    """
    if not (math.isfinite(sigma_dres) and sigma_dres >= 0):
        raise ParameterError(f'sigma_dres: expected 0 or more, got {sigma_dres!r}')
    if sigma_dres == 0:
        return dataset
    views = {}
    for number, (name, view) in enumerate(dataset.views.items()):
        error = np.random.default_rng([seed, number]).normal(size=view.points.shape)
        views[name] = replace(view, points=view.points + sigma_dres * dataset.dres * error)
    return replace(dataset, views=views)


def decimated(dataset: ReferenceSet, parts: Sequence[int]) -> Iterator[ReferenceSet]:
    """
    Simplify every view's mesh to one vertex of 1, 2, 4 ... (V-A5).

    Open3D's quadric decimation of the mesh that the engine builds of a view; each is simplified
    from the one before. What is left of the vertices becomes an unorganized view of the same
    sensor.

    Parameters
    ----------
    dataset : ReferenceSet
    parts : sequence of int
        Rising; 1 leaves the set as it is.

    Yields
    ------
    ReferenceSet
        One for each of `parts`.

    Raises
    ------
    ParameterError
        If `parts` do not rise from 1 or more.
    ModuleNotFoundError
        Without Open3D (the extra `bench`).
    """
    if list(parts) != sorted(set(parts)) or min(parts, default=1) < 1:
        raise ParameterError(f'parts: expected rising numbers from 1 on, got {list(parts)}')
    meshes = {name: _mesh(view) for name, view in dataset.views.items()}
    for part in parts:
        if part == 1:
            yield dataset
            continue
        views = {}
        for name, (vertices, mesh) in meshes.items():
            mesh = _simplified(mesh, vertices / part)
            meshes[name] = vertices, mesh
            views[name] = replace(
                dataset.views[name], points=np.asarray(mesh.vertices), grid=None, colors=None)
        yield replace(dataset, views=views)


def _mesh(view: RangeView) -> tuple[int, Any]:
    """Return how many vertices the mesh of a view has, and the mesh as Open3D holds it."""
    import open3d

    mesh = build_mesh(view, MeshConfig())
    surface = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(mesh.vertices.copy()),
        open3d.utility.Vector3iVector(mesh.faces.copy()))
    surface.remove_unreferenced_vertices()
    return len(surface.vertices), surface


def _simplified(mesh: Any, vertices: float) -> Any:
    """Simplify until at most so many vertices are left: Open3D counts triangles."""
    while len(mesh.vertices) > vertices:
        triangles = int(len(mesh.triangles) * vertices / len(mesh.vertices))
        mesh = mesh.simplify_quadric_decimation(triangles)
        mesh.remove_unreferenced_vertices()
    return mesh
