# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The live station, its session real, its views too small to register. Truth: the rules."""

import json

import numpy as np
from reference.live import (
    cloud, offer_all, PLAIN, saved, settled, small, station, VIEWS)
from ros_rops.intake.reports import Word
from ros_rops.recordings import cdr
from ros_rops.recordings.messages import Channel, RawMessage
from ros_rops.recordings.view_facts import encode_facts, FACTS_TOPIC, ViewFacts

REQUEST = {**PLAIN, 'selection.method': 'request'}


def _words(heard):
    return [report.word for report in heard.reports]


def _names(heard):
    return [report.name for report in heard.reports]


def _poses(folder):
    return json.loads((folder / 'poses.json').read_text(encoding='utf-8'))


def test_every_command_has_an_answer_before_the_first_view(tmp_path, heard):
    with station(tmp_path, heard, PLAIN) as made:
        for command in (made.finish, made.remove_last_view):
            answer = command()
            assert not answer.success and 'there is no view' in answer.message
        for command in (made.capture, made.save, made.reset):
            answer = command()
            assert answer.success and answer.message
        made.accept(False)
        assert not made.capture().success and 'not active' in made.capture().message
        heard.wait(lambda: heard.updates and heard.updates[-1].epoch == 1)
        assert made.state().errors == 0


def test_words_tell_of_every_message_and_bad_ones_stop_nothing(tmp_path, heard):
    bad = RawMessage(VIEWS, 5, b'\0\1\0\0\7\0\0\0\2\0\0\0')
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [
            small(0), bad, RawMessage(VIEWS, 6, b''), small(1),
            cloud(np.full((9, 3), np.nan), 77), small(2)])
        state = made.state()
    assert _words(heard) == [
        Word.TAKEN, Word.BAD, Word.BAD, Word.TAKEN, Word.EMPTY, Word.TAKEN]
    assert state.words == {'taken': 3, 'skipped': 0, 'empty': 1, 'bad': 2}
    assert state.received == 6 and state.dropped == 0 and state.errors == 0
    first = heard.words[0]
    assert (first.stamp_ns, first.frame_id) == (1_000_000_000, 'camera_optical_frame')
    assert 0 <= first.waited_s <= first.took_s < 60 and state.latency_s > 0
    assert heard.words[4].stamp_ns == 77
    # A frame that should have given a view has its place in poses.json too.
    assert heard.updates[-1].numbers == {name: k for k, name in enumerate(_names(heard))}
    assert heard.updates[-1].newest == _names(heard)[-1]


def test_a_message_of_another_kind_is_no_frame(tmp_path, heard):
    image = Channel('views', 'sensor_msgs/msg/Image', 'cdr')
    with station(tmp_path, heard, PLAIN) as made:
        made.offer(RawMessage(image, 1, small(0).data))
        made.offer(RawMessage(Channel('nobody', 'std_msgs/msg/String', 'cdr'), 1, b''))
        made.offer(None)  # not even a message
        offer_all(made, heard, [small(0)])
        assert made.state().received == 1 and made.state().errors == 1
    assert _words(heard) == [Word.TAKEN]


def test_facts_are_acknowledged(tmp_path, heard):
    facts = ViewFacts('views', 'frame', 'my name', frame_id='f', stamp_ns=7)
    data = cdr.string_message(encode_facts(facts).decode())
    channel = Channel(FACTS_TOPIC, 'std_msgs/msg/String', 'cdr')
    with station(tmp_path, heard, PLAIN) as made:
        made.offer(RawMessage(channel, 1, data))
        heard.wait_words(1)
    assert heard.words[0].report is None and heard.words[0].frame_id == 'view_facts'


def test_an_asked_for_frame_is_taken_and_only_the_next_that_arrives(tmp_path, heard):
    with station(tmp_path, heard, REQUEST) as made:
        offer_all(made, heard, [small(0), small(1)])
        assert made.capture().success
        offer_all(made, heard, [small(2), small(3)])
        assert made.capture().success and made.capture().success
        offer_all(made, heard, [small(number) for number in range(4, 8)])
    assert [k for k, word in enumerate(_words(heard)) if word is Word.TAKEN] == [2, 4, 5]
    assert heard.reports[2].reason == 'it was asked for'


def test_a_bad_message_is_not_what_was_asked_for(tmp_path, heard):
    with station(tmp_path, heard, REQUEST) as made:
        made.capture()
        offer_all(made, heard, [RawMessage(VIEWS, 1, b'no'), small(0), small(1)])
    assert _words(heard) == [Word.BAD, Word.TAKEN, Word.SKIPPED]


def test_a_paused_station_lets_frames_go_by_and_says_so(tmp_path, heard):
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0)])
        assert made.pause(True).success and 'already' in made.pause(True).message
        assert made.state().paused and not made.capture().success
        offer_all(made, heard, [small(1), small(2)])
        assert made.pause(False).success and made.pause(False).success
        offer_all(made, heard, [small(3)])
    assert _words(heard) == [Word.TAKEN, Word.SKIPPED, Word.SKIPPED, Word.TAKEN]
    assert heard.reports[1].reason == 'the station is paused'


def test_an_inactive_station_takes_nothing_and_keeps_its_state(tmp_path, heard):
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0)])
        made.accept(False)
        made.offer(small(1))
        made.accept(True)
        offer_all(made, heard, [small(2)])
        assert made.state().received == 2
    assert len(heard.updates[-1].views) == 2


def test_in_one_shot_mode_what_finds_no_room_is_refused_and_reported(tmp_path, heard, gate):
    with station(tmp_path, heard, PLAIN, input__most_frames=2, input__most_views=1) as made:
        # One is registered, one waits for that, one is held by the sorter, two are looked at
        # by nobody: the rest has no room.
        for number in range(4):
            made.offer(small(number))
            heard.wait(lambda n=number: _inside(made) or made.state().waiting_frames >= n - 2)
        for number in range(4, 12):
            made.offer(small(number))
        full = made.state().dropped
        assert full >= 5
        gate.set()
        heard.wait_words(12)
        assert settled(made, heard).words == {
            'taken': 12 - full, 'skipped': 0, 'empty': 0, 'bad': full}
        folder = saved(made, heard).rpartition(' to ')[2]
    reasons = [report.reason for report in heard.reports if report.word is Word.BAD]
    assert reasons == ['the queue is full'] * full
    views = json.loads((tmp_path / 'run_0001' / 'poses.json').read_text())['views']
    assert len(views) == 12 and folder.endswith('run_0001')
    # In the order of arrival, those refused in their place.
    assert [view['name'] for view in views] == [
        f'views@{1_000_000_000 + number}' for number in range(12)]


def _inside(made):
    state = made.state()
    return state.waiting_frames == 0 and bool(state.doing)


def test_a_stream_drops_the_oldest_and_counts(tmp_path, heard, gate):
    values = {**PLAIN, 'selection.method': 'stride', 'selection.stride': 1}
    with station(tmp_path, heard, values, input__most_frames=2, input__most_views=1) as made:
        for number in range(10):
            made.offer(small(number))
        dropped = made.state().dropped
        assert dropped >= 4
        gate.set()
        heard.wait_words(10)
    assert _words(heard).count(Word.SKIPPED) == dropped
    assert f'views@{1_000_000_009}' in heard.updates[-1].views  # the newest is there


def test_a_view_taken_back_leaves_its_number_to_no_other(tmp_path, heard):
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0), small(1)])
        assert made.remove_last_view().success
        offer_all(made, heard, [small(2)])
        update = heard.updates[-1]
        assert list(update.views) == ['views@1000000000', 'views@1000000002']
        assert list(update.numbers.values()) == [0, 1, 2]
        saved(made, heard)
        assert made.remove_last_view().success and made.remove_last_view().success
        assert 'no view' in made.remove_last_view().message
        heard.wait(lambda: not heard.updates[-1].views)
        assert made.state().statuses['refused'] == 0
    views = _poses(tmp_path / 'latest')['views']
    assert [view['name'] for view in views] == list(update.numbers)
    assert views[1]['reason'] == 'taken back by ~/remove_last_view'


def test_a_reset_ends_the_run_and_begins_the_next(tmp_path, heard):
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0)])
        saved(made, heard)
        assert made.reset().success
        offer_all(made, heard, [small(1)])
        assert made.state().folder == str(tmp_path / 'run_0002')
        assert made.state().words['taken'] == 1
        assert made.reset().success
        heard.wait(lambda: heard.updates[-1].epoch == 2)
    assert [update.epoch for update in heard.updates] == [0, 1, 1, 2]
    assert not heard.updates[-1].views
    states = [
        json.loads((tmp_path / f'run_000{k}' / 'run.json').read_text())['state']
        for k in (1, 2, 3)]
    assert states == ['finished', 'partial', 'running']
    assert (tmp_path / 'latest').resolve() == tmp_path / 'run_0003'
    assert (tmp_path / 'run_0001' / 'journal.mcap').read_bytes()[-8:] == b'\x89MCAP0\r\n'


def test_a_save_just_before_a_reset_does_not_hold_latest_back(tmp_path, heard):
    with station(tmp_path, heard, PLAIN) as made:
        offer_all(made, heard, [small(0)])
        assert made.save().success and made.reset().success
        heard.wait(lambda: heard.updates[-1].epoch == 1)
    assert (tmp_path / 'run_0001' / 'poses.json').exists()
    assert (tmp_path / 'latest').resolve() == tmp_path / 'run_0002'
