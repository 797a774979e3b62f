# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A data set folder read whole: its views, their reference poses and its mesh resolution."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from ros_rops.bench.resolution import mesh_resolution
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats, RangeView, Units
from ros_rops.recordings.dataset import read_dataset
from ros_rops.recordings.poses import POSES_NAME
from ros_rops.recordings.reader import read_view

_METRES = {'m': 1.0, 'mm': 0.001}


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceSet:
    """
    Views and their reference poses, in memory.

    Parameters
    ----------
    name : str
        Name of the folder.
    units : {'m', 'mm', 'unknown'}
    reference_kind : str
        published, derived or exact.
    views : mapping of str to RangeView
        By file name, in natural order.
    T_world_view : mapping of str to (4, 4) float64
    dres : float
        Mean over the views of their mean mesh edge length, in `units`.
    objects : mapping of str to str
        The object that a view shows; the set's name where the folder does not say.
    """

    name: str
    units: Units
    reference_kind: str
    views: Mapping[str, RangeView]
    T_world_view: Mapping[str, Floats]
    dres: float
    objects: Mapping[str, str] = field(default_factory=dict)

    def label(self, view: str) -> str:
        """Return the object that a view shows."""
        return self.objects.get(view, self.name)

    def reference(self, source: str, target: str) -> Floats | None:
        """Return the reference `T_target_source` (4, 4), None for views of two objects."""
        if self.label(source) != self.label(target):
            return None
        T: Floats = np.linalg.inv(self.T_world_view[target]) @ self.T_world_view[source]
        return T


def units_factor(units: str, target: str) -> float:
    """
    Return the factor that turns lengths in `units` into lengths in `target`.

    1 where one of them is not known: nothing can be reconciled then, and the caller says so.
    """
    if units not in _METRES or target not in _METRES:
        return 1.0
    return _METRES[units] / _METRES[target]


def load_dataset(
    folder: Path | str,
    *,
    resolution: Callable[[RangeView], float] = mesh_resolution,
) -> ReferenceSet:
    """
    Read a data set folder: every view that has a reference pose.

    Parameters
    ----------
    folder : Path or str
        Holds `views/` and `reference_poses.json`.
    resolution : callable
        Mean mesh edge length of a view.

    Raises
    ------
    InputError
        If the folder, its poses file or one of the views cannot be read.
    ViewError
        If a view holds too little for a mesh.
    """
    found = read_dataset(folder)
    if not found.T_world_view:
        raise InputError(f'{Path(folder) / POSES_NAME}: missing, nothing can be judged')
    paths = [path for path in found.paths if path.name in found.T_world_view]
    views = {path.name: read_view(path, units=found.units) for path in paths}
    return ReferenceSet(
        name=found.name,
        units='mm' if found.units == 'mm' else 'm',
        reference_kind=found.reference,
        views=views,
        T_world_view={name: found.T_world_view[name] for name in views},
        dres=float(np.mean([resolution(view) for view in views.values()])),
        objects=found.objects,
    )
