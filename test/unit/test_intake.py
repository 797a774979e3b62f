# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The intake with a session that only listens. Truth: what was put in, and the rules."""

from dataclasses import replace
import gc
from types import SimpleNamespace
import weakref

import numpy as np
import pytest
from reference.streams import frame, frames, record, views
from ros_rops.core.config import Config
from ros_rops.core.types import Status
from ros_rops.intake.feed import Feed
from ros_rops.intake.intake import Intake
from ros_rops.intake.journal import Journal
from ros_rops.intake.past import Past
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.pipeline.reports import ViewReport
from ros_rops.recordings.sources import find_views, Recording


class Listener:
    """A session that places nothing."""

    def __init__(self):
        self.names = []
        self.events = []

    def add(self, view):
        self.names.append(view.name)
        self.events.append(('add', view.name))
        return ViewReport(view.name, Status.PENDING, None, 'waits')

    def finish(self):
        self.events.append(('finish', ''))


def _intake(journal=None, **values):
    return Intake(Listener(), Config.from_flat(values), journal=journal)


STRIDE = {'selection.method': 'stride', 'selection.stride': 3}


def test_every_frame_gets_its_word():
    intake = _intake(**STRIDE)
    reports = [intake.take(item) for item in frames(2)]
    words = [report.word for report in reports]
    assert words == [Word.TAKEN, Word.SKIPPED, Word.SKIPPED] * 2
    assert all(report.reason for report in reports)
    assert intake.session.names == [reports[0].name, reports[3].name]
    assert [view.status for view in reports[0].reports] == [Status.PENDING]
    assert list(intake.order) == intake.session.names and intake.refusals == {}


def test_a_frame_without_an_object_is_empty_and_says_why():
    intake = _intake()
    report = intake.take(frame(np.full((20, 30, 3), np.nan, np.float32), 0))
    assert report.word is Word.EMPTY and report.reason and report.views == ()
    bad = intake.refuse('/t@1', 'the message cannot be decoded')
    assert intake.refusals == {report.name: report.reason, '/t@1': bad.reason}
    assert intake.order == (report.name, '/t@1') and intake.session.names == []


def test_two_cameras_are_judged_each_by_its_own_scene():
    points = frames(1, 1)[0].points
    intake = _intake(**STRIDE)
    words = [
        intake.take(frame(points, k, topic=f'/camera{k % 2}')).word for k in range(8)]
    assert [k for k, word in enumerate(words) if word is Word.TAKEN] == [0, 1, 6, 7]


def test_a_new_stream_begins_anew():
    intake = _intake(**STRIDE)
    for expected in (Word.TAKEN, Word.SKIPPED):
        assert intake.take(frames(1)[0]).word is expected
    intake.begin()
    assert intake.take(frames(1)[1]).word is Word.TAKEN


def test_a_name_is_given_once():
    intake = _intake()
    view = views(1)[0]
    names = [intake.take_view(view).name for _ in range(3)]
    assert names == [view.name, f'{view.name}#2', f'{view.name}#3']
    assert intake.refuse(view.name, 'no').name == f'{view.name}#4'


def test_a_finished_view_in_a_recording_is_neither_selected_nor_cut():
    intake = _intake(**STRIDE, **{'segmentation.when': 'always'})
    view = views(1)[0]
    for number in range(3):
        item = replace(
            frames(1, 1)[0], name=str(number), view=replace(view, name=str(number)))
        assert intake.take(item).word is Word.TAKEN


def test_a_view_is_journalled_before_the_session_works_on_it():
    intake = _intake()
    intake.journal = SimpleNamespace(
        keep=lambda report, views: intake.session.events.append(('keep', report.name)))
    intake.take_view(views(1)[0])
    intake.finish()
    assert [event for event, _ in intake.session.events] == ['keep', 'add', 'finish']


def _words(feed):
    return [(report.name, report.word) for report in feed]


@pytest.mark.parametrize('method', ['stride', 'still'])
def test_gone_on_with_anywhere_the_selection_is_the_same(tmp_path, method):
    """Truth: the words of a run without a break, at every frame where one could be."""
    sources = find_views([
        record(tmp_path / 'a.mcap', frames(2)), record(tmp_path / 'b.mcap', frames(1))])
    values = {
        'selection.method': method, 'selection.still_frames': 2, 'selection.still_s': 0.0,
        'selection.stride': 2}
    whole = _words(Feed(sources, _intake(**values)).run())
    assert len(whole) == 9 and {word for _, word in whole} == {Word.TAKEN, Word.SKIPPED}
    for stop in range(10):
        path = tmp_path / f'{stop}.mcap'
        with Journal(path) as journal:
            feed = Feed(sources, _intake(journal, **values)).run()
            for _ in range(stop):
                next(feed)
        intake = _intake(**values)
        feed, past = Feed(sources, intake), Past(path)
        found = _words(feed.recall(past))
        assert found == whole[:stop]
        assert found + _words(feed.run()) == whole and feed.complete
        assert intake.session.names == [name for name, word in whole if word is Word.TAKEN]


def test_an_input_that_differs_from_the_journal_is_not_read_on(tmp_path):
    path = record(tmp_path / 'a.mcap', frames(2))
    with Journal(tmp_path / 'j') as journal:
        feed = Feed(find_views([path]), _intake(journal, **STRIDE)).run()
        for _ in range(4):
            next(feed)
    feed = Feed(find_views([path]), _intake(**{**STRIDE, 'selection.stride': 2}))
    assert len(list(feed.recall(Past(tmp_path / 'j')))) == 4
    assert list(feed.run()) == [] and not feed.complete
    assert 'differs from the journal' in feed.lost[0]


def test_frames_that_are_skipped_are_not_kept_in_memory(tmp_path, monkeypatch):
    alive = []

    def made(self, units):
        for number in range(6):
            points = frames(1, 1)[0].points.copy()
            alive.append(weakref.ref(points))
            yield frame(points, number)
            del points
            gc.collect()
            # The one just handed out may still be looked at.
            assert sum(ref() is not None for ref in alive) <= 1

    monkeypatch.setattr(Recording, 'frames', made)
    feed = Feed([Recording(tmp_path)], _intake(**{**STRIDE, 'selection.stride': 100}))
    assert len(list(feed.run())) == 6


def test_a_word_comes_back_from_json():
    report = FrameReport('a', Word.EMPTY, 'why', (), ('note',), {'moved': 0.125})
    assert FrameReport.from_json(report.to_json()) == report
