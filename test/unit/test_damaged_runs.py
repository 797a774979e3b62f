# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Damaged run folders, full disks, slips. Truth: one sentence, and nothing else is lost."""

import json

import numpy as np
import pytest
from reference.model_runs import make_run
from ros_rops.cli.main import main


@pytest.fixture
def run(tmp_path, monkeypatch):
    for name in ('DISPLAY', 'WAYLAND_DISPLAY'):
        monkeypatch.delenv(name, raising=False)
    make_run(tmp_path / 'run')
    return tmp_path / 'run'


def test_models_are_not_written_over_those_of_another_run(run, tmp_path, capsys):
    make_run(tmp_path / 'other')
    before = {path.name: path.read_bytes() for path in (tmp_path / 'other').iterdir()}
    assert main(['model', str(run), '--out', str(tmp_path / 'other')]) == 2
    assert 'other holds another run' in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in (tmp_path / 'other').iterdir()} == before


def test_a_disk_that_is_full_at_the_end_is_one_sentence(run, monkeypatch, capsys):
    def full(path, text):
        raise OSError(28, 'No space left on device', str(path))

    monkeypatch.setattr('ros_rops.cli.model.replace_file', full)
    assert main(['model', str(run), '--surface', 'none', '--object', '1']) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith('rops model: ') and 'config.yaml: cannot be written (No space' in last


def test_view_names_a_cloud_with_points_that_are_none(run, capsys):
    assert main(['model', str(run), '--surface', 'none', '--object', '0']) == 0
    cloud = run / 'object_0.ply'
    data = cloud.read_bytes()
    at = data.index(b'end_header\n') + 11
    cloud.write_bytes(data[:at] + np.full(1, np.nan).tobytes() + data[at + 8:])
    assert main(['view', str(run), '0', '--color', 'view']) == 2
    assert 'object_0.ply: is damaged' in capsys.readouterr().err


@pytest.mark.parametrize(('name', 'keys', 'value', 'said'), [
    ('metrics.json', ('stage_seconds',), {'pairs': 10 ** 400}, False),
    ('metrics.json', ('machine',), {'python': '\ud800'}, False),
    ('poses.json', ('views', 0, 'fine_residual_mr'), [], False),
    ('poses.json', ('station',), {'axis_found': {'direction': None}}, True)])
def test_a_report_of_damaged_files_lacks_that_part_only(run, name, keys, value, said):
    document = json.loads((run / name).read_text())
    part = document
    for key in keys[:-1]:
        part = part[key]
    part[keys[-1]] = value
    (run / name).write_text(json.dumps(document))
    assert main(['report', str(run)]) == 0
    page = (run / 'report.html').read_text(encoding='utf-8')
    assert page.count('is damaged: this part') == said and '<section id="again">' in page
