# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""run.json, its stamps and the lock of a run folder. Truth: what was written, what was changed."""

import json

import pytest
from reference.streams import frames, record
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.intake.lock import locked
from ros_rops.intake.run_file import (
    read_run_file, RunFile, source_of, stamp, what_changed, write_run_file)
from ros_rops.recordings.atomic import replace_file
from ros_rops.recordings.sources import find_views, Recording


@pytest.fixture
def sources(tmp_path):
    (tmp_path / 'a.xyz').write_text('0 0 1\n', encoding='utf-8')
    record(tmp_path / 'b.mcap', frames(1))
    found = find_views([tmp_path / 'a.xyz', tmp_path / 'b.mcap'])
    return [found[0], Recording(found[1].path, ('/camera/points',))]


def test_it_comes_back_as_it_was(sources, tmp_path):
    config = Config.from_flat({'rops.bins': 6, 'selection.method': 'still'})
    written = RunFile(
        ('a.xyz', 'b.mcap'), tuple(map(stamp, sources)), 'mm', False, True,
        stamp(sources[1]), config.to_flat(), '0.1.0', 'partial')
    write_run_file(tmp_path, written)
    found = read_run_file(tmp_path)
    assert found == written and found.config == config
    assert [source_of(item) for item in found.sources] == [
        type(source)(source.path.resolve(), *rest) for source, rest in zip(
            sources, [('a.xyz',), (('/camera/points',),)], strict=True)]


def test_changes_of_an_input_are_seen(sources):
    for source in sources:
        known = stamp(source)
        assert what_changed(known) == ''
        data = source.path.read_bytes()
        for other in (data + b'x', data[:-1] + bytes([data[-1] ^ 1]), b'y' + data[1:]):
            source.path.write_bytes(other)
            assert what_changed(known) == 'has changed'
        source.path.unlink()
        assert what_changed(known) == 'is gone'


def test_a_folder_is_an_input_as_a_whole(tmp_path):
    (tmp_path / 'bag').mkdir()
    for name in ('metadata.yaml', 'bag_0.mcap'):
        (tmp_path / 'bag' / name).write_bytes(b'content')
    known = stamp(Recording(tmp_path / 'bag'))
    assert known.size == 14
    (tmp_path / 'bag' / 'bag_0.mcap').rename(tmp_path / 'bag' / 'bag_1.mcap')
    assert what_changed(known) == 'has changed'


@pytest.mark.parametrize(('name', 'value'), [
    ('format', 2), ('state', 'odd'), ('parameters', {'no.such': 1}), ('parameters', 3),
    ('sources', [{}]), ('sources', [3]), ('inputs', None)])
def test_what_is_no_run_file_is_named(sources, tmp_path, name, value):
    write_run_file(tmp_path, RunFile(('a.xyz',), tuple(map(stamp, sources)), version='0.1.0'))
    content = json.loads((tmp_path / 'run.json').read_text(encoding='utf-8'))
    (tmp_path / 'run.json').write_text(json.dumps({**content, name: value}), encoding='utf-8')
    with pytest.raises(InputError, match=r'run\.json: is not the run\.json of a run'):
        read_run_file(tmp_path)


def test_a_file_is_replaced_as_a_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / 'poses.json'
    replace_file(path, 'old')

    def full(handle):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr('os.fsync', full)
    with pytest.raises(OSError, match='No space'):
        replace_file(path, 'new')
    assert path.read_text() == 'old' and list(tmp_path.iterdir()) == [path]


def test_a_folder_is_held_once_and_let_go(tmp_path):
    run = tmp_path / 'run'
    again = pytest.raises(InputError, match='another process is working')
    with locked(run, make=True), again, locked(run):
        pass
    with locked(run):
        pass


@pytest.mark.parametrize(('place', 'make', 'message'), [
    ('none', False, 'none: cannot be opened'), ('file', False, 'file: cannot be opened'),
    ('file/run', True, 'run: cannot be written')])
def test_a_folder_that_cannot_be_held_is_named(tmp_path, place, make, message):
    (tmp_path / 'file').write_text('', encoding='utf-8')
    with pytest.raises(InputError, match=message), locked(tmp_path / place, make=make):
        pass
