# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Case `descriptor`: how often the nearest feature of the other view is the right one."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from ros_rops.bench.descriptor import measure_descriptor
from ros_rops.bench.evaluation import evaluate_pairs, overlap_bin, OVERLAP_BINS, PairTruth
from ros_rops.bench.scores import share
from ros_rops.bench.settings import add_common_arguments, config_of, load_all, report, teller
from ros_rops.bench.table import table
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config
from ros_rops.core.mesh import build_mesh
from ros_rops.core.rops import compute_features
from ros_rops.core.types import Bools, Features, Floats
from scipy.spatial import cKDTree

RIGHT_DRES = 3.0


@dataclass(frozen=True, slots=True)
class Matches:
    """
    Nearest features of one view's K keypoints in another view.

    Parameters
    ----------
    right : (K,) bool
        The nearest feature lies within 3 dres of where the keypoint truly is.
    possible : (K,) bool
        Some feature of the other view does.
    ratio : (K,) float64
        Descriptor distance to the nearest over that to the second nearest.
    """

    right: Bools
    possible: Bools
    ratio: Floats


def match(source: Features, target: Features, T: Floats, dres: float) -> Matches:
    """
    Match the features of two views and tell right matches from wrong ones.

    Parameters
    ----------
    source, target : Features
        The target has at least two.
    T : (4, 4) float64
        Reference `T_target_source`.
    dres : float
    """
    true_place = source.positions @ T[:3, :3].T + T[:3, 3]
    distance, nearest = cKDTree(target.descriptors).query(source.descriptors, k=2, workers=-1)
    off = np.linalg.norm(target.positions[nearest[:, 0]] - true_place, axis=1)
    closest, _ = cKDTree(target.positions).query(true_place)
    second = np.where(distance[:, 1] > 0, distance[:, 1], 1.0)
    return Matches(
        right=off <= RIGHT_DRES * dres, possible=closest <= RIGHT_DRES * dres,
        ratio=distance[:, 0] / second)


def area_under_precision_recall(matches: Matches) -> float | None:
    """
    Area under precision over recall as the ratio test loosens, None without a possible match.

    Recall is right matches over possible ones. The curve is taken as steps (average precision).
    """
    possible = int(matches.possible.sum())
    if not possible:
        return None
    right = matches.right[np.argsort(matches.ratio, kind='stable')]
    precision = np.cumsum(right) / np.arange(1, len(right) + 1)
    return float(precision[right].sum() / possible)


def joined(parts: Sequence[Matches]) -> Matches:
    """Return the matches of several pairs as one."""
    return Matches(
        right=np.concatenate([part.right for part in parts] or [np.zeros(0, bool)]),
        possible=np.concatenate([part.possible for part in parts] or [np.zeros(0, bool)]),
        ratio=np.concatenate([part.ratio for part in parts] or [np.zeros(0)]),
    )


def quality(matches: Matches) -> dict[str, Any]:
    """Return the numbers of some matches."""
    right = int(matches.right.sum())
    return {
        'keypoints': len(matches.right),
        'possible': int(matches.possible.sum()),
        'right': right,
        'right_of_all': share(right, len(matches.right)),
        'right_of_possible': share(right, int(matches.possible.sum())),
        'area_under_precision_recall': area_under_precision_recall(matches),
    }


def run_set(
    dataset: ReferenceSet, pairs: Sequence[PairTruth], config: Config, *,
    threads: int, tell: Callable[[str], None],
) -> dict[str, Any]:
    """Describe all views of a set, match the evaluated pairs both ways, count right matches."""
    features, milliseconds = {}, []
    for number, (name, view) in enumerate(dataset.views.items()):
        tell(f'{dataset.name}: view {number + 1} of {len(dataset.views)}')
        mesh = build_mesh(view, config.mesh)
        features[name] = compute_features(
            mesh, config, resolution=dataset.dres, threads=threads)
        if len(features[name].indices):
            measured = measure_descriptor(mesh, features[name].indices, config, threads, rounds=1)
            milliseconds.append(float(measured['ms_per_keypoint']))
    bins: dict[str, list[Matches]] = {key: [] for key in OVERLAP_BINS}
    for pair in pairs:
        key = overlap_bin(pair.overlap)
        if key is None or pair.T_j_i is None:
            continue
        i, j = features[pair.name_i], features[pair.name_j]
        if min(len(i.positions), len(j.positions)) >= 2:
            bins[key].append(match(i, j, pair.T_j_i, dataset.dres))
            bins[key].append(match(j, i, np.linalg.inv(pair.T_j_i).astype(float), dataset.dres))
    return {
        'case': 'descriptor', 'dataset': dataset.name,
        'keypoints_per_view': float(np.mean([len(f.positions) for f in features.values()])),
        **quality(joined([one for parts in bins.values() for one in parts])),
        'by_overlap': {key: quality(joined(parts)) for key, parts in bins.items()},
        'ms_per_keypoint': float(np.mean(milliseconds)) if milliseconds else None,
    }


def descriptor_table(cases: Sequence[Mapping[str, Any]]) -> str:
    """Return the table that `rops bench descriptor` prints: right of possible matches."""
    rows = [
        [case['dataset'], case['keypoints_per_view'], case['right_of_possible'],
         *(case['by_overlap'][key]['right_of_possible'] for key in OVERLAP_BINS),
         case['area_under_precision_recall'], case['ms_per_keypoint']]
        for case in cases
    ]
    return table(
        ['dataset', 'keypoints', 'right', *OVERLAP_BINS, 'AUC PR', 'ms/keypoint'], rows)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench descriptor`."""
    add_common_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Run `rops bench descriptor`; returns the exit code."""
    tell = teller(args)
    config = config_of(args)
    cases = [
        run_set(one, evaluate_pairs(one), config, threads=args.threads, tell=tell)
        for one in load_all(args.datasets, tell)
    ]
    report(args, cases, descriptor_table(cases))
    return 0
