# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Once per view: mesh, keypoints, frames, descriptors, evidence (III-A)."""

from dataclasses import dataclass

from ros_rops.core.config import Config
from ros_rops.core.mesh import build_mesh
from ros_rops.core.surface import make_surface, Surface
from ros_rops.core.types import RangeMesh, RangeView


@dataclass(frozen=True, slots=True)
class PreparedView:
    """A view with its mesh and its side of a registration."""

    view: RangeView
    mesh: RangeMesh
    surface: Surface


def prepare(
    view: RangeView, config: Config, *, resolution: float | None = None, threads: int = 0
) -> PreparedView:
    """
    Mesh and describe a view.

    Parameters
    ----------
    view : RangeView
    config : Config
    resolution : float, optional
        What `mr` means, in the view's units; the mesh's own by default.
    threads : int
        0 takes all cores; no influence on the result.

    Raises
    ------
    ViewError
        If the view holds too little to register, or stray points.
    """
    mesh = build_mesh(view, config.mesh)
    surface = make_surface(
        view.name, mesh, view.sensor, config, resolution=resolution, threads=threads)
    return PreparedView(view, mesh, surface)
