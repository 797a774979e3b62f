# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Table II. Truth: one view given twice, whose pose is known; lines written by hand."""

from dataclasses import replace
import json

import numpy as np
from reference.surfaces import bumps, height_view
from ros_rops.bench.experiment import Laboratory
from ros_rops.bench.paper import table2
from ros_rops.bench.rivals.descriptor import Descriptor
from ros_rops.bench.truth import ReferenceSet
from ros_rops.core.config import Config


def twins():
    """Return a set of two equal views."""
    view = height_view(bumps, (45, 48), jitter=0.2)
    views = {name: replace(view, name=name) for name in ('a', 'b')}
    return ReferenceSet('twins', 'm', 'exact', views, dict.fromkeys(views, np.eye(4)), 1.0)


def test_every_descriptor_is_run_and_a_missing_one_named(monkeypatch):
    absent = Descriptor('absent', 'nobody', None, lambda: 'libnothing is not installed')
    place = Descriptor(
        'place', 'nobody',
        lambda mesh, indices, lrfs, unit, threads: mesh.vertices[indices].astype(np.float32))
    monkeypatch.setattr(table2, 'rival_descriptors', lambda radius: (absent, place))
    laboratory = Laboratory((twins(),), (), Config(), threads=1)
    cases = table2.run(laboratory)
    json.dumps(cases)
    assert cases[0] == {'by': 'absent', 'missing': 'libnothing is not installed'}
    assert [(case['by'], case['mode']) for case in cases[1:]] == [
        *((name, mode) for name in ('RoPS', 'place')
          for mode in ('features alone', 'full verification')), *table2.CONTROLS]
    as_paper = table2.run_as_paper(laboratory)[1:]
    assert [(case['by'], case['mode']) for case in as_paper] == [
        ('RoPS', 'as the paper'), ('place', 'as the paper')]
    for case in cases[1:]:
        assert case['pairs'] == case['pairs_by_overlap']['0.6-1.0'] == 1
        assert case['correct_by_overlap'] == {
            '0.1-0.3': 0, '0.3-0.6': 0, '0.6-1.0': case['correct']}
    assert cases[1]['correct'] == 1 and cases[1]['ms_per_keypoint'] > 0
    assert 'absent: libnothing is not installed' in table2.notes(cases)
    assert '1/1' in table2.show(cases)


def line(by, dataset, correct):
    counts = {'0.1-0.3': 0, '0.3-0.6': 0, '0.6-1.0': 10}
    return {
        'set': dataset, 'mode': 'features alone', 'by': by, 'correct': correct, 'pairs': 10,
        'pairs_all': 45, 'pairs_by_overlap': counts,
        'correct_by_overlap': {**counts, '0.6-1.0': correct}, 'wrong_accepted': [['a', 'b']],
        'rotation_deg': 0.1 * correct, 'translation_dres': None, 'seconds_per_pair': 0.5}


def test_sums_means_and_who_is_ahead():
    cases = [line('RoPS', 'x', 9), line('RoPS', 'y', 3), line('SHOT', 'x', 8),
             line('SHOT', 'y', 5)]
    assert table2.notes(cases) == ['features alone, y: SHOT has 2 more than RoPS.']
    ours = next(row for row in table2.show(cases).splitlines() if row.startswith('| RoPS'))
    cells = [cell.strip() for cell in ours.strip('|').split('|')]
    # Degrees: (0.9 of 9 pairs and 0.3 of 3) / 12.
    assert cells[:11] == [
        'RoPS', '9/10', '3/10', '12/20 = 60.0%', '0/0', '0/0', '12/20', '2 of 90', '0.750', '-',
        '-']
    assert cells[-3:] == ['67.610', '0.665', '0.676']
    assert table2.notes(cases[:2]) == [
        'RoPS is the best, or equal to it, on every set and in every mode.']
