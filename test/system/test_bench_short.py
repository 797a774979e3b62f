# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The short benchmark against the stored one: nothing right is lost, nothing wrong is new.

Truth: exact poses of rendered views, and test/baseline/short.json, which `rops bench short --json`
wrote; a change that is meant stores it anew.
"""

from pathlib import Path

from ros_rops.bench.__main__ import main

BASELINE = Path(__file__).resolve().parents[1] / 'baseline' / 'short.json'


def test_nothing_is_worse_than_what_is_stored(capsys, tmp_path):
    code = main(['short', '--against', str(BASELINE), '--json', str(tmp_path / 'short.json')])
    said = capsys.readouterr().out
    assert code == 0, f'{said}\nif that is meant: rops bench short --json {BASELINE.name}'
    assert 'worse 0' in said
