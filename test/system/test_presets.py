# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The presets in config/. Truth: the dataclasses of parameters, exact poses of recordings."""

import json
from pathlib import Path
import re

from meta.tree import name, ROOT
import pytest
from reference.runs import BARE
from ros_rops.cli.main import main
from ros_rops.core.config import Config
from ros_rops.core.node_config import NodeConfig
from ros_rops.pipeline.parameters import configs_of, load_config, parse_parameters

FILES = sorted((ROOT / 'config').glob('*.yaml'))
PRESETS = [path for path in FILES if path.stem not in ('default', 'paper')]
LINE = re.compile(r' +(?P<leaf>[a-z_0-9]+): \S+$')


def test_the_presets_are_those_that_the_launch_file_names():
    text = (ROOT / 'launch' / 'station.launch.py').read_text(encoding='utf-8')
    assert len(PRESETS) == 4
    assert all(re.search(rf'\b{path.stem}\b', text) for path in PRESETS)


@pytest.mark.parametrize('path', FILES, ids=name)
def test_it_is_valid_for_the_node_and_for_the_command(path):
    flat = parse_parameters(path.read_text(encoding='utf-8'))
    engine, node = configs_of(flat)
    assert load_config(path) == engine
    found = {**engine.to_flat(), **node.to_flat()}
    for key, value in flat.items():
        assert found[key] == value
        # Of the same type as ROS declares it: 1 for 1.0 is refused by a node.
        assert type(found[key]) is type(value), key


@pytest.mark.parametrize('path', PRESETS, ids=name)
def test_every_parameter_is_explained(path):
    lines = path.read_text(encoding='utf-8').splitlines()
    values = [k for k, line in enumerate(lines) if LINE.match(line)]
    assert len(values) == len(parse_parameters('\n'.join(lines)))
    alone = [lines[k] for k in values if not lines[k - 1].lstrip().startswith('#')]
    # near_m and far_m share a sentence; all else has its own.
    assert [LINE.match(line)['leaf'] for line in alone] in ([], ['far_m'])


@pytest.mark.parametrize('path', PRESETS, ids=name)
def test_it_sets_something_of_the_node_and_something_of_the_engine(path):
    engine, node = configs_of(parse_parameters(path.read_text(encoding='utf-8')))
    assert engine != Config() and node != NodeConfig()


def _numbers(tmp_path: Path, recording: Path, preset: str, *more: str) -> dict:
    run, numbers = tmp_path / 'run', tmp_path / 'numbers.json'
    assert main([
        'replay', str(recording), '--out', str(run), *BARE, '--config',
        str(ROOT / 'config' / f'{preset}.yaml'), *more]) == 0
    poses = recording.with_name(f'{recording.stem}_poses.json')
    main(['evaluate', str(run), str(poses), '--json', str(numbers)])
    return json.loads(numbers.read_text())


@pytest.mark.parametrize(('preset', 'more', 'least'), [
    ('turntable', [], 6),
    ('handheld', [], 6),
    ('kinect', ['--set', 'selection.method=still'], 6),
])
def test_a_turning_object_is_placed(tmp_path, preset, more, least):
    found = _numbers(tmp_path, ROOT / 'bags' / 'turning.mcap', preset, *more)
    assert found['placed'] >= least and found['wrong_placements'] == 0


def test_structured_light_is_placed(tmp_path):
    recording = tmp_path / 'scans.mcap'
    assert main([
        'simulate', 'procedural:blob', '--table', '--views', '4', '--step', '30', '--in-order',
        '--image', '320x240', '--noise', 'structured-light', '--seed', '3',
        '--out', str(recording)]) == 0
    found = _numbers(tmp_path, recording, 'structured_light')
    assert found['placed'] >= 3 and found['wrong_placements'] == 0
