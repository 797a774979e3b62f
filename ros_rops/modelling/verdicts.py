# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What was found of an object's registration, in plain words."""

from collections.abc import Sequence

import numpy as np
from ros_rops.modelling.constraint import Constraint
from ros_rops.modelling.coverage import Coverage
from ros_rops.modelling.misfits import CONTRADICTED, Misfit, PULL_MR
from ros_rops.modelling.posed import PosedView
from ros_rops.modelling.residuals import ViewResiduals
from ros_rops.modelling.standing import Standing
from ros_rops.modelling.words import coordinates, length

LONELY = 0.9
"""Share of points that no other view knows from which a view hardly touches the others."""


def flags_of(
    view: PosedView, misfit: Misfit | None, rival: str | None, alone: float,
    constraint: Constraint | None, resolution: float, *, single: bool, left_out: bool,
) -> tuple[str, ...]:
    """Return what a reader should know of a view, a sentence each."""
    flags = []
    if misfit is not None and misfit.contradicted > CONTRADICTED:
        flags.append(
            f'{misfit.contradicted:.0%} of its points that other views know are contradicted '
            'by them')
    if misfit is not None and misfit.pull > PULL_MR * resolution:
        flags.append(
            f'the other views would move it by about {length(misfit.pull, view.view.units)} '
            f'({misfit.pull / resolution:.1f} mesh resolutions)')
    if rival is not None:
        flags.append(
            f'it and {rival} do not fit: which of the two is wrong cannot be told, so that both '
            'stay in cloud and surface')
    elif misfit is not None and not left_out:
        flags.append('it stays in cloud and surface: the views that fit do not outweigh it')
    if alone >= LONELY and not single:
        flags.append(f'no other view knows the places of {alone:.0%} of its points')
    if constraint is not None and not constraint.held:
        flags.append(f'not held by the other views: {constraint.text}')
    return tuple(flags)


def notes_of(views: Sequence[PosedView], standing: Standing) -> tuple[str, ...]:
    """Return a sentence on the views that are left out of a model, and on those in question."""
    out = [views[k].name for k in standing.left_out]
    kept = [
        views[one.index].name for one in standing.misfits if one.index not in standing.left_out]
    notes = []
    if out:
        one = len(out) == 1
        notes.append(
            f'{", ".join(out)} {"is" if one else "are"} left out of cloud and surface: '
            f'{"it does" if one else "they do"} not fit the other views')
    if kept:
        notes.append(
            f'{", ".join(kept)}: they do not fit, and it cannot be told which views are wrong; '
            'all of them stay in cloud and surface')
    return tuple(notes)


def summary_of(
    views: Sequence[PosedView], maps: Sequence[ViewResiduals], misfits: Sequence[Misfit],
    constraints: Sequence[Constraint | None], coverage: Coverage | None,
) -> str:
    """Return one honest sentence on the object."""
    units = views[0].view.units
    parts = [f'{len(views)} view{"" if len(views) == 1 else "s"}']
    sizes = np.concatenate([np.abs(one.residual[np.isfinite(one.residual)]) for one in maps])
    if len(sizes):
        parts.append(f'median residual {length(float(np.median(sizes)), units)}')
    elif len(views) > 1:
        parts.append('no place seen by two of them')
    else:
        parts.append('no other to compare it with')
    parts.append(_seen(coverage))
    parts += [_worst(views, misfits), _sliding(views, constraints)]
    return ', '.join(part for part in parts if part)


def _seen(coverage: Coverage | None) -> str:
    if coverage is None:
        return 'how much of the surface is unseen is not known'
    share = f'{coverage.unseen_share:.1%} of the surface unseen'
    if not coverage.directions:
        return share
    return f'{share} (look from {coordinates(np.array(coverage.directions[0].direction))})'


def _worst(views: Sequence[PosedView], misfits: Sequence[Misfit]) -> str:
    if len(views) < 2:
        return ''
    if not misfits:
        return 'no view stands out'
    worst = misfits[0]
    name, more = views[worst.index].name, len(misfits) - 1
    if worst.rival is not None:
        text = f'{name} and {views[worst.rival].name} do not fit each other'
        more -= 1
    elif worst.contradicted > CONTRADICTED:
        text = f'worst view {name}: {worst.contradicted:.0%} of it contradicted'
    else:
        text = f'worst view {name}: off by about {length(worst.pull, views[0].view.units)}'
    return text + (f' ({more} more stand out)' if more else '')


def _sliding(views: Sequence[PosedView], constraints: Sequence[Constraint | None]) -> str:
    loose = [
        view.name for view, one in zip(views, constraints, strict=True)
        if one is not None and not one.held]
    if not loose:
        return ''
    if len(loose) == 1:
        return f'{loose[0]} is hardly held by the others'
    return f'{len(loose)} views are hardly held by the others'
