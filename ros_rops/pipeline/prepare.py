# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Once per view: mesh, keypoints, frames, descriptors, evidence (III-A)."""

from dataclasses import dataclass, replace

from ros_rops.core.config import Config
from ros_rops.core.errors import ViewError
from ros_rops.core.mesh import build_mesh
from ros_rops.core.noise import evened
from ros_rops.core.sampling import coarsened
from ros_rops.core.surface import make_surface, Surface
from ros_rops.core.types import RangeMesh, RangeView


@dataclass(frozen=True, slots=True)
class PreparedView:
    """
    A view with its mesh and its side of a registration.

    The mesh may be coarser than the view (`core.sampling`): its vertices are not the view's points
    then.
    """

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
        If the view holds too little to register, or stray points, or its mesh is by far coarser
        or finer than `resolution`.
    """
    sampled = coarsened(view, config.mesh)
    mesh = build_mesh(evened(sampled, config.mesh, threads=threads), config.mesh)
    if resolution is not None:
        _check_resolution(view.name, mesh.resolution / resolution, config.growth.resolution_ratio)
    surface = make_surface(
        view.name, mesh, view.sensor, config, resolution=resolution, beyond=view.beyond,
        threads=threads)
    return PreparedView(view, mesh, replace(
        surface, support=view.support, T_fixed_surface=view.T_fixed_sensor))


def _check_resolution(name: str, ratio: float, most: float) -> None:
    # Before any length in mesh resolutions is used: other units would look like stray points.
    if ratio > 0 and not 1.0 / most <= ratio <= most:
        raise ViewError(
            f'view {name!r}: its mesh resolution is {ratio:.3g} times that of the first view: '
            f'other units, or another sensor?')
