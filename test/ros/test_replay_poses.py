# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Station and replay in two processes, in lock-step. Truth: what `rops replay` writes, byte by byte.

But for the names of views: the station cannot know how its topics were called when recorded.
"""

import json
import os
from pathlib import Path

import pytest
from reference.runs import BARE

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from ros.harness import ROOT, station, wait_for  # noqa: E402, I100
from ros.listener import replay  # noqa: E402
from ros_rops.cli.main import main  # noqa: E402
from ros_rops.recordings.frames import frame_view, read_frames  # noqa: E402
from ros_rops.recordings.mcap_files import create_mcap  # noqa: E402

BAGS = ROOT / 'bags'
BEAR = Path(os.environ.get('ROPS_DATA', ROOT.parent / 'shared' / 'data')).parent / (
    'recordings/bear_d435')


def by_command(recording: Path, folder: Path, *options: str) -> str:
    assert main(['replay', str(recording), '--out', str(folder), *BARE, *options]) == 0
    return (folder / 'poses.json').read_text()


def by_nodes(recording: Path, folder: Path, **parameters: object) -> str:
    """Let the station hear a recording, and return the poses that it saves."""
    ours = {name.replace('__', '.'): value for name, value in parameters.items()}
    theirs = {name: ours.pop(name) for name in ('topics', 'namespace') if name in ours}
    namespace = theirs.pop('namespace', '/lock_step')
    given = {'output.picture': False, **ours}
    running = station(
        folder, given, remap={'__ns': namespace}, node=f'{namespace}/rops_registration')
    with running as (node, _):
        with replay(namespace, recording=recording, finish=True, save=True, **theirs) as player:
            assert player.wait(200) == 0, player.output
        assert 'could not be' not in player.output
        path = wait_for(lambda: next(folder.glob('run_*/poses.json'), None), 'a saved run', 100)
    assert 'ERROR' not in node.output
    return path.read_text()


def renamed(poses: str, like: str) -> str:
    """Return the poses with the names that the views have in others, which came as these did."""
    for name, other in zip(names(poses), names(like), strict=True):
        poses = poses.replace(name, other)  # reasons name views too
    return poses


def names(poses: str) -> list[str]:
    return [view['name'] for view in json.loads(poses)['views']]


def test_views_with_facts_give_the_same_on_every_run(tmp_path):
    recording = tmp_path / 'views.mcap'
    with create_mcap(recording) as mcap:
        for k, frame in enumerate(read_frames(BAGS / 'demo.mcap')):
            if k in (1, 4, 5, 6, 7, 8):
                mcap.add_view(frame_view(frame).view)
    truth = by_command(recording, tmp_path / 'truth')
    assert len(json.loads(truth)['objects']) == 2
    # The facts give views the names that they were recorded with.
    assert by_nodes(recording, tmp_path / 'first') == truth
    assert by_nodes(recording, tmp_path / 'second', threads=1) == truth


@pytest.mark.slow
def test_clouds_of_two_objects(tmp_path):
    truth = by_command(BAGS / 'demo.mcap', tmp_path / 'truth')
    found = by_nodes(BAGS / 'demo.mcap', tmp_path / 'found')
    assert len(names(found)) == 20
    assert renamed(found, truth) == truth


@pytest.mark.slow
def test_depth_images_of_a_table(tmp_path):
    truth = by_command(BAGS / 'table.mcap', tmp_path / 'truth')
    found = by_nodes(BAGS / 'table.mcap', tmp_path / 'found', input__kind='depth')
    assert len(names(found)) == 24
    assert renamed(found, truth) == truth


def test_a_stream_with_colour_of_which_few_frames_are_taken(tmp_path):
    options = ['--set', 'selection.method=still', '--set', 'prior.plane=true']
    truth = by_command(BAGS / 'turning.mcap', tmp_path / 'truth', *options)
    found = by_nodes(
        BAGS / 'turning.mcap', tmp_path / 'found', input__kind='depth',
        selection__method='still', prior__plane=True)
    assert len(names(found)) >= 5
    assert renamed(found, truth) == truth


@pytest.mark.slow
def test_sensor_poses_of_tf(tmp_path):
    pytest.importorskip('tf2_msgs', reason='no tf2_msgs')
    truth = by_command(
        BAGS / 'handheld.mcap', tmp_path / 'truth', '--set', 'prior.fixed_frame=world')
    found = by_nodes(
        BAGS / 'handheld.mcap', tmp_path / 'found', prior__fixed_frame='world')
    assert renamed(found, truth) == truth


@pytest.mark.slow
@pytest.mark.skipif(not BEAR.exists(), reason=f'no {BEAR}')
def test_a_real_depth_camera_before_a_turntable(tmp_path):
    truth = by_command(BEAR, tmp_path / 'truth')
    found = by_nodes(BEAR, tmp_path / 'found')
    assert len(names(found)) == 8
    assert renamed(found, truth) == truth
