# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops evaluate RUN DATASET`: judge the poses of a run against reference poses."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
import math
from pathlib import Path
from typing import Any

import numpy as np
from ros_rops.bench.judgement import judge, Judgement, Placement, ViewTruth
from ros_rops.bench.residual import residual
from ros_rops.bench.run_folder import match_names, read_run, Run
from ros_rops.bench.truth import load_dataset, ReferenceSet, units_factor
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats
from ros_rops.recordings.poses import Poses, read_poses


@dataclass(frozen=True, slots=True)
class KnownView:
    """
    The truth of one view, with its units and, where there are any, its points.

    Parameters
    ----------
    label : str
    T_world_view : (4, 4) float64
    units : str
    dres : float
    centroid : (3,) float64 or None
        Mean of the points; None where nobody knows it: translations are then measured at the
        view's origin.
    points : (N, 3) float64 or None
        None where only poses are known; there is no residual then.
    """

    label: str
    T_world_view: Floats
    units: str
    dres: float
    centroid: Floats | None = None
    points: Floats | None = None


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Judgement of a run; `residuals` in dres by object, None where it cannot be measured."""

    judgement: Judgement
    residuals: Mapping[str, float | None]
    attempts: int | None
    measured_at: str
    notes: tuple[str, ...]

    def numbers(self) -> dict[str, Any]:
        """Return everything as plain JSON values."""
        found = self.judgement
        return {
            'views': found.views,
            'placed': found.placed,
            'wrong_placements': len(found.wrong_placements),
            'wrong_merges': found.wrong_merges,
            'splits': found.splits,
            'mean_rotation_deg': found.overall.mean_rotation_deg,
            'max_rotation_deg': found.overall.max_rotation_deg,
            'mean_translation_dres': found.overall.mean_translation_dres,
            'max_translation_dres': found.overall.max_translation_dres,
            'translation_measured_at': self.measured_at,
            'attempts': self.attempts,
            'objects': [
                {**asdict(one), 'residual_dres': self.residuals.get(one.label)}
                for one in found.objects
            ],
            'wrong_views': list(found.wrong_placements),
            'unknown_views': list(found.unknown),
            'errors': {name: asdict(error) for name, error in found.errors.items()},
            'notes': list(self.notes),
        }


def known_views(sets: Sequence[ReferenceSet]) -> dict[str, KnownView]:
    """Return the truth of all views of the sets, by 'set/view'."""
    return {
        f'{one.name}/{name}': KnownView(
            one.label(name), one.T_world_view[name], one.units, one.dres,
            view.points.mean(axis=0), view.points)
        for one in sets
        for name, view in one.views.items()
    }


def known_poses(poses: Poses, run: Run) -> dict[str, KnownView]:
    """
    Return the truth that a file of exact poses tells; dres and centroids are the run's own.

    Raises
    ------
    InputError
        If the run states no mesh resolution.
    """
    factor = units_factor(run.units, poses.units)
    if not run.mesh_resolution > 0:
        raise InputError(f'the run states no mesh resolution, got {run.mesh_resolution!r}')
    if poses.centres:
        return _known_by_centre(poses, run, factor)
    given = {true: name for name, true in match_names(
        list(run.centroids), list(poses.T_world_view)).items()}
    return {
        name: KnownView(
            poses.objects.get(name, 'object'), T, poses.units, run.mesh_resolution * factor,
            run.centroids[given[name]] * factor if name in given else None)
        for name, T in poses.T_world_view.items()
    }


def _known_by_centre(poses: Poses, run: Run, factor: float) -> dict[str, KnownView]:
    """
    Return the truth of views cut out of frames that show several objects at once.

    A view `<frame>/<k>` shows the object whose centre is nearest to the middle of its points.
    What the run never cut out is not known: it may have been hidden.
    """
    known = {}
    for name, centroid in run.centroids.items():
        T = poses.T_world_view.get(name, poses.T_world_view.get(name.rpartition('/')[0]))
        if T is None:
            continue
        place = T[:3, :3] @ (centroid * factor) + T[:3, 3]
        label = min(
            poses.centres, key=lambda one: float(np.linalg.norm(poses.centres[one] - place)))
        known[name] = KnownView(
            label, T, poses.units, run.mesh_resolution * factor, centroid * factor)
    return known


def rescaled(T: Floats, factor: float) -> Floats:
    """Return the transform (4, 4) with its translation in other units."""
    result = T.copy()
    result[:3, 3] *= factor
    return result


def _placements(run: Run, known: Mapping[str, KnownView]) -> dict[str, Placement]:
    names = match_names(list(run.placements), list(known))
    result: dict[str, Placement] = {}
    for name, placement in run.placements.items():
        true_name = names.get(name, name)
        units = known[true_name].units if true_name in known else run.units
        if true_name in result:
            raise InputError(f'the run places {true_name!r} twice (as {name!r} too)')
        T = rescaled(placement.T_object_view, units_factor(run.units, units))
        result[true_name] = Placement(placement.shape, T)
    return result


def _truth(known: KnownView) -> ViewTruth:
    centroid = np.zeros(3) if known.centroid is None else known.centroid
    return ViewTruth(known.label, known.T_world_view, centroid, known.dres)


def _residuals(
    placements: Mapping[str, Placement], known: Mapping[str, KnownView]
) -> dict[str, float | None]:
    """Residual by true object, over its largest shape."""
    result: dict[str, float | None] = {}
    for label in dict.fromkeys(view.label for view in known.values()):
        names = [n for n in placements if n in known and known[n].label == label]
        shapes = [placements[n].shape for n in names]
        largest = max(dict.fromkeys(shapes), key=shapes.count, default=None)
        names = [n for n in names if placements[n].shape == largest]
        points = [known[n].points for n in names]
        value = math.nan
        if all(p is not None for p in points) and names:
            value = residual(
                [p for p in points if p is not None],
                [placements[n].T_object_view for n in names], known[names[0]].dres)
        result[label] = value if math.isfinite(value) else None
    return result


def _notes(
    run: Run, known: Mapping[str, KnownView], at_origin: Sequence[str], unknown: Sequence[str]
) -> tuple[str, ...]:
    notes = []
    if at_origin:
        notes.append(
            'translations are measured at the origin of the views, which overstates them for a '
            'far sensor: neither the reference nor the run states their centroids')
    if unknown:
        notes.append(f'placed, but without a reference: {", ".join(unknown)}')
    if run.units not in ('m', 'mm'):
        notes.append(f'units of the run are {run.units!r}: taken as those of the reference')
    given = set(match_names(list(run.statuses), list(known)).values())
    if missing := [name for name in known if name not in given]:
        notes.append(f'{len(missing)} of {len(known)} reference views were not in the run')
    return tuple(notes)


def evaluate(run: Run, known: Mapping[str, KnownView], *, residuals: bool = True) -> Evaluation:
    """
    Judge a run: placed, wrong, merged and split views, errors, residual (EVALUATION).

    Parameters
    ----------
    run : Run
    known : mapping of str to KnownView
        All views that the truth knows; those that the run never saw count as not placed.
    residuals : bool
        Measure the residual too, which takes seconds.
    """
    placements = _placements(run, known)
    at_origin = [name for name in placements if name in known and known[name].centroid is None]
    judgement = judge(placements, {name: _truth(view) for name, view in known.items()})
    return Evaluation(
        judgement=judgement,
        residuals=_residuals(placements, known) if residuals else {},
        attempts=run.attempts,
        measured_at='origin' if at_origin else 'centroid',
        notes=_notes(run, known, at_origin, judgement.unknown),
    )


def evaluate_run(run: Path | str, truths: Sequence[Path | str]) -> Evaluation:
    """
    Judge a run folder against dataset folders, or against a JSON file of exact poses.

    Raises
    ------
    InputError
        If one of them cannot be read, or no view of the run has a reference.
    """
    read = read_run(run)
    known: dict[str, KnownView] = {}
    for truth in map(Path, truths):
        if truth.is_dir():
            known.update(known_views([load_dataset(truth)]))
        else:
            known.update(known_poses(read_poses(truth), read))
    if not match_names(list(read.statuses), list(known)):
        raise InputError(f'{run}: none of its views is named in {", ".join(map(str, truths))}')
    return evaluate(read, known)
