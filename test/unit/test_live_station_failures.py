# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The live station, its session real, on failures, changes and the end. Truth: the rules."""

import json
import time

import numpy as np
import pytest
from reference.live import (
    cloud, Heard, offer_all, PLAIN, saved, settled, small, station, VIEWS)
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.intake import admission
from ros_rops.intake.reports import Word
from ros_rops.live import worker as worker_module
from ros_rops.pipeline.session import Session
from ros_rops.recordings.messages import RawMessage

REQUEST = {**PLAIN, 'selection.method': 'request'}


def _words(heard):
    return [report.word for report in heard.reports]


def _poses(folder):
    return json.loads((folder / 'poses.json').read_text(encoding='utf-8'))


def test_a_view_on_which_registration_fails_is_refused_and_the_next_goes_on(
    tmp_path, heard, monkeypatch
):
    add = Session.add

    def failing(self, view):
        if view.name.endswith('1'):
            raise MemoryError('no room')
        if view.name.endswith('2'):
            add(self, view)
            raise ZeroDivisionError
        return add(self, view)

    with station(tmp_path, heard, PLAIN) as made:
        monkeypatch.setattr(Session, 'add', failing)
        offer_all(made, heard, [small(number) for number in range(4)])
        state = made.state()
        saved(made, heard)
    assert state.errors == 2 and 'ZeroDivisionError' in state.last_error
    assert _words(heard) == [Word.TAKEN] * 4
    assert 'no room (MemoryError)' in heard.reports[1].reports[0].reason
    views = _poses(tmp_path / 'latest')['views']
    assert [view['status'] for view in views] == ['refused'] * 4
    assert 'its registration failed' in views[2]['reason']


def test_a_frame_on_which_segmentation_fails_is_bad_and_the_next_goes_on(
    tmp_path, heard, monkeypatch
):
    segment = admission.segment

    def failing(frame, *given, **more):
        if frame.name.endswith('1'):
            raise IndexError('of no sense')
        return segment(frame, *given, **more)

    monkeypatch.setattr(admission, 'segment', failing)
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(number) for number in range(3)])
        state = made.state()
    assert _words(heard) == [Word.TAKEN, Word.BAD, Word.TAKEN]
    assert 'of no sense' in heard.reports[1].reason
    assert state.errors == 1 and 'of no sense' in state.last_error


def test_a_listener_that_fails_ends_nothing(tmp_path):
    class Broken(Heard):

        def handled(self, handled):
            super().handled(handled)
            raise OSError('no wire')

        updated = handled

    heard = Broken()
    with station(tmp_path, heard, PLAIN) as made:
        for number in range(3):
            made.offer(small(number))
        heard.wait_words(6)
        state = settled(made, heard)
    assert state.words['taken'] == 3 and state.errors == 6 and 'no wire' in state.last_error


def test_a_result_that_cannot_be_written_is_said_and_the_next_is(tmp_path, heard, monkeypatch):
    def failing(*given, **more):
        raise InputError('poses.json: cannot be written (No space left on device)')

    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0)])
        with monkeypatch.context() as patch:
            patch.setattr(worker_module, 'write_run', failing)
            text = saved(made, heard)
        assert text.startswith('not saved: ') and 'No space left' in made.state().last_error
        offer_all(made, heard, [small(1)])
        assert saved(made, heard).startswith('saved 0 objects of 2 views to ')
    assert len(_poses(tmp_path / 'latest')['views']) == 2


def test_a_folder_that_cannot_be_written_is_the_callers_mistake(tmp_path, heard):
    (tmp_path / 'file').write_text('')
    with pytest.raises(InputError, match='cannot be made'), station(tmp_path / 'file', heard):
        pass
    bad = station(tmp_path / 'out', heard, input__background=str(tmp_path / 'file'))
    with pytest.raises(InputError, match='input.background'), bad:
        pass


def test_where_no_next_folder_can_be_made_the_run_goes_on(tmp_path, heard, monkeypatch):
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0)])
        with monkeypatch.context() as patch:
            patch.setattr('ros_rops.live.run._new_folder', _full)
            made.reset()
            heard.wait(lambda: made.state().errors)
        offer_all(made, heard, [small(1)])
        assert 'the run goes on' in made.state().last_error
    assert len(heard.updates[-1].views) == 2


def _full(parent):
    raise InputError('no space left')


def test_selection_may_change_and_the_engine_may_not(tmp_path, heard):
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0)])
        made.reconfigure(Config.from_flat(REQUEST))
        offer_all(made, heard, [small(1)])
        with pytest.raises(ParameterError, match='rops'):
            made.reconfigure(Config.from_flat({**REQUEST, 'rops.bins': 7}))
        # Noted in its turn; what waits when the station ends is not.
        heard.wait(lambda: _parameters(tmp_path)['selection.method'] == 'request')
    assert _words(heard) == [Word.TAKEN, Word.SKIPPED]


def _parameters(folder):
    return json.loads((folder / 'latest' / 'run.json').read_text())['parameters']


def test_what_waits_when_it_closes_is_journalled(tmp_path, heard, gate):
    with station(tmp_path, heard, PLAIN, input__most_views=1) as made:
        for number in range(6):
            made.offer(small(number))
        assert made.close(0.2) is False and made.close(0.1) is False
        gate.set()
    again = Heard()
    with station(tmp_path, again, PLAIN, resume=True) as made:
        again.wait(lambda: again.updates)
        assert list(again.updates[-1].views) == [
            f'views@{1_000_000_000 + number}' for number in range(6)]
        assert made.state().folder.endswith('run_0001') and made.state().words['taken'] == 6
        offer_all(made, again, [small(3)])  # its name was given before
        assert again.reports[0].name == 'views@1000000003#2'


def test_without_a_journal_what_is_lost_by_closing_is_said(tmp_path, heard, gate):
    with station(tmp_path, heard, PLAIN, output__journal=False) as made:
        for number in range(4):
            made.offer(small(number))
        heard.wait(lambda: made.state().waiting_views == 3)
        assert made.state().journal == 'none' and not made.close(0.1)
        gate.set()
    assert '3 views that waited are lost' in made.state().last_error


def test_without_resume_and_after_a_reset_a_run_begins(tmp_path, heard):
    for resume, expected in ((False, 1), (False, 2), (True, 2), (True, 2)):
        with station(tmp_path, heard, PLAIN, resume=resume) as made:
            assert made.state().folder.endswith(f'run_000{expected}')
    with station(tmp_path, heard, PLAIN, resume=True) as made:
        made.reset()
        heard.wait(lambda: heard.updates and heard.updates[-1].epoch == 1)
    (tmp_path / 'run_0003' / 'run.json').write_text('{}')
    with station(tmp_path, heard, PLAIN, resume=True) as made:
        assert made.state().folder.endswith('run_0004')
        assert 'not resumed' in made.state().last_error


def test_a_run_that_another_station_has_is_not_gone_on_with(tmp_path, heard):
    again = station(tmp_path, heard, PLAIN, resume=True)
    with station(tmp_path, heard, PLAIN) as first, again as second:
        assert 'another process is working on this run' in second.state().last_error
        assert first.state().folder != second.state().folder


def test_offers_and_commands_return_at_once_whatever_is_done(tmp_path, heard, gate):
    data = cloud(np.ones((480, 640, 3)), 3)
    with station(tmp_path, heard, REQUEST) as made:
        made.capture()
        made.offer(small(0))
        heard.wait(lambda: made.state().doing)
        seconds = []
        for _ in range(100):
            for call in (
                lambda: made.offer(data), made.state, made.capture, made.finish,
                lambda: made.pause(False), lambda: made.pause(True)
            ):
                started = time.perf_counter()
                call()
                seconds.append(time.perf_counter() - started)
        gate.set()
    # Others may have the cores for a while: this tells waiting from not waiting.
    assert np.median(seconds) < 1e-3 and max(seconds) < 0.2


def test_a_live_sensor_may_send_for_ever(tmp_path, heard, monkeypatch):
    monkeypatch.setattr('ros_rops.intake.admission.MOST_BLANKS', 5)
    values = {**PLAIN, 'selection.method': 'stride', 'selection.stride': 10}
    with station(tmp_path, heard, values) as made:
        offer_all(made, heard, [small(number) for number in range(30)])
        offer_all(made, heard, [RawMessage(VIEWS, 9, b'bad')] * 20)
        saved(made, heard)
    text = (tmp_path / 'latest' / 'frames.json').read_text()
    frames, again = json.loads(text), Heard()
    with station(tmp_path, again, values, resume=True) as made:
        again.wait(lambda: again.updates)
        assert made.state().words == {'taken': 3, 'skipped': 27, 'empty': 0, 'bad': 20}
        saved(made, again)
    assert (tmp_path / 'latest' / 'frames.json').read_text() == text
    assert frames['counts']['read'] == 50 and frames['counts']['skipped'] == 27
    assert frames['counts']['bad'] == 20 and len(frames['frames']) == 3 + 5
    assert len(_poses(tmp_path / 'latest')['views']) == 3 + 5
