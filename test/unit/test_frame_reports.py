# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Files of frames and what is said of them; truth: the segmentation that was written."""

from dataclasses import replace
import json

import numpy as np
import pytest
from reference.stations import Box, Post, shoot
from ros_rops.core.config import SegmentationConfig
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.core.frame import Frame
from ros_rops.reporting.explain import explain
from ros_rops.reporting.frame_text import draw_record, frame_text
from ros_rops.reporting.frames import (
    file_stem, frame_document, frame_names, read_frame, write_frame)
from ros_rops.segmentation.result import Label
from ros_rops.segmentation.segment import segment

PNG = b'\x89PNG\r\n'


@pytest.fixture(scope='module')
def cut():
    shot = shoot(
        [Post(-0.09, 0, 0.035, 0.09), Box((0.04, -0.04, 0), (0.1, 0.03, 0.07))], noise=0.004,
        lost=0.02, wall=0.3, name='/camera/points@17')
    return segment(shot.frame, SegmentationConfig())


def small_run(folder, names):
    """Write the two files of a run that `explain` reads."""
    views = [{'name': name, 'status': 'pending', 'object': None, 'reason': 'why not'}
             for name in names]
    (folder / 'poses.json').write_text(json.dumps({'views': views}), encoding='utf-8')
    (folder / 'trace.json').write_text('{"attempts": []}', encoding='utf-8')


def test_what_is_written_is_read(cut, tmp_path):
    path = write_frame(tmp_path / 'frames', cut)
    assert path.with_suffix('.png').read_bytes().startswith(PNG)
    record = read_frame(tmp_path / 'frames', '/camera/points@17')
    np.testing.assert_array_equal(record.labels, cut.labels)
    np.testing.assert_array_equal(record.objects, cut.objects)
    assert record.document == frame_document(cut)
    distance = np.linalg.norm(cut.frame.points, axis=-1)
    np.testing.assert_array_equal(np.isnan(record.depth), np.isnan(distance))
    assert np.nanmax(np.abs(record.depth - distance)) < 2e-4 * np.ptp(record.depth[
        np.isfinite(record.depth)])
    assert frame_names(tmp_path / 'frames') == ['/camera/points@17']
    assert read_frame(tmp_path / 'frames', 'other') is None


def test_every_kind_of_frame_is_drawn(tmp_path):
    cloud = np.random.default_rng(0).normal(size=(400, 3)) + np.array([0, 0, 5])
    for k, points in enumerate((cloud, cloud - 5, np.zeros((0, 3)), np.full((4, 5, 3), np.nan),
                                np.ones((1, 1, 3)), np.ones((3, 2000, 3)), np.ones((7, 3)))):
        path = write_frame(tmp_path, segment(Frame(f'f{k}', points), SegmentationConfig()))
        assert path.with_suffix('.png').read_bytes().startswith(PNG)
        assert read_frame(tmp_path, f'f{k}').labels.shape == points.shape[:-1]


def test_names_of_files_differ_and_stay_within_the_folder():
    names = ['a', '/a', 'a/', 'a b', 'a_b', '../a', '..', '', '/', 'A' * 300, 'A' * 301, 'ä']
    stems = [file_stem(name) for name in names]
    assert len(set(stems)) == len(stems)
    assert all(stem and '/' not in stem and not stem.startswith('.') for stem in stems)
    assert max(map(len, stems)) < 140


def test_text_says_why_points_were_dropped(cut):
    text = frame_text(frame_document(cut))
    assert f'{cut.labels.size} points' in text
    for label in (Label.KEPT, Label.PLANE, Label.HOLE):
        share = f'{100 * cut.counts[label] / cut.labels.size:.2f}%'
        assert f'  {cut.counts[label]}' in text
        assert share in text
    assert 'supporting plane: ' in text
    assert 'view /camera/points@17/1: ' in text
    with pytest.raises(InputError, match='is not a frame'):
        frame_text({'name': 'x'})


def test_explain_tells_of_the_frame_of_a_view(cut, tmp_path):
    write_frame(tmp_path / 'frames', cut, picture=False)
    lost = replace(cut, frame=replace(cut.frame, name='empty@1'), views=())
    write_frame(tmp_path / 'frames', lost, picture=False)
    small_run(tmp_path, ['/camera/points@17/0', '/camera/points@17/1', 'scan.ply'])
    text = explain(tmp_path, ['17/1'], tmp_path / 'picture.png')
    assert 'on the supporting plane' in text
    assert '/camera/points@17/1: pending' in text
    assert (tmp_path / 'picture.png').read_bytes().startswith(PNG)
    assert 'on the supporting plane' in explain(tmp_path, ['empty@1'])
    assert 'supporting plane' not in explain(tmp_path, ['scan.ply'])
    with pytest.raises(ParameterError, match='not cut from a frame'):
        explain(tmp_path, ['scan.ply'], tmp_path / 'x.png')
    with pytest.raises(ParameterError, match='one VIEW'):
        explain(tmp_path, [], tmp_path / 'x.png')
    with pytest.raises(ParameterError, match=r'\.png'):
        explain(tmp_path, ['17/1'], tmp_path / 'picture.jpg')


@pytest.mark.parametrize('word', ['skipped', 'bad'])
def test_explain_says_why_a_frame_was_left_out(tmp_path, word):
    small_run(tmp_path, ['scan.ply'])
    (tmp_path / 'frames.json').write_text(json.dumps({'frames': [
        {'name': 'scan.ply', 'word': 'taken', 'reason': ''},
        {'name': '/camera/points@3', 'word': word, 'reason': 'the scene moves'}]}))
    assert explain(tmp_path, ['/camera/points@3']) == (
        f'/camera/points@3\n  {word}: the scene moves\n')
    with pytest.raises(ParameterError, match='nothing was cut.*the scene moves'):
        explain(tmp_path, ['/camera/points@3'], tmp_path / 'x.png')
    assert 'scan.ply: pending' in explain(tmp_path, ['scan.ply'])


def test_unreadable_and_unwritable_files_are_named(cut, tmp_path):
    path = write_frame(tmp_path, cut, picture=False)
    record = read_frame(tmp_path, cut.frame.name)
    path.with_suffix('.npz').write_bytes(b'PK\x03\x04 torn')
    with pytest.raises(InputError, match='camera_points'):
        read_frame(tmp_path, cut.frame.name)
    path.write_text('{', encoding='utf-8')
    with pytest.raises(InputError, match='camera_points'):
        frame_names(tmp_path)
    (tmp_path / 'file').write_text('', encoding='utf-8')
    with pytest.raises(InputError, match='cannot be written'):
        write_frame(tmp_path / 'file', cut)
    with pytest.raises(InputError, match='cannot be written'):
        draw_record(tmp_path / 'none' / 'x.png', record)
