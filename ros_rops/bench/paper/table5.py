# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Table V: the views of all objects in one session."""

from collections.abc import Sequence
from typing import Any

from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.multiview import run_apart
from ros_rops.bench.paper.many_views import (
    alike, faults, job_of, kept, percent, rendered)
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet

# Object, views, then degrees and dres: coarse, fine. All views were registered, four shapes.
PAPER = (
    ('Chef', 22, 1.8330, 1.2674, 0.3341, 0.3975),
    ('Chicken', 16, 1.6183, 1.3967, 0.4286, 0.3969),
    ('Parasaurolophus', 16, 1.2157, 1.6750, 0.4131, 0.5258),
    ('T-Rex', 21, 1.4149, 1.8516, 0.2369, 0.1333),
)


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Register all real sets together, then all rendered ones."""
    mixtures: dict[str, list[ReferenceSet]] = {
        'real': list(laboratory.sets),
        'rendered': [rendered(laboratory, alike(model)) for model in laboratory.models]}
    cases: list[dict[str, Any]] = []
    for name, sets in mixtures.items():
        if len(sets) < 2:
            cases.append({'missing': f'{name}: fewer than two objects to mix'})
            continue
        laboratory.tell(f'mixed: {name}')
        case = run_apart(job_of(laboratory, sets, laboratory.seed), coarse=True)
        cases.append(kept(case, mixture=name, set=' + '.join(case['datasets'])))
    return cases


def measured(cases: Sequence[Case]) -> list[Case]:
    """Leave out lines that say what is missing."""
    return [case for case in cases if 'missing' not in case]


def show(cases: Sequence[Case]) -> str:
    """Return the errors of each object, the paper's below; then each session."""
    found = measured(cases)
    rows: list[list[object]] = []
    for case in found:
        for grown, one in zip(case['coarse']['objects'], case['objects'], strict=True):
            rows.append([
                f'{one["label"]} ({case["mixture"]})', percent(one['placed'], one['views']),
                grown['mean_rotation_deg'], grown['mean_translation_dres'],
                one['mean_rotation_deg'], one['mean_translation_dres'], one['residual_dres']])
    for name, views, *errors in PAPER:
        rows.append([f'{name} (paper)', percent(views, views), *errors, None])
    sessions = [[
        case['mixture'], len(case['objects']), len(case['shapes']),
        percent(case['placed'], case['views']), faults(case), case['attempts'], case['seconds'],
        round(case['peak_rss_mib'])] for case in found]
    sessions.append(['paper', 4, 4, percent(75, 75), *(None for _ in range(4))])
    return '\n'.join([
        table(
            ['object', 'registered', 'coarse deg', 'dres', 'fine deg', 'dres', 'residual'], rows),
        table(['session', 'objects', 'shapes', 'registered', 'wrong, merges, splits',
               'registrations', 's', 'MiB'], sessions)])


def notes(cases: Sequence[Case]) -> list[str]:
    """Say what is missing, and how the rendered objects were made alike."""
    said = [case['missing'] for case in cases if 'missing' in case]
    if any(case['mixture'] == 'rendered' for case in measured(cases)):
        said.append(
            'The meshes of the rendered views are scaled to one size, so that size does not tell '
            'the objects apart.')
    return said


EXPERIMENT = Experiment(
    'table5', 'Table V: all objects mixed',
    'All views in one session, in a random order, as Table III else. *Shapes*: objects found.',
    run, show, notes=notes)
