# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's preset on a real pair of much overlap; truth: the published poses."""

import os
from pathlib import Path

import pytest
from ros_rops.bench.contest import engine, errors_in, prepare_all, run_pairs
from ros_rops.bench.evaluation import evaluate_pairs
from ros_rops.bench.truth import load_dataset
from ros_rops.pipeline.parameters import load_config

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data'))


def test_preset_registers_the_two_views_of_most_overlap():
    if not (DATA / 'bunny').is_dir():
        pytest.skip(f'no real scans: {DATA / "bunny"} is missing (set ROPS_DATA)')
    dataset = load_dataset(DATA / 'bunny')
    pair = max(evaluate_pairs(dataset), key=lambda one: one.overlap)
    views = {name: dataset.views[name] for name in (pair.name_i, pair.name_j)}
    contestant = engine(load_config(ROOT / 'config' / 'paper.yaml'))
    prepared = prepare_all(contestant, views, lambda text: None)
    record, = run_pairs(contestant, [pair], prepared, errors_in(dataset), lambda text: None)
    assert record.correct, record.reason
    assert record.numbers['overlap'] > 0.5
