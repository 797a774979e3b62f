# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The registration node's states. Truth: the state machine of ROS 2's managed nodes.

Design article `node_lifecycle`: which transitions each state has, and where they lead.
"""

import threading
import time

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from lifecycle_msgs.msg import TransitionEvent  # noqa: E402, I100
from lifecycle_msgs.srv import GetAvailableTransitions  # noqa: E402
from ros.harness import Client, NODE, RELIABLE, station  # noqa: E402

CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE = 1, 2, 3, 4
SHUTDOWNS = {'unconfigured': 5, 'inactive': 6, 'active': 7}
LEGAL = {
    'unconfigured': {CONFIGURE: 'inactive'},
    'inactive': {CLEANUP: 'unconfigured', ACTIVATE: 'active'},
    'active': {DEACTIVATE: 'inactive'},
    'finalized': {},
}
ALL = [0, CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, 5, 6, 7, 8, 10, 30, 99, 'nonsense',
       'configure', 'cleanup', 'activate', 'deactivate', 'on_configure_success']
LABELS = {'configure': CONFIGURE, 'cleanup': CLEANUP, 'activate': ACTIVATE,
          'deactivate': DEACTIVATE}
SERVICES = ('capture', 'finish', 'save', 'reset', 'remove_last_view', 'pause')


def _refuses_what_is_illegal(client: Client, state: str) -> None:
    for transition in ALL:
        if LABELS.get(transition, transition) in LEGAL[state] or (
                transition == SHUTDOWNS.get(state)):
            continue
        assert not client.change(transition), (state, transition)
        assert client.state() == state, transition


def _asks_all(client: Client) -> dict[str, tuple[bool, str]]:
    """Call every service; each answers within a second, with a sentence."""
    answers = {}
    for name in SERVICES:
        began = time.monotonic()
        answers[name] = client.ask(name, False if name == 'pause' else None)
        assert time.monotonic() - began < 1.0, name
        assert ' ' in answers[name][1], name
    return answers


def test_every_transition_and_every_service_in_every_state(tmp_path):
    with station(tmp_path, {'autostart': False}, state='unconfigured') as (process, client):
        events = client.collect(TransitionEvent, f'{NODE}/transition_event', RELIABLE)
        for state, transition in (
                ('unconfigured', CONFIGURE), ('inactive', ACTIVATE), ('active', DEACTIVATE),
                ('inactive', CLEANUP), ('unconfigured', 'configure'), ('inactive', 'activate')):
            _refuses_what_is_illegal(client, state)
            answers = _asks_all(client)
            assert answers['save'][0] == (state != 'unconfigured'), answers
            assert not answers['finish'][0] and not answers['remove_last_view'][0]
            assert answers['capture'][0] == (state == 'active'), answers
            if state == 'unconfigured':
                assert 'configure' in answers['reset'][1]
            assert client.change(transition), transition
            assert client.state() == LEGAL[state][LABELS.get(transition, transition)]
        assert client.change('shutdown')
        _refuses_what_is_illegal(client, 'finalized')
        assert not any(success for success, _ in _asks_all(client).values())
        assert process.code is None
        assert {event.goal_state.label for event in events} >= {
            'configuring', 'inactive', 'activating', 'active', 'finalized'}


@pytest.mark.parametrize('state', list(SHUTDOWNS))
def test_shutdown_from_every_state(tmp_path, state):
    with station(tmp_path, {'autostart': state == 'active'},
                 state='active' if state == 'active' else 'unconfigured') as (_, client):
        if state == 'inactive':
            assert client.change(CONFIGURE)
        assert client.change(SHUTDOWNS[state])
        assert client.state() == 'finalized'


def test_services_answer_while_a_transition_is_under_way(tmp_path):
    """Configuring the first time loads all that registration needs; nobody waits for that."""
    with station(tmp_path, {'autostart': False}, state='unconfigured') as (_, client):
        done = []
        with Client('another') as other:
            other.state()
            for name in SERVICES:  # discovery is no part of what is measured
                client.ask(name, False if name == 'pause' else None)
            thread = threading.Thread(target=lambda: done.append(other.change(CONFIGURE)))
            thread.start()
            states, rounds = set(), 0
            while not done:
                _asks_all(client)
                states.add(client.state())
                rounds += 1
            thread.join()
        assert done == [True]
        assert 'configuring' in states and rounds > 0
        assert client.state() == 'inactive'


def test_of_two_requests_at_once_one_is_refused_or_comes_second(tmp_path):
    with station(tmp_path, {'autostart': False}, state='unconfigured') as (_, client):
        with Client('another') as other:
            other.state()
            answers = []
            threads = [
                threading.Thread(target=lambda one=one: answers.append(one.change(CONFIGURE)))
                for one in (client, other)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        assert sorted(answers) == [False, True]
        assert client.state() == 'inactive'


def test_a_folder_that_cannot_be_written_leaves_it_unconfigured(tmp_path):
    blocked = tmp_path / 'file'
    blocked.write_text('no folder', encoding='utf-8')
    with station(blocked, {'autostart': False}, state='unconfigured') as (process, client):
        for _ in range(2):
            assert not client.change(CONFIGURE)
            assert client.state() == 'unconfigured'
        assert str(blocked) in process.says('configuring failed')


def test_autostart_that_fails_leaves_a_node_that_answers(tmp_path):
    blocked = tmp_path / 'file'
    blocked.write_text('no folder', encoding='utf-8')
    with station(blocked, state='unconfigured') as (process, client):
        process.says('configuring failed')
        assert not client.ask('save')[0]


def test_two_stations_in_namespaces(tmp_path):
    left, right = '/left/rops_registration', '/right/rops_registration'
    with (station(tmp_path / 'left', remap={'__ns': '/left'}, node=left) as (_, client),
          station(tmp_path / 'right', remap={'__ns': '/right'}, node=right) as (_, other)):
        assert client.ask('save', node=left)[0] and other.ask('save', node=right)[0]
        assert client.change(DEACTIVATE, left)
        assert (client.state(left), client.state(right)) == ('inactive', 'active')
        assert str(tmp_path / 'right') in other.ask('save', node=right)[1]


def test_available_transitions_are_those_of_the_state(tmp_path):
    with station(tmp_path) as (_, client):
        found = client.call(
            GetAvailableTransitions, f'{NODE}/get_available_transitions').available_transitions
        assert {item.transition.label for item in found} == {'deactivate', 'shutdown'}
