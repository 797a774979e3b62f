# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The queues of the live station. Truth: what was put in, and the rules of overflow."""

import threading

from hypothesis import given, settings, strategies
import pytest
from reference.live import VIEWS
from ros_rops.intake.admission import Admitted
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.live.inbox import COMPANIONS, HEAD, Inbox, Kind, MOST_ITEMS
from ros_rops.live.tasks import Command, Place, Tasks
from ros_rops.recordings.messages import RawMessage


def _raw(number, size=1000):
    return RawMessage(VIEWS, number, bytes(size))


def _all(inbox):
    inbox.close()
    items = []
    while (item := inbox.get()) is not None:
        items.append(item)
    return items


def _told(items):
    return [(item.kind.value, item.raw.log_time_ns) for item in items]


def test_a_stream_drops_its_oldest_frames_and_keeps_their_heads():
    inbox = Inbox(3, 10**9, refuse=False)
    for number in range(5):
        inbox.put_frame(_raw(number))
    assert inbox.frames == 3 and inbox.overflowed == 2
    items = _all(inbox)
    assert _told(items) == [
        ('dropped', 0), ('dropped', 1), ('frame', 2), ('frame', 3), ('frame', 4)]
    assert [item.size for item in items] == [HEAD, HEAD, 1000, 1000, 1000]
    assert inbox.frames == 0 and inbox.closed


def test_frames_that_each_may_be_wanted_are_refused_where_there_is_no_room():
    inbox = Inbox(2, 10**9, refuse=True)
    for number in range(4):
        inbox.put_frame(_raw(number))
    items = _all(inbox)
    assert _told(items) == [('frame', 0), ('frame', 1), ('full', 2), ('full', 3)]
    assert inbox.overflowed == 2 and items[3].size == HEAD


@pytest.mark.parametrize('refuse', [True, False])
def test_memory_is_bounded_but_one_frame_always_has_room(refuse):
    inbox = Inbox(100, 2500, refuse=refuse)
    inbox.put_frame(_raw(0, 9000))
    assert inbox.frames == 1
    inbox.put_frame(_raw(1))
    assert inbox.frames == 1 and inbox.overflowed == 1
    kept = [item.raw.log_time_ns for item in _all(inbox) if item.kind is Kind.FRAME]
    assert kept == ([0] if refuse else [1])


def test_room_is_given_back_by_reading():
    inbox = Inbox(2, 2500, refuse=True)
    for number in range(50):
        inbox.put_frame(_raw(number))
        inbox.put_companion(_raw(number, 500))
        assert inbox.get().kind is Kind.FRAME and inbox.get().kind is Kind.COMPANION
    assert inbox.overflowed == 0


def test_what_belongs_to_frames_is_bounded_too_and_the_newest_stay():
    inbox = Inbox(2, 10**9, refuse=False)
    for number in range(20):
        inbox.put_companion(_raw(number))
    kept = [item.raw.log_time_ns for item in _all(inbox) if item.kind is Kind.COMPANION]
    assert kept == list(range(20 - COMPANIONS * 2, 20)) and inbox.overflowed == 0


@pytest.mark.parametrize('refuse', [True, False])
def test_nothing_grows_without_end_when_nobody_reads(refuse):
    inbox = Inbox(2, 10**9, refuse=refuse)
    for number in range(MOST_ITEMS + 500):
        inbox.put_frame(_raw(number, 600), paused=number % 3 == 0)
    assert inbox.items <= MOST_ITEMS + 2 and inbox.frames == 2


@settings(max_examples=60, deadline=None)
@given(
    strategies.lists(strategies.tuples(
        strategies.sampled_from(['frame', 'paused', 'companion', 'command', 'get']),
        strategies.integers(1, 1200)), max_size=60),
    strategies.booleans())
def test_order_is_that_of_arrival_and_nothing_is_lost_untold(steps, refuse):
    """Truth: every frame and command comes out once, in order, with its data or the reason."""
    inbox, put, got, companions = Inbox(3, 3000, refuse=refuse), 0, [], set()
    for what, size in steps:
        if what == 'get':
            if inbox.items:
                got.append(inbox.get())
            continue
        put += 1
        if what == 'command':
            assert inbox.put_command('do') == put
        elif what == 'companion':
            inbox.put_companion(_raw(put, size))
            companions.add(put)
        else:
            inbox.put_frame(_raw(put, size), paused=what == 'paused')
    got += _all(inbox)
    numbers = [item.number for item in got]
    assert numbers == sorted(numbers) and set(range(1, put + 1)) - set(numbers) <= companions
    lost = sum(item.kind in (Kind.DROPPED, Kind.FULL) for item in got)
    assert lost == inbox.overflowed
    assert all(item.size > 0 or item.kind is Kind.COMMAND for item in got)


def test_reading_waits_for_a_while_and_no_longer():
    inbox = Inbox(2, 1000, refuse=True)
    assert inbox.get(0.0) is None
    threading.Timer(0.02, inbox.put_command, ('do',)).start()
    assert inbox.get(30.0).order == 'do'
    threading.Timer(0.02, inbox.close).start()
    assert inbox.get() is None and inbox.closed


def _place(number):
    return Place(Admitted(FrameReport(str(number), Word.TAKEN), ('view',)))


def test_the_sorter_waits_while_too_many_views_do_but_not_in_a_hurry():
    tasks, done = Tasks(2), []

    def put():
        for number in range(5):
            tasks.put(_place(number))
            done.append(number)

    thread = threading.Thread(target=put)
    thread.start()
    for expected in range(3):
        assert tasks.get().admitted.report.name == str(expected)
    tasks.hurry()
    thread.join(30)
    assert done == list(range(5)) and tasks.views == 2
    tasks.put(Command('save'))
    tasks.stop()
    assert tasks.get() is None and len(tasks.rest()) == 3
