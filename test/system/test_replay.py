# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops replay`. Truth: the same views from files, the same run again, what was recorded."""

from dataclasses import replace
import json

import numpy as np
import pytest
from reference.runs import BARE, result, unfinish, words
from reference.streams import frames, record
from ros_rops.cli.main import main
from ros_rops.recordings.sources import find_views
from ros_rops.recordings.writers import write_view


def test_replayed_five_times_it_is_the_same_bytes(recording, whole, tmp_path):
    for threads in '12121':
        assert main(words(
            recording, tmp_path / 'run', '--threads', threads, '--overwrite')) == 0
        assert result(tmp_path / 'run') == whole.result


def test_registering_the_same_views_from_files_gives_the_same(whole, tmp_path):
    folder = tmp_path / 'views'
    folder.mkdir()
    names = []
    for outcome in find_views([whole.out / 'journal.mcap'])[0].views():
        view = outcome.view
        names.append(view.name)
        write_view(folder / f'{view.stamp_ns}.ply', replace(view, units='m'))
    out = tmp_path / 'run'
    assert main(['register', str(folder), '--out', str(out), *BARE, '--units', 'm']) == 0
    expected, found = json.loads(whole.result['poses.json']), json.loads(
        (out / 'poses.json').read_text(encoding='utf-8'))
    for one, other in zip(expected['objects'], found['objects'], strict=True):
        assert [view['T_object_view'] for view in one['views']] == [
            view['T_object_view'] for view in other['views']]
    # And from the journal, which is a recording of views, with their names too.
    assert main(['register', str(whole.out / 'journal.mcap'), '--out', str(out), *BARE,
                 '--overwrite']) == 0
    assert (out / 'poses.json').read_bytes() == whole.result['poses.json']


def test_the_words_on_frames_and_explain(whole, capsys):
    content = json.loads(whole.result['frames.json'])
    counts = content['counts']
    assert (counts['read'], counts['taken'], counts['skipped'], counts['bad']) == (12, 4, 8, 0)
    assert sum(counts['reasons']['skipped'].values()) == 8
    assert len(content['frames']) == 12 and all(item['reason'] for item in content['frames'])
    metrics = json.loads((whole.out / 'metrics.json').read_text(encoding='utf-8'))
    assert metrics['frames'] == counts and metrics['journal'] == 'whole'
    assert main(['explain', str(whole.out)]) == 0
    assert 'points@' in capsys.readouterr().out


def test_files_are_refused_by_replay(tmp_path, capsys):
    (tmp_path / 'a.xyz').write_text('0 0 1\n', encoding='utf-8')
    assert main(['replay', str(tmp_path / 'a.xyz'), '--out', str(tmp_path / 'run')]) == 2
    assert 'is no recording' in capsys.readouterr().err


def test_an_input_that_would_be_written_over_is_refused(whole, tmp_path, capsys):
    journal = tmp_path / 'journal.mcap'
    journal.write_bytes((whole.out / 'journal.mcap').read_bytes())
    for more in ([], ['--overwrite']):
        assert main(['replay', str(journal), '--out', str(tmp_path), *more]) == 2
        assert 'journal.mcap: is an input' in capsys.readouterr().err
    journal.rename(tmp_path / 'other.mcap')
    journal.write_bytes(b'of somebody')
    assert main(['replay', str(tmp_path / 'other.mcap'), '--out', str(tmp_path)]) == 2
    assert 'of no run' in capsys.readouterr().err and journal.read_bytes() == b'of somebody'


def test_one_topic_may_be_named_and_a_wrong_one_is_said(recording, whole, tmp_path):
    out = tmp_path / 'run'
    assert main(words(recording, out, '--topic', '/camera/points')) == 0
    assert result(out) == whole.result
    assert main(words(recording, out, '--topic', '/nothing')) == 1
    [view] = json.loads((out / 'poses.json').read_text(encoding='utf-8'))['views']
    assert view['status'] == 'refused' and '/nothing' in view['reason']


def test_without_a_journal_a_run_begins_anew(recording, whole, tmp_path, capsys):
    out = tmp_path / 'run'
    assert main(words(recording, out, '--no-journal')) == 0
    assert result(out) == whole.result and not (out / 'journal.mcap').exists()
    unfinish(out)
    assert main(['resume', str(out)]) == 0
    assert 'begins anew' in capsys.readouterr().err and result(out) == whole.result


def _before_a_wall(points, object_too):
    """Return the object before a wall at 3 m, or the wall alone."""
    height, width = points.shape[:2]
    v, u = np.mgrid[:height, :width]
    wall = np.stack([3 * (u - width / 2) / 200, 3 * (v - height / 2) / 200,
                     np.full(u.shape, 3.0)], axis=-1).astype(np.float32)
    return np.where(np.isnan(points[..., 2:]) | (not object_too), wall, points)


def test_a_background_is_cut_out_and_asked_for_again_on_resume(tmp_path, capsys):
    made = frames(3, 1, ('bracket',))
    scene = record(tmp_path / 'scene.mcap', [
        replace(item, points=_before_a_wall(item.points, True)) for item in made])
    wall = record(tmp_path / 'wall.mcap', [
        replace(made[0], points=_before_a_wall(made[0].points, False))])
    out = tmp_path / 'run'
    command = ['replay', str(scene), '--out', str(out), *BARE, '--background', str(wall),
               '--set', 'segmentation.plane=false']
    assert main(command) == 0
    counts = [json.loads(path.read_text(encoding='utf-8'))['counts']
              for path in sorted((out / 'frames').glob('*.json'))]
    for count, item in zip(counts, made, strict=True):
        measured = np.isfinite(item.points[..., 2])
        assert count['background'] == pytest.approx(np.count_nonzero(~measured), rel=0.02)
        assert count['kept'] == pytest.approx(np.count_nonzero(measured), rel=0.05)
    before = result(out)
    unfinish(out)
    wall.rename(tmp_path / 'away')
    assert main(['resume', str(out)]) == 0  # all is in the journal
    assert result(out) == before
    unfinish(out)
    (out / 'journal.mcap').unlink()
    assert main(['resume', str(out)]) == 1
    assert f'its background {wall} is gone' in capsys.readouterr().err
    assert main([*command[:-2], '--overwrite']) == 2
    assert 'wall.mcap: no such file' in capsys.readouterr().err
