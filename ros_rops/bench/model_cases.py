# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What models are made of and judged against: scans of a data set, or of a shape known exactly."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from ros_rops.bench.model_distance import Triangles
from ros_rops.bench.model_frames import aligned_poses
from ros_rops.bench.model_score import cloud_accuracy, seen_by
from ros_rops.bench.model_shapes import dres_of, read_shape, scan, Scanner
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.core.errors import ModelError
from ros_rops.core.types import Bools, Floats, RangeView

Pairs = tuple[tuple[RangeView, Floats], ...]


@dataclass(frozen=True, slots=True)
class Limits:
    """What must be reached and what is aimed at: dres, and shares of the points judged."""

    accuracy_must: float
    accuracy_aim: float
    completeness_must: float
    completeness_aim: float
    over_seen: bool = True


LIMITS = {
    'bunny': Limits(0.7, 0.35, 0.995, 0.999, over_seen=False),
    'dragon_stand': Limits(0.8, 0.5, 0.985, 0.995),
    'chef': Limits(0.8, 0.5, 0.99, 0.999),
}
EXACT = Limits(0.5, 0.25, 0.995, 0.999)


@dataclass(frozen=True, slots=True, eq=False)
class ModelCase:
    """
    Views in their places, and what their model should be.

    Parameters
    ----------
    name : str
    poses : str
        'reference', 'engine' (aligned to the reference as a whole) or 'exact'.
    views : tuple of (RangeView, (4, 4) float64)
        With their `T_world_view`.
    dres : float
    reference : Triangles or None
        In the world's frame; None where there is none.
    seen : (V,) bool or None
        Vertices of the reference that the scans saw, under its own poses.
    limits : Limits or None
    """

    name: str
    poses: str
    views: Pairs
    dres: float
    reference: Triangles | None
    seen: Bools | None
    limits: Limits | None

    def floor(self) -> float | None:
        """Return the accuracy of the raw points in these places: the limit to approach."""
        if self.reference is None:
            return None
        return cloud_accuracy(self.views, self.reference, self.dres)


def dataset_case(dataset: ReferenceSet, reference: Triangles | None) -> ModelCase:
    """Return the case of a data set under its reference poses."""
    views = tuple((view, dataset.T_world_view[name]) for name, view in dataset.views.items())
    seen = None if reference is None else seen_by(reference, views, dataset.dres)
    limits = LIMITS.get(dataset.name) if reference is not None else None
    return ModelCase(
        dataset.name, 'reference', views, dataset.dres, reference, seen, limits)


def engine_case(case: ModelCase, config: Config, threads: int) -> ModelCase:
    """
    Return the case with the poses that the engine finds, carried to the reference as a whole.

    Views that are not placed with the others are left out; what the scans saw is as before.

    Raises
    ------
    ModelError
        If the engine places no view.
    """
    from ros_rops.pipeline.session import Session

    session = Session(config, threads=threads, units=case.views[0][0].units)
    for view, _ in case.views:
        session.add(view)
    session.finish()
    largest = max(session.objects, key=lambda one: len(one.views), default=None)
    if largest is None:
        raise ModelError(f'{case.name}: the engine places no view')
    reference = {view.name: T for view, T in case.views}
    found = aligned_poses(
        {view.name: np.asarray(view.T_object_view) for view in largest.views}, reference,
        {view.name: view.points.mean(axis=0) for view, _ in case.views}, case.dres)
    views = tuple((view, found[view.name]) for view, _ in case.views if view.name in found)
    return replace(case, poses='engine', views=views)


def shape_case(name: str, scanner: Scanner, seed: int = 0) -> ModelCase:
    """Return the case of a shape scanned from all around; dres, seen are those without noise."""
    model = read_shape(name)
    clean = tuple(scan(model, replace(scanner, noise_mr=0.0), seed))
    views = tuple(scan(model, scanner, seed)) if scanner.noise_mr else clean
    reference, dres = Triangles(model.vertices, model.faces), dres_of(clean)
    return ModelCase(
        f'{model.name}: {scanner.text}', 'exact', views, dres, reference,
        seen_by(reference, clean, dres), EXACT)


def is_dataset(name: str) -> bool:
    """Tell a data set's folder from the name of a shape or a mesh file."""
    return Path(name).is_dir() or (':' not in name and not Path(name).suffix)
