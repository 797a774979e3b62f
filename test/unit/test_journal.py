# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The journal. Truth: what was written before it was cut, damaged or the disk was full."""

from contextlib import contextmanager
from dataclasses import replace
import resource

from mcap.reader import make_reader
import numpy as np
import pytest
from reference.streams import views
from ros_rops.core.errors import InputError
from ros_rops.core.types import SupportPlane
from ros_rops.intake.journal import ENTRY_TOPIC, Journal, VIEW_TOPIC
from ros_rops.intake.past import Past
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.recordings.sources import find_views


def _taken(*given):
    return FrameReport(
        given[0].name, Word.TAKEN, 'new', tuple(v.name for v in given), ('a note',), {'moved': .1})


def _small(number):
    view = views(1)[0]
    few = np.arange(40) + number
    return replace(
        view, name=f'v{number}', points=view.points[few], grid=None, stamp_ns=1000 - number,
        support=SupportPlane((0.0, 0.6, 0.8), 1 / 3))


SKIPPED = FrameReport('skipped', Word.SKIPPED, 'the scene moves')


def _write(path, numbers, **options):
    with Journal(path, **options) as journal:
        journal.begin(0)
        for number in numbers:
            journal.keep(_taken(_small(number), _small(1000 + number)), (
                _small(number), _small(1000 + number)))
            journal.keep(SKIPPED, ())
        journal.end(0)
    assert journal.broken == ''
    return path


def _same(a, b):
    for name in ('name', 'sensor', 'units', 'stamp_ns', 'frame_id', 'support'):
        assert getattr(a, name) == getattr(b, name)
    assert a.points.tobytes() == b.points.tobytes()
    assert (a.grid is None) == (b.grid is None)
    assert a.grid is None or a.grid.tobytes() == b.grid.tobytes()


def _reports(past):
    return [entry.report.name for entry in past if entry.report]


def test_what_is_kept_comes_back_bit_by_bit(tmp_path):
    given = [*views(2), _small(7)]
    with Journal(tmp_path / 'j') as journal:
        journal.begin(3)
        journal.keep(_taken(*given), given)
        journal.keep(SKIPPED, ())
        journal.end(3)
    past = Past(tmp_path / 'j')
    entries = list(past)
    assert [entry.kind for entry in entries] == ['open', 'begin', 'frame', 'frame', 'end']
    assert (entries[1].source, entries[4].source) == (3, 3)
    assert entries[2].report == _taken(*given) and entries[3].report == SKIPPED
    for before, after in zip(given, entries[2].views, strict=True):
        _same(before, after)
    assert past.damage == ''


def test_other_tools_read_it_in_order(tmp_path):
    path = _write(tmp_path / 'j.mcap', range(4))
    with path.open('rb') as stream:
        topics = [channel.topic for _, channel, _ in make_reader(stream).iter_messages()]
    assert topics.count(VIEW_TOPIC) == 8 and topics.count(ENTRY_TOPIC) == 2 + 8 + 1
    names = [outcome.view.name for outcome in find_views([path])[0].views()]
    assert names == ['v0', 'v1000', 'v1', 'v1001', 'v2', 'v1002', 'v3', 'v1003']


def test_cut_anywhere_it_holds_what_was_finished_before_and_can_be_gone_on_with(tmp_path):
    whole = _write(tmp_path / 'whole', range(3)).read_bytes()
    path = tmp_path / 'cut'
    expected = ['v0', 'skipped', 'v1', 'skipped', 'v2', 'skipped']
    lengths = set()
    for cut in np.random.default_rng(1).integers(0, len(whole), 60):
        path.write_bytes(whole[:cut])
        past = Past(path)
        found = _reports(past)
        assert found == expected[:len(found)] and past.at <= cut and past.damage == ''
        lengths.add(len(found))
        before = path.read_bytes()[:past.at]
        _write(path, [8], at=past.at, latest_ns=past.latest_ns)
        assert path.read_bytes()[:past.at] == before
        again = Past(path)
        assert _reports(again) == [*found, 'v8', 'skipped'] and again.damage == ''
        with path.open('rb') as stream:  # and mcap's own reader takes it
            assert sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages()) > 0
    assert lengths == set(range(7))


def test_gone_on_with_again_and_again(tmp_path):
    path = tmp_path / 'j'
    _write(path, [0])
    for number in range(1, 5):
        past = Past(path)
        assert len(_reports(past)) == 2 * number
        _write(path, [number], at=past.at, latest_ns=past.latest_ns)
    assert _reports(Past(path))[::2] == [f'v{k}' for k in range(5)]
    names = [outcome.view.name for outcome in find_views([path.rename(tmp_path / 'j.mcap')])[
        0].views()]
    assert names[::2] == [f'v{k}' for k in range(5)]


def test_damage_ends_it_and_is_said(tmp_path):
    whole = _write(tmp_path / 'whole', range(3)).read_bytes()
    path, said = tmp_path / 'damaged', 0
    for at in np.random.default_rng(2).integers(0, len(whole), 60):
        data = bytearray(whole)
        data[at] ^= 0x55
        path.write_bytes(data)
        past = Past(path)
        entries = [entry for entry in past if entry.views]
        for number, entry in enumerate(entries):
            _same(entry.views[0], _small(number))
            _same(entry.views[1], _small(1000 + number))
        assert len(entries) == 3 or past.torn
        said += bool(past.damage)
    assert said > 30


@pytest.mark.parametrize('data', [b'', b'\x89MCAP0', b'no journal at all', b'\0' * 1000])
def test_what_is_no_journal_holds_nothing(tmp_path, data):
    (tmp_path / 'j').write_bytes(data)
    past = Past(tmp_path / 'j')
    assert list(past) == [] and past.at == 0 and past.torn == len(data)
    assert bool(past.damage) == (len(data) > 8)


def test_a_journal_that_is_not_there_is_said(tmp_path):
    with pytest.raises(InputError, match=r'none: cannot be read'):
        list(Past(tmp_path / 'none'))


@contextmanager
def file_limit(size):
    """Limit the size of files, which then fail as on a full disk; the runner's own output too."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_breaks_it_off_and_raises_nothing(tmp_path):
    path = tmp_path / 'j'
    with Journal(path) as journal:
        journal.keep(_taken(_small(0)), (_small(0),))
        with file_limit(path.stat().st_size + 100):
            journal.keep(_taken(_small(1)), (_small(1),))
        assert 'cannot be written (File too large)' in journal.broken
        journal.keep(_taken(_small(2)), (_small(2),))
        journal.end(0)
    past = Past(path)
    assert _reports(past) == ['v0'] and past.torn == 100 and past.damage == ''


@pytest.mark.parametrize('place', ['', 'missing/j', '/dev/full'])
def test_a_journal_that_cannot_be_begun_is_broken_from_the_start(tmp_path, place):
    with Journal(tmp_path / place) as journal:
        assert 'cannot be written' in journal.broken
        journal.keep(SKIPPED, ())


def test_without_a_path_nothing_is_kept_and_nothing_is_broken():
    with Journal(None) as journal:
        journal.keep(SKIPPED, ())
    assert journal.broken == ''


def test_commands_and_counts_come_back_in_their_place(tmp_path):
    with Journal(tmp_path / 'j') as journal:
        journal.command('finish')
        journal.count({Word.SKIPPED: {'the scene moves': 3}})
        journal.keep(_taken(_small(1)), [_small(1)])
        journal.command('remove_last_view')
    past = Past(tmp_path / 'j')
    found = [
        (entry.kind, entry.command, dict(entry.counts), len(entry.views)) for entry in past]
    assert found == [
        ('open', '', {}, 0), ('command', 'finish', {}, 0),
        ('count', '', {Word.SKIPPED: {'the scene moves': 3}}, 0), ('frame', '', {}, 1),
        ('command', 'remove_last_view', {}, 0)]


def test_a_journal_that_was_ended_lacks_nothing(tmp_path):
    past = Past(_write(tmp_path / 'j', [1]))
    assert len(list(past)) and past.torn == 0 and past.damage == ''
    with (tmp_path / 'j').open('r+b') as stream:
        stream.truncate(past.at)
    again = Past(tmp_path / 'j')
    assert len(list(again)) and (again.at, again.torn) == (past.at, 0)
