# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Judge the shapes of a session against reference poses: what is placed, and how well."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from ros_rops.bench.errors import pair_errors, PairErrors
from ros_rops.core.types import Floats


@dataclass(frozen=True, slots=True)
class ViewTruth:
    """
    The truth of one view.

    Parameters
    ----------
    label : str
        The object that it shows.
    T_world_view : (4, 4) float64
        Reference pose; each object has its own world.
    centroid : (3,) float64
        Mean of the view's points in its own frame; the origin where it is not known.
    dres : float
        Mesh resolution of the object's views.
    """

    label: str
    T_world_view: Floats
    centroid: Floats
    dres: float


@dataclass(frozen=True, slots=True)
class Placement:
    """A placed view: its shape's id and `T_object_view` (4, 4) in the units of the truth."""

    shape: str
    T_object_view: Floats


@dataclass(frozen=True, slots=True)
class ObjectErrors:
    """Errors of one true object: mean and maximum over its placed views, None where none is."""

    label: str
    views: int
    placed: int
    mean_rotation_deg: float | None
    max_rotation_deg: float | None
    mean_translation_dres: float | None
    max_translation_dres: float | None


@dataclass(frozen=True, slots=True)
class Judgement:
    """
    What became of all views that the truth knows.

    Parameters
    ----------
    views, placed : int
    wrong_placements : tuple of str
        Names of the views more than 5 degrees or 5 dres off.
    wrong_merges : int
        Over the shapes: true objects in it beyond the first.
    splits : int
        Over the true objects: shapes that hold its views beyond the first.
    unknown : tuple of str
        Placed views of which the truth knows nothing; not judged.
    overall : ObjectErrors
        Over all judged views together.
    objects : tuple of ObjectErrors
    errors : mapping of str to PairErrors
        By view name.
    """

    views: int
    placed: int
    wrong_placements: tuple[str, ...]
    wrong_merges: int
    splits: int
    unknown: tuple[str, ...]
    overall: ObjectErrors
    objects: tuple[ObjectErrors, ...]
    errors: Mapping[str, PairErrors]


def _mean_transform(transforms: Sequence[Floats], T_object_view: Sequence[Floats],
                    T_world_view: Sequence[Floats], centroids: Sequence[Floats]) -> Floats:
    """Mean rotation (chordal) and, given it, the least squares shift at the views' centroids."""
    u, _, vt = np.linalg.svd(sum(T[:3, :3] for T in transforms))
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    mapped = [T[:3, :3] @ c + T[:3, 3] for T, c in zip(T_object_view, centroids, strict=True)]
    wanted = [T[:3, :3] @ c + T[:3, 3] for T, c in zip(T_world_view, centroids, strict=True)]
    result = np.eye(4)
    result[:3, :3] = rotation
    result[:3, 3] = np.mean(wanted, axis=0) - rotation @ np.mean(mapped, axis=0)
    return result


class _Group:
    """The views of one true object in one shape, ready to be aligned."""

    def __init__(self, placements: Sequence[Placement], truths: Sequence[ViewTruth]) -> None:
        self.T_object_view = [p.T_object_view for p in placements]
        self.truths = truths
        # Each view alone says where the object's frame lies in the world.
        self.votes = [
            t.T_world_view @ np.linalg.inv(T)
            for t, T in zip(truths, self.T_object_view, strict=True)
        ]

    def errors(self, T_world_object: Floats) -> list[PairErrors]:
        return [
            pair_errors(T_world_object @ T, t.T_world_view, t.centroid, t.dres)
            for T, t in zip(self.T_object_view, self.truths, strict=True)
        ]

    def mean(self, members: Sequence[int]) -> Floats:
        return _mean_transform(
            [self.votes[k] for k in members],
            [self.T_object_view[k] for k in members],
            [self.truths[k].T_world_view for k in members],
            [self.truths[k].centroid for k in members],
        )

    def agreeing(self, T_world_object: Floats) -> list[int]:
        return [k for k, error in enumerate(self.errors(T_world_object)) if error.correct]

    def best_vote(self) -> list[int]:
        def rank(vote: Floats) -> tuple[int, float]:
            errors = self.errors(vote)
            spread = sum(min(e.rotation_deg, 5.0) + min(e.translation_dres, 5.0) for e in errors)
            return sum(e.correct for e in errors), -spread

        return self.agreeing(max(self.votes, key=rank))

    def align(self) -> Floats:
        """
        Best rigid alignment of the shape to the reference poses.

        The mean over the largest set of views that agree within 5 degrees and 5 dres, so that
        one wrong view is counted as one wrong view and does not drag the right ones along.
        """
        members = self.best_vote()
        for _ in range(10):
            alignment = self.mean(members)
            found = self.agreeing(alignment)
            if found == members or not found:
                break
            members = found
        return alignment


def _summary(label: str, views: int, errors: Sequence[PairErrors]) -> ObjectErrors:
    if not errors:
        return ObjectErrors(label, views, 0, None, None, None, None)
    rotations = [e.rotation_deg for e in errors]
    translations = [e.translation_dres for e in errors]
    return ObjectErrors(
        label, views, len(errors), float(np.mean(rotations)), max(rotations),
        float(np.mean(translations)), max(translations))


def _count_beyond_first(pairs: Sequence[tuple[str, str]]) -> int:
    """Count the different second members beyond one for each first member."""
    return len(set(pairs)) - len({first for first, _ in pairs})


def best_alignment(placements: Sequence[Placement], truths: Sequence[ViewTruth]) -> Floats:
    """Return the rigid `T_world_object` (4, 4) that carries a shape to its reference best."""
    return _Group(placements, truths).align()


def judge(placements: Mapping[str, Placement], truth: Mapping[str, ViewTruth]) -> Judgement:
    """
    Compare the placed views with the truth (EVALUATION: multi-view).

    Per true object and shape the views are aligned to the reference poses (a common frame is
    free). Splits and merges are counted beside, not as wrong placements.

    Parameters
    ----------
    placements : mapping of str to Placement
        Placed views only, by name.
    truth : mapping of str to ViewTruth
        All views that were given in, by the same names.
    """
    known = [name for name in truth if name in placements]
    groups: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name in known:
        groups[placements[name].shape, truth[name].label].append(name)
    errors: dict[str, PairErrors] = {}
    for names in groups.values():
        group = _Group([placements[n] for n in names], [truth[n] for n in names])
        errors.update(zip(names, group.errors(group.align()), strict=True))
    labels = list(dict.fromkeys(t.label for t in truth.values()))
    of_label = {
        label: [name for name in truth if truth[name].label == label] for label in labels
    }
    return Judgement(
        views=len(truth),
        placed=len(known),
        wrong_placements=tuple(name for name in known if not errors[name].correct),
        wrong_merges=_count_beyond_first(list(groups)),
        splits=_count_beyond_first([(label, shape) for shape, label in groups]),
        unknown=tuple(name for name in placements if name not in truth),
        overall=_summary('all', len(truth), [errors[name] for name in known]),
        objects=tuple(
            _summary(label, len(names), [errors[n] for n in names if n in errors])
            for label, names in of_label.items()
        ),
        errors=errors,
    )
