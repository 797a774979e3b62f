# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Experiment `peers_descriptor`: RoPS of the same keypoints, ours and PCL's."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ros_rops.bench.experiment import Case, Experiment, Laboratory
from ros_rops.bench.rivals.pcl import pcl_features, pcl_missing
from ros_rops.bench.settings import derive
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.core.keypoints import candidate_keypoints
from ros_rops.core.mesh import build_mesh
from ros_rops.core.rops import describe
from ros_rops.core.types import Ints, RangeMesh

# As ROPSEstimation has them: the paper's frame from all triangles that touch the support, its own
# angles and norm; vertices without a triangle are not sent to it (`rivals.pcl`).
PCL_CONVENTION = {
    'rops.convention': 'pcl', 'lrf.method': 'rops', 'lrf.triangles': 'pcl',
    'rops.loose_vertices': False}
THREADS = (1, 2)
LEAST_ROUNDS = 3
ALIKE = 0.99


def run(laboratory: Laboratory) -> list[dict[str, Any]]:
    """Time both on the first view of every set; PCL missing is a line too."""
    absent = pcl_missing()
    cases: list[dict[str, Any]] = [{'by': 'PCL', 'missing': absent}] if absent else []
    for dataset in laboratory.sets:
        for threads in THREADS:
            laboratory.tell(f'{dataset.name}: RoPS, {threads} threads')
            cases.append(measure(
                dataset, laboratory.config, threads=threads, with_pcl=absent is None,
                rounds=max(LEAST_ROUNDS, laboratory.repeats)))
    return cases


def measure(
    dataset: ReferenceSet, config: Config, *, threads: int, with_pcl: bool, rounds: int
) -> dict[str, Any]:
    """
    Time ours, ours in PCL's convention, and PCL, by turns; medians of the rounds.

    PCL's estimation has one thread: for two, each half of the keypoints has a process of its
    own, and the slower one counts, what both do twice (the search tree) included.
    """
    name, view = next(iter(dataset.views.items()))
    mesh = build_mesh(view, config.mesh)
    keypoints = candidate_keypoints(mesh, config.keypoints)
    alike = derive(config, PCL_CONVENTION)
    ways: dict[str, Callable[[], tuple[float, NDArray[np.float32]]]] = {
        'ours': lambda: ours(mesh, keypoints, config, threads),
        'ours_pcl_convention': lambda: ours(mesh, keypoints, alike, threads)}
    if with_pcl:
        ways['pcl'] = lambda: pcl(mesh, keypoints, config, threads)
    for way in ways.values():
        way()
    found = [{name: way() for name, way in ways.items()} for _ in range(rounds)]
    milliseconds = {
        f'{name}_ms': 1e3 * float(np.median([one[name][0] for one in found])) / len(keypoints)
        for name in ways}
    agreement = agreement_of(
        found[0]['ours_pcl_convention'][1], found[0]['pcl'][1]) if with_pcl else {}
    return {
        'set': dataset.name, 'view': name, 'vertices': len(mesh.vertices),
        'keypoints': len(keypoints), 'radius_mr': config.rops.radius_mr, 'threads': threads,
        'lrf': config.lrf.method, 'rounds': rounds, **milliseconds, **agreement}


def ours(
    mesh: RangeMesh, keypoints: Ints, config: Config, threads: int
) -> tuple[float, NDArray[np.float32]]:
    """Return our seconds for frames and descriptors, neighbour search included, and these."""
    start = time.perf_counter()
    features = describe(mesh, keypoints, config.lrf, config.rops, threads=threads)
    return time.perf_counter() - start, features.descriptors


def pcl(
    mesh: RangeMesh, keypoints: Ints, config: Config, threads: int
) -> tuple[float, NDArray[np.float32]]:
    """Return PCL's seconds for the same, which it counts itself, and its descriptors."""
    radius = config.rops.radius_mr * mesh.resolution
    with ThreadPoolExecutor(threads) as pool:
        parts = list(pool.map(
            lambda some: pcl_features(
                'rops', mesh, some, np.zeros((len(some), 3, 3)), radius, mesh.resolution),
            np.array_split(keypoints, threads)))
    return max(part.seconds for part in parts), np.concatenate(
        [part.descriptors for part in parts])


def agreement_of(mine: NDArray[np.float32], theirs: NDArray[np.float32]) -> dict[str, float]:
    """Return the median correlation of descriptors (K, D) row by row, and the share above 0.99."""
    a, b = (one - one.mean(axis=1, keepdims=True) for one in (
        np.asarray(mine, float), np.asarray(theirs, float)))
    norms = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    each = (a * b).sum(axis=1) / np.where(norms > 0, norms, 1.0)
    return {
        'correlation_median': float(np.median(each)), 'share_alike': float((each > ALIKE).mean())}


def show(cases: Sequence[Case]) -> str:
    """Return the table: microseconds a keypoint, ratios, agreement."""
    rows = []
    for case in cases:
        if 'set' not in case:
            continue
        mine, alike, theirs = (
            case.get(f'{name}_ms') for name in ('ours', 'ours_pcl_convention', 'pcl'))
        rows.append([
            f'{case["set"]}/{case["view"]}', case['keypoints'], case['threads'],
            *(None if one is None else f'{1e3 * one:.1f}' for one in (mine, alike, theirs)),
            *(None if theirs is None else f'{theirs / one:.1f}' for one in (mine, alike)),
            case.get('correlation_median'), case.get('share_alike')])
    return table(
        ['view', 'keypoints', 'threads', 'ours, us', 'in its convention, us', 'PCL, us',
         'PCL / ours', 'PCL / in its', 'correlation', 'above 0.99'], rows)


def notes(cases: Sequence[Case]) -> list[str]:
    """Return what is missing, and which oracle the values are held against."""
    return [
        *(str(case['missing']) for case in cases if 'missing' in case),
        "Values: `test/oracle/test_rops_oracle.py` holds ours to the author's toolbox (within "
        "1e-6) and, in PCL's convention, to stored ones of PCL (correlation above 0.99)."]


DESCRIPTOR = Experiment(
    'peers_descriptor', 'RoPS, against PCL',
    'Microseconds a keypoint for frame, descriptor and neighbour search on the first view of '
    "each set, same mesh, same keypoints, same radius, by turns, medians. PCL's `ROPSEstimation` "
    'has one thread; for two, each half of the keypoints has a process of its own. *ours*: the '
    "engine's frame and convention; *in its convention*: ours with the paper's frame and PCL's "
    "triangle rule, angles and norm; *correlation*: of these descriptors with PCL's, median over "
    'the keypoints, and the share above 0.99.',
    run, show, notes=notes)
