# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What the experiments on many views share: jobs, what is kept of a case, their cells."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from ros_rops.bench.evaluate import known_views
from ros_rops.bench.experiment import Case, Laboratory
from ros_rops.bench.multiview import engine_session, Job, named_views, shuffled
from ros_rops.bench.paper.rendered import rendered_set
from ros_rops.bench.rivals.connected_graph import CONNECTED_GRAPH
from ros_rops.bench.rivals.spanning_tree import SPANNING_TREE
from ros_rops.bench.rivals.strategy import Strategy
from ros_rops.bench.truth import ReferenceSet
from ros_rops.recordings.synthetic import Model

OURS = Strategy('shape growing', 'Guo et al. 2014, as the engine has it', engine_session)
RIVALS = (CONNECTED_GRAPH, SPANNING_TREE)

# Long lists that no table shows.
LEFT_OUT = ('case', 'errors', 'sequence', 'notes', 'unknown_views', 'datasets')
NO_MESH = 'no mesh to render views from (--mesh)'


def rendered(laboratory: Laboratory, model: Model) -> ReferenceSet:
    """Return 24 views around a mesh, rendered once."""
    def make() -> ReferenceSet:
        laboratory.tell(f'rendering {model.name}')
        return rendered_set(model)

    # Of one name there are two where a table has its meshes scaled.
    return laboratory.once(f'rendered {model.name} {model.radius!r}', make)


def alike(model: Model, radius: float = 0.1) -> Model:
    """Return a mesh in metres and of one size, so that one session takes views of several."""
    vertices = (model.vertices - model.middle) * (radius / model.radius)
    return replace(model, vertices=vertices, units='m')


def job_of(
    laboratory: Laboratory, sets: Sequence[ReferenceSet], seed: int | None = None,
    most: int | None = None,
) -> Job:
    """Return the views of sets as one session, in the random order of a seed, the first few."""
    views = tuple(named_views(sets))
    views = (views if seed is None else shuffled(views, seed))[:most]
    known = known_views(sets)
    return Job(
        tuple(one.name for one in sets), 'given' if seed is None else f'seed {seed}', views,
        {view.name: known[view.name] for view in views}, laboratory.config, laboratory.threads)


def kept(case: Case, **extra: Any) -> dict[str, Any]:
    """Return what the laboratory keeps of a case of `run_job`, under `extra`."""
    result = {**extra, **{key: case[key] for key in case if key not in (*LEFT_OUT, *extra)}}
    if 'coarse' in case:
        result['coarse'] = {k: v for k, v in case['coarse'].items() if k not in LEFT_OUT}
    return result


def residual_of(case: Case) -> float | None:
    """Return the mean residual of the objects of a case, in dres."""
    found = [one['residual_dres'] for one in case['objects'] if one['residual_dres'] is not None]
    return float(np.mean(found)) if found else None


def faults(case: Case) -> str:
    """Return wrong placements, wrong merges and splits in a cell."""
    return f'{case["wrong_placements"]}, {case["wrong_merges"]}, {case["splits"]}'


def percent(placed: int, views: int) -> str:
    """Return placed views as the paper states them, with the count."""
    return f'{100 * placed / views:.0f}% ({placed}/{views})'


def most_registrations(cases: Sequence[Case]) -> str:
    """Say what ours took at most for N views of one object, against what it must."""
    worst = max(cases, key=lambda case: case['attempts'] / case['views'])
    beyond = [case for case in cases if case['attempts'] > case['views'] + 2]
    over = [case for case in cases if case['attempts'] > 1.3 * case['views']]
    return (
        f'Registrations for N views of one object, {len(cases)} sessions: at most '
        f'{worst["attempts"] / worst["views"]:.2f} N ({worst["set"]}, {worst["attempts"]} for '
        f'{worst["views"]} views; must 1.3 N: {_count(over)} above; aim N + 2: {_count(beyond)} '
        'above).')


def _count(cases: Sequence[Mapping[str, Any]]) -> str:
    return str(len(cases)) if cases else 'none'
