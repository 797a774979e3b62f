# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
All points of an object's views, as they were measured: what a run without models gives.

`modelling.cloud` makes the model's cloud, in which each place is once.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ros_rops.core.config import Config
from ros_rops.core.errors import ViewError
from ros_rops.core.mesh import build_mesh
from ros_rops.core.types import Bytes, Floats, Ints, RangeView

GREY = 180


@dataclass(frozen=True, slots=True)
class ObjectCloud:
    """
    All points of an object's views in the object's frame.

    Parameters
    ----------
    points : (N, 3) float64
    normals : (N, 3) float64
        Unit, towards the sensor that saw the point; zero where a view's mesh has none.
    colors : (N, 3) uint8 or None
        None if no view has colours; grey for the views without.
    view_ids : (N,) int32
        Place of the point's view in `names`.
    names : tuple of str
    """

    points: Floats
    normals: Floats
    colors: Bytes | None
    view_ids: Ints
    names: tuple[str, ...]


def assemble(
    model: Any, views: Mapping[str, RangeView], config: Config, order: Sequence[str],
) -> ObjectCloud:
    """
    Return the cloud of an object.

    `view_ids` count in `order`, the names of all views of the run: they agree between objects
    and with the list of views in `poses.json`.
    """
    points, normals, colors, ids = [], [], [], []
    place = {name: k for k, name in enumerate(order)}
    for placed in model.views:
        view = views[placed.name]
        T = placed.T_object_view
        points.append(view.points @ T[:3, :3].T + T[:3, 3])
        normals.append(_normals(view, config) @ T[:3, :3].T)
        colors.append(_colors(view))
        ids.append(np.full(len(view.points), place[placed.name], np.int32))
    coloured = any(views[placed.name].colors is not None for placed in model.views)
    return ObjectCloud(
        np.concatenate(points), np.concatenate(normals),
        np.concatenate(colors) if coloured else None, np.concatenate(ids), tuple(order))


def _normals(view: RangeView, config: Config) -> Floats:
    try:
        return build_mesh(view, config.mesh).normals
    except ViewError:
        return np.zeros_like(view.points)


def _colors(view: RangeView) -> Bytes:
    if view.colors is not None:
        return view.colors
    return np.full(view.points.shape, GREY, np.uint8)
