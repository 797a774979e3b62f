# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The ablation. Truth: config/paper.yaml; an engine whose answers are known; counts by hand."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from reference.bench_sets import Script, strip_set
from ros_rops.bench import ablation, ablation_variants
from ros_rops.bench.ablation import chosen_pairs, run_ablation, show_ablation
from ros_rops.bench.ablation_variants import (
    ALONE, CREDULOUS, GROUPS, ON_FEATURES, ON_SEARCH, PAPER, Variant)
from ros_rops.bench.contest import Answer, Contestant
from ros_rops.bench.evaluation import PairTruth
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.settings import derive
from ros_rops.core.config import Config
from ros_rops.core.types import Status
from ros_rops.pipeline.parameters import load_config

PRESET = Path(__file__).parents[2] / 'config' / 'paper.yaml'


def test_everything_as_the_paper_is_the_preset():
    assert derive(Config(), PAPER) == load_config(PRESET)


@pytest.mark.parametrize('variant', [*ON_FEATURES, *ON_SEARCH], ids=lambda one: one.label)
def test_each_variant_changes_something(variant):
    ours = variant.label == 'ours'
    changed = derive(Config(), variant.changes) != Config() or not variant.rays
    assert changed is not ours


def test_what_was_changed_for_a_group_stays_changed():
    seen = []

    def engine(config, threads):
        seen.append(config)
        return Contestant('', lambda view: view, lambda a, b: Answer(Status.REFUSED, None))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ablation_variants, 'engine', engine)
        Variant('x', {'rops.radius_mr': 15.0}).contestant(Config(), ALONE)
    assert seen == [derive(Config(), {**ALONE, 'rops.radius_mr': 15.0})]


def test_views_are_shared_unless_what_prepares_them_changes():
    ours = Variant('ours').preparation()
    assert Variant('', {'matching.neighbours': 1}).preparation() == ours
    assert Variant('', {'rops.radius_mr': 15.0}).preparation() != ours
    assert Variant('', rays=False).preparation() != ours


def test_pairs_without_overlap_are_spread_evenly():
    pairs = [PairTruth(str(k), '', (0.5, 0.9)[k % 2] if k < 20 else 0.05, None) for k in range(80)]
    chosen = [int(pair.name_i) for pair in chosen_pairs(pairs)]
    assert chosen == [*range(0, 20, 2), *range(20, 80, 4)]
    assert len(chosen_pairs(pairs[:22])) == 12


@pytest.mark.parametrize(('overlap', 'status'), [(0.51, Status.PLACED), (0.5, Status.REFUSED)])
def test_accepted_by_overlap_alone(overlap, status):
    def engine(config, threads):
        assert config == derive(Config(), CREDULOUS)
        return Contestant('', lambda view: view, lambda a, b: Answer(
            Status.PLACED, np.eye(4), '', {'overlap_source': overlap}))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ablation_variants, 'engine', engine)
        judged = Variant('', CREDULOUS, by_overlap=True).contestant(Config(), {}).register(1, 2)
    assert judged.status is status
    assert (judged.T_target_source is None) is (status is Status.REFUSED)


@dataclass(frozen=True)
class Told:
    """A variant whose engine is told its answers."""

    label: str
    script: Script
    changes: tuple = ()

    def preparation(self):
        return ()

    def contestant(self, config, changes, *, threads):
        return self.script.contestant()


def test_cases_count_right_and_wrong(monkeypatch):
    # Pairs of overlap 1 (left out), 0.5 and 0.3; three without any.
    dataset = strip_set(starts=(0, 7, 9, 30))
    right = {('view00', 'view07'): 1.0, ('view00', 'view09'): 7.0, ('view00', 'view30'): 9.0,
             ('view07', 'view30'): None, ('view09', 'view30'): None}
    monkeypatch.setattr(ablation, 'GROUPS', {'all': ({}, (
        Told('ours', Script(dataset, right)),
        Told('none', Script(dataset, dict.fromkeys(right)))))})
    ours, none = run_ablation(Laboratory((dataset,), (), Config()))
    assert (ours['right'], ours['pairs'], ours['wrong'], ours['unrelated']) == (1, 2, 2, 3)
    assert ours['right_by_overlap'] == {'0.1-0.3': 0, '0.3-0.6': 1}
    assert (none['right'], none['wrong']) == (0, 0)


def test_table_compares_with_ours():
    case = {
        'group': 'all', 'variant': 'ours', 'dataset': 'a', 'pairs': 3, 'right': 2, 'wrong': 1,
        'unrelated': 5, 'pairs_by_overlap': {'0.1-0.3': 1, '0.3-0.6': 2},
        'right_by_overlap': {'0.1-0.3': 0, '0.3-0.6': 2}, 'seconds': 2.0,
        'seconds_prepare': 1.0}
    cases = [case, {**case, 'dataset': 'b'}, {**case, 'variant': 'other', 'seconds': 3.0},
             {**case, 'variant': 'other', 'dataset': 'b', 'seconds': 7.0, 'right': 3}]
    lines = [[cell.strip() for cell in line.strip('|').split('|')]
             for line in show_ablation(cases).splitlines() if line.startswith('|')]
    assert lines[0] == [
        'all', 'a', 'b', 'together', '0.1-0.3', '0.3-0.6', 'wrong', 'time', 'prepare']
    assert lines[2] == ['ours', '2/3', '2/3', '4/6', '0/2', '4/4', '2/16', '1.00', '1.00']
    assert lines[3][1:4] == ['2/3', '3/3', '5/6']
    assert lines[3][-2] == '2.50'


def test_every_group_begins_with_ours():
    assert all(variants[0].label == 'ours' for _, variants in GROUPS.values())
