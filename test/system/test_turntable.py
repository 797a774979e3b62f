# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A small simulated turntable, from the command to the judgement. Truth: the exact poses."""

import json

from reference.runs import BARE
from ros_rops.cli.main import main


def test_two_objects_recorded_registered_and_judged(tmp_path, capsys):
    bag, run, numbers = tmp_path / 'x.mcap', tmp_path / 'run', tmp_path / 'numbers.json'
    assert main([
        'simulate', 'procedural:blob', 'procedural:bracket', '--out', str(bag), '--views', '7',
        '--step', '30', '--image', '192x144', '--noise', 'structured-light', '--seed', '1']) == 0
    assert main(['register', str(bag), '--out', str(run), *BARE]) == 0
    assert main(['evaluate', str(run), str(tmp_path / 'x_poses.json'),
                 '--json', str(numbers)]) == 0
    found = json.loads(numbers.read_text())
    assert (found['views'], found['placed'], found['wrong_placements']) == (14, 14, 0)
    assert found['wrong_merges'] == found['splits'] == 0
    assert found['mean_rotation_deg'] < 0.1
    assert found['mean_translation_dres'] < 0.2
