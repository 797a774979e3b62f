# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Table VI: models made of the registered views, against reference meshes."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.model import measure
from ros_rops.bench.model_cases import dataset_case, engine_case, ModelCase
from ros_rops.bench.model_distance import Triangles
from ros_rops.bench.model_run import ModelJob, OURS
from ros_rops.bench.paper.many_views import rendered
from ros_rops.bench.table import table
from ros_rops.core.errors import ModelError

# The mesh that a set is judged against: in the world of its poses.
REFERENCES: Mapping[str, str] = {
    'bunny': 'bun_zipper', 'dragon_stand': 'dragon_vrip_res2', 'chef': 'chef_simplified'}
# Meshes whose rendered views are judged: no real views of theirs are at hand.
RENDERED = ('armadillo',)
# Accuracy in dres, completeness in percent.
PAPER: Mapping[str, tuple[float, float]] = {
    'chef': (0.6231, 100.0), 'chicken': (1.1004, 100.0), 'parasaurolophus': (0.6942, 99.66),
    't-rex': (0.9485, 99.97), 'armadillo': (1.7977, 91.12), 'bunny': (1.4291, 99.88),
    'dragon_stand': (1.1545, 98.46), 'happy buddha': (0.7209, 100.0)}
SAMPLES = 50_000


def model_cases(laboratory: Laboratory) -> Iterator[tuple[str, ModelCase | str]]:
    """Give every object of the paper that we have with its case, or why there is none."""
    meshes = {model.name: model for model in laboratory.models}
    for dataset in laboratory.sets:
        mesh = meshes.get(REFERENCES.get(dataset.name, ''))
        if mesh is None:
            wanted = REFERENCES.get(dataset.name)
            yield dataset.name, (
                f'{dataset.name}: no reference mesh'
                + (f' ({wanted}, by --mesh)' if wanted else ' exists'))
        else:
            yield dataset.name, dataset_case(dataset, Triangles(mesh.vertices, mesh.faces))
    for name in RENDERED:
        if name in meshes:
            reference = Triangles(meshes[name].vertices, meshes[name].faces)
            yield name, dataset_case(rendered(laboratory, meshes[name]), reference)
        else:
            yield name, f'{name}: no mesh to render views from (--mesh)'


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Register each set, make its surface, judge it."""
    cases: list[dict[str, Any]] = []
    for name, given in model_cases(laboratory):
        if isinstance(given, str):
            cases.append({'set': name, 'missing': given})
            continue
        laboratory.tell(f'{name}: registering, making the model')
        try:
            case = engine_case(given, laboratory.config, laboratory.threads)
        except ModelError as error:
            cases.append({'set': name, 'missing': str(error)})
            continue
        job = ModelJob(
            case.views, case.dres, laboratory.config, laboratory.threads, laboratory.repeats)
        made = measure(case, OURS['volume'], job, samples=SAMPLES)
        cases.append({'set': name, 'given': len(given.views), **made})
    return cases


def show(cases: Sequence[Case]) -> str:
    """Return accuracy and completeness, the paper's beside; the objects that only it has."""
    rows: list[list[object]] = []
    for case in cases:
        stated = PAPER.get(case['set'], (None, None))
        if case.get('error') or 'missing' in case:
            rows.append([case['set'], *(None for _ in range(7)), *stated, None, None])
            continue
        score = case['score']
        rows.append([
            case['set'], f'{case["views"]}/{case["given"]}', score['accuracy'],
            case['score_icp']['accuracy'], case['floor'], _percent(score['completeness']),
            _percent(score['completeness_seen']), score['median'], *stated, case['seconds_warm'],
            round(case['peak_rss_mib'])])
    ours = {case['set'] for case in cases}
    for name, paper in PAPER.items():
        if name not in ours:
            rows.append([name, *(None for _ in range(7)), *paper, None, None])
    return table(
        ['object', 'views', 'accuracy, dres', 'after ICP', 'points', 'complete, %', 'of seen, %',
         'median', 'paper: accuracy', 'complete, %', 's', 'MiB'], rows)


def _percent(share: float | None) -> float | None:
    return None if share is None else 100 * share


def notes(cases: Sequence[Case]) -> list[str]:
    """Say what is missing or failed."""
    said = [case['missing'] for case in cases if 'missing' in case]
    return said + [f'{case["set"]}: {case["error"]}' for case in cases if case.get('error')]


EXPERIMENT = Experiment(
    'table6', 'Table VI: models',
    "Views registered by the engine, carried to the reference's world as a whole, surface from "
    'signed distances. *Accuracy*: 90% of the model lies so near to the reference; *after ICP*: '
    'once it was laid onto it; *points*: of the scans themselves, the floor. *Complete*: of the '
    'reference within 2 dres of the model; *of seen*: of what the scans saw. armadillo: 24 '
    'rendered views from around, which see neither soles nor crown from below and above; the '
    "paper's are real scans.",
    run, show, notes=notes)
