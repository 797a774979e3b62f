# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The measures on real scans.

Truth: the pairs by overlap of EVALUATION's table, found by other code; reference poses.
"""

from collections import Counter
from functools import cache
import os
from pathlib import Path

import pytest
from ros_rops.bench.evaluate import evaluate, known_views
from ros_rops.bench.evaluation import evaluate_pairs, overlap_bin, OVERLAP_BINS
from ros_rops.bench.judgement import Placement
from ros_rops.bench.run_folder import Run
from ros_rops.bench.truth import load_dataset

DATA = Path(os.environ.get(
    'ROPS_DATA', Path(__file__).resolve().parents[3] / 'shared' / 'data'))
PAIRS = {
    'bunny': (11, 11, 12), 'dragon_stand': (18, 21, 21), 'chef': (6, 11, 17),
    'parasaurolophus': (6, 8, 16)}


@cache
def load(name):
    if not (DATA / name).is_dir():
        pytest.skip(f'no real scans at {DATA / name} (set ROPS_DATA)')
    return load_dataset(DATA / name)


@pytest.mark.parametrize('name', [
    'bunny', 'parasaurolophus',
    *(pytest.param(name, marks=pytest.mark.slow) for name in ('dragon_stand', 'chef'))])
def test_pairs_by_overlap_are_those_of_the_evaluation(name):
    counts = Counter(overlap_bin(pair.overlap) for pair in evaluate_pairs(load(name)))
    assert tuple(counts[key] for key in OVERLAP_BINS) == PAIRS[name]


def test_the_reference_poses_judge_themselves_right():
    dataset = load('bunny')
    placements = {name: Placement('1', T) for name, T in dataset.T_world_view.items()}
    run = Run('m', dataset.dres, placements, dict.fromkeys(placements, 'placed'), {}, None)
    numbers = evaluate(run, known_views([dataset])).numbers()
    assert (numbers['placed'], numbers['wrong_placements']) == (10, 0)
    assert numbers['max_rotation_deg'] < 1e-5
    # EVALUATION: published poses give 0.206 on the bunny.
    assert numbers['objects'][0]['residual_dres'] == pytest.approx(0.206, abs=0.002)
