# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Markers and words that go out, over the wire. Truth: what was handed in."""

import threading

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402, I100
from ros.harness import LATCHED, RELIABLE  # noqa: E402
from ros.outputs_beside import last, outputs, two_objects  # noqa: E402
from ros_rops.core.groups_node import PublishConfig  # noqa: E402
from ros_rops.core.types import Status  # noqa: E402
from ros_rops.intake.reports import FrameReport, Word  # noqa: E402
from ros_rops.live.health import Inlet  # noqa: E402
from ros_rops.live.words import Handled, StationState, Update  # noqa: E402
from sensor_msgs.msg import PointCloud2  # noqa: E402
from std_msgs.msg import Header  # noqa: E402
from visualization_msgs.msg import MarkerArray  # noqa: E402


def test_the_scene_as_a_viewer_has_it():
    station = two_objects()
    station.see('w', status=Status.AMBIGUOUS)
    shown = {}
    with outputs('left') as given:
        scenes = given.client.collect(MarkerArray, '/left/markers', LATCHED)
        for turn in (1, 2):
            given.out.updated(station.update())
            for marker in last(scenes, turn).markers:
                if marker.action == 3:
                    shown.clear()
                else:
                    shown[marker.ns, marker.id] = marker
            assert {number for name, number in shown if name == 'views'} == (
                {0, 1, 2, 3, 4} if turn == 1 else {0, 2, 4})
            if turn == 1:
                station.take_back('b')  # what is left of its object waits
    assert {number for name, number in shown if name == 'waiting'} == {3, 5}
    assert {marker.header.frame_id for marker in shown.values()} == {'camera'}
    text = shown['waiting_labels', 5].text
    assert text == 'left/view_5: ambiguous: waits for views'


def test_reports_come_when_words_change():
    station = two_objects()
    with outputs() as given:
        found = given.client.collect(DiagnosticStatus, 'view_reports', RELIABLE)
        given.out.updated(station.update('a', 'b'))
        given.out.updated(station.update())
        given.out.handled(Handled(FrameReport('f', Word.SKIPPED, 'alike'), 1, 'camera'))
        given.out.handled(Handled(FrameReport('t', Word.TAKEN, '', ('a',)), 1, 'camera'))
        given.out.handled(Handled(FrameReport('x', Word.BAD, 'the queue is full'), 1, 'camera'))
        station.take_back('b')
        given.out.updated(station.update('c'))
        last(found, 5)
        late = given.client.collect(DiagnosticStatus, 'view_reports', LATCHED)
        last(late, 5)
    assert found == late
    assert [(item.name, item.level) for item in found] == [
        ('a', DiagnosticStatus.OK), ('b', DiagnosticStatus.OK), ('x', DiagnosticStatus.ERROR),
        ('b', DiagnosticStatus.WARN), ('c', DiagnosticStatus.OK)]
    values = {item.key: item.value for item in found[0].values}
    assert values == {'status': 'placed', 'object_id': '1', 'view_id': '0', 'score': '0.123457'}
    assert (found[0].message, found[0].hardware_id) == ('Placed in object 1: fits well.', 'camera')


def test_every_message_that_has_its_word_is_acknowledged():
    with outputs(publish=PublishConfig(skipped=True)) as given:
        found = given.client.collect(Header, 'handled', RELIABLE)
        reports = given.client.collect(DiagnosticStatus, 'view_reports', RELIABLE)
        given.out.handled(Handled(None, 2_000_000_003, 'view_facts'))
        given.out.handled(Handled(FrameReport('f', Word.SKIPPED, 'alike'), 7, 'camera'))
        last(found, 2)
        last(reports)
    assert [(item.frame_id, item.stamp.sec, item.stamp.nanosec) for item in found] == [
        ('view_facts', 2, 3), ('camera', 0, 7)]
    assert [item.name for item in reports] == ['f']


def test_health():
    with outputs('left') as given:
        found = given.client.collect(DiagnosticArray, '/diagnostics', RELIABLE)
        given.out.handled(Handled(None, waited_s=0.5))
        state = StationState(dropped=2, errors=1, last_error='no', journal='whole')
        given.out.diagnostics(state, 'active', {'more': 1.5}, [Inlet('/left/views', 0)])
        (message,) = (last(found),)
    levels = {item.name: item.level for item in message.status}
    node = 'rops_registration'
    assert levels == {
        f'{node}: input': DiagnosticStatus.WARN, f'{node}: queue': DiagnosticStatus.WARN,
        f'{node}: registration': DiagnosticStatus.ERROR, f'{node}: journal': DiagnosticStatus.OK}
    values = {item.key: item.value for status in message.status for item in status.values}
    assert (values['longest_wait_ms'], values['dropped'], values['more']) == ('500', '2', '1.5')
    assert message.header.stamp.sec > 0
    assert {item.hardware_id for item in message.status} == {'/left/rops_registration'}


def test_threads_may_speak_at_once_and_after_the_end():
    station = two_objects()
    updates = [station.update()]
    for name in 'fghi':
        station.see(name, 1)
        updates.append(station.update(name))
    updates.append(Update(epoch=1))
    errors, ended = [], threading.Event()

    def again(call):
        try:
            while not ended.is_set():
                call()
            call()
        except Exception as error:
            errors.append(error)
    with outputs() as given:
        out, context = given.out, given.node.context
        calls = (
            lambda: [out.updated(update) for update in updates], out.rebroadcast,
            lambda: out.handled(Handled(FrameReport('x', Word.BAD, 'no'), 1, 'camera')),
            lambda: out.diagnostics(StationState(), 'active'))
        threads = [threading.Thread(target=again, args=(call,)) for call in calls]
        for thread in threads:
            thread.start()
        found = given.client.collect(PointCloud2, 'assembled', LATCHED)
        last(found, 5)
        context.try_shutdown()  # as SIGINT does
        out.close()
        ended.set()
        for thread in threads:
            thread.join()
    assert errors == []
