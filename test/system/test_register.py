# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops register`, files to run folder. Truth: the demo's exact poses; files broken by hand."""

import json
from pathlib import Path

from meta.tree import ROOT
import numpy as np
import pytest
from reference.runs import BARE

from ros_rops.bench.evaluate import evaluate_run
from ros_rops.cli.main import main
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.writers import write_view

pytest.importorskip('ros_rops.pipeline.session', reason='no session yet')

BAGS = ROOT / 'bags'


def _views(count: int) -> list:
    """Return the first `count` views of the demo's first object."""
    truth = json.loads((BAGS / 'demo_poses.json').read_text(encoding='utf-8'))
    outcomes = find_views([BAGS / 'demo.mcap'])[0].views()
    label = next(iter(truth['objects'].values()))
    return [
        outcome.view for outcome in outcomes if truth['objects'][outcome.view.name] == label
    ][:count]


@pytest.fixture(scope='module')
def good(tmp_path_factory) -> Path:
    """Return a folder of sound views."""
    folder = tmp_path_factory.mktemp('good')
    for k, view in enumerate(_views(4)):
        write_view(folder / f'view{k}.ply', view)
    return folder


def _poses(folder: Path) -> dict:
    return json.loads((folder / 'poses.json').read_text(encoding='utf-8'))


@pytest.mark.slow
def test_demo_is_registered_as_it_was_rendered(tmp_path, capsys):
    assert main(['demo', '--out', str(tmp_path / 'demo')]) == 0
    numbers = evaluate_run(tmp_path / 'demo', [BAGS / 'demo_poses.json']).numbers()
    assert (numbers['placed'], numbers['views']) == (20, 20)
    assert numbers['wrong_placements'] == numbers['wrong_merges'] == numbers['splits'] == 0
    assert '20 of 20 views placed in 2 objects' in capsys.readouterr().out
    for name in (
            'object_0.ply', 'object_1_surface.ply', 'object_1_residuals.ply', 'config.yaml',
            'metrics.json', 'quality.json', 'picture.png', 'report.html'):
        assert (tmp_path / 'demo' / name).stat().st_size > 0
    assert main(['explain', str(tmp_path / 'demo')]) == 0


@pytest.mark.slow
def test_poses_are_the_same_bytes_for_any_thread_count(good, tmp_path):
    found = set()
    for k, threads in enumerate(('1', '2', '3', '2')):
        out = tmp_path / f'run{k}'
        words = ['register', str(good), '--out', str(out), '--threads', threads, *BARE]
        assert main(words) == 0
        found.add((out / 'poses.json').read_bytes())
    assert len(found) == 1


def test_bad_files_among_good_ones_are_refused_and_lose_nothing(good, tmp_path):
    mixed = tmp_path / 'mixed'
    mixed.mkdir()
    for path in good.iterdir():
        (mixed / path.name).write_bytes(path.read_bytes())
    whole = (good / 'view0.ply').read_bytes()
    (mixed / 'bad_cut.ply').write_bytes(whole[:len(whole) // 2])
    (mixed / 'bad_kind.pcd').write_bytes(whole)
    (mixed / 'bad_empty.ply').write_bytes(b'')
    np.savetxt(mixed / 'bad_nan.xyz', np.full((50, 3), np.nan))
    np.savetxt(mixed / 'bad_two.xyz', np.eye(3)[:2])
    np.savetxt(mixed / 'bad_same.xyz', np.ones((500, 3)))
    code = main(['register', str(mixed), '--out', str(tmp_path / 'run'), *BARE])
    assert code == 0
    poses = _poses(tmp_path / 'run')
    words = {view['name']: view for view in poses['views']}
    assert set(words) == {path.name for path in mixed.iterdir()}
    for name, view in words.items():
        if name.startswith('bad_'):
            assert view['status'] == 'refused' and view['object'] is None, name
            assert view['reason'] and str(tmp_path) not in view['reason'], name
    alone = tmp_path / 'alone'
    assert main(['register', str(good), '--out', str(alone), *BARE]) == 0
    assert poses['objects'] == _poses(alone)['objects']


def test_nothing_placed_ends_with_1(tmp_path):
    (tmp_path / 'in').mkdir()
    np.savetxt(tmp_path / 'in' / 'two.xyz', np.eye(3)[:2])
    out = tmp_path / 'run'
    assert main(['register', str(tmp_path / 'in'), '--out', str(out), *BARE]) == 1
    assert [view['status'] for view in _poses(out)['views']] == ['refused']


def test_inputs_that_are_not_there_end_with_2_before_anything_is_written(tmp_path, capsys):
    out = tmp_path / 'run'
    assert main(['register', str(tmp_path / 'none'), '--out', str(out)]) == 2
    assert 'none' in capsys.readouterr().err and not out.exists()
