# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The views of an object, meshed, weighted and in their places: what a model is made of."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ros_rops.core.config import Config
from ros_rops.core.errors import ViewError
from ros_rops.core.mesh import build_mesh
from ros_rops.core.se3 import move
from ros_rops.core.types import Floats, frozen, RangeMesh, RangeView
from ros_rops.kernels.sight import Sight
from ros_rops.modelling.weights import nearest_of, point_weights


@dataclass(frozen=True, slots=True)
class PosedView:
    """
    A view in its place.

    Parameters
    ----------
    name : str
    number : int
        Place of the view in the run's order: the `view_id` of its points, wherever they go.
    view : RangeView
    mesh : RangeMesh
        Its vertices are the view's points, all of them and in their order.
    weights : (N,) float32
        How far each point may be trusted, 0 to 1 (`modelling.weights`).
    T_object_view : (4, 4) float64
    """

    name: str
    number: int
    view: RangeView
    mesh: RangeMesh
    weights: NDArray[np.float32]
    T_object_view: Floats

    @property
    def points(self) -> Floats:
        """Return the points in the object's frame, (N, 3)."""
        return move(self.T_object_view, self.view.points)

    @property
    def normals(self) -> Floats:
        """Return the normals in the object's frame, (N, 3); zero for points without a face."""
        turned: Floats = self.mesh.normals @ self.T_object_view[:3, :3].T
        return turned

    def sight(self) -> Sight:
        """Return its lines of sight, in its place."""
        return Sight.of(
            self.mesh.vertices, self.mesh.faces, self.weights, self.view.sensor,
            T_object_view=self.T_object_view, beyond=self.view.beyond)


def pose_views(
    poses: Iterable[tuple[str, Floats]], views: Mapping[str, RangeView],
    numbers: Mapping[str, int], config: Config,
) -> tuple[PosedView, ...]:
    """
    Mesh and weight the views of an object.

    Parameters
    ----------
    poses : iterable of (str, (4, 4) float64)
        Name and T_object_view of each view of the object.
    views : mapping of str to RangeView
        All in the same units.
    numbers : mapping of str to int
    config : Config
        Group `mesh`.

    Returns
    -------
    tuple of PosedView
        Without the views of which no mesh comes.
    """
    posed = []
    placed = list(poses)
    nearest = nearest_of(views[name] for name, _ in placed)
    for name, T in placed:
        try:
            mesh = build_mesh(views[name], config.mesh)
        except ViewError:
            continue
        weights = point_weights(views[name], mesh, nearest=nearest)
        posed.append(PosedView(
            name, numbers[name], views[name], mesh, weights, frozen(T, np.float64)))
    return tuple(posed)


def resolution_of(views: Iterable[PosedView]) -> float:
    """Return the mean of the views' mesh resolutions: dres, in their units."""
    return float(np.mean([view.mesh.resolution for view in views]))
