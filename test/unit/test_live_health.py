# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Words on views and on the station. Truth: the rules of their levels, written down here."""

from types import SimpleNamespace

from msg_adapters import diagnostics
from msg_adapters.diagnostics import Health, Level, text_of
import pytest
from ros_rops.core.types import Status
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.live.health import (
    frame_health, gone_health, Inlet, Lately, station_health, view_health)
from ros_rops.live.words import StationState
from ros_rops.pipeline.reports import ViewReport

VIEWS = Inlet('/views', 1, 'reliable')


@pytest.mark.parametrize(('status', 'object_id', 'level', 'message'), [
    (Status.PLACED, 2, Level.OK, 'Placed in object 2: fits.'),
    (Status.PENDING, None, Level.WARN, 'Pending: fits.'),
    (Status.AMBIGUOUS, None, Level.WARN, 'Ambiguous: fits.'),
    (Status.REFUSED, None, Level.ERROR, 'Refused: fits.')])
def test_word_on_a_view(status, object_id, level, message):
    health = view_health(ViewReport('v@1', status, object_id, 'fits', {'score': 0.5}), 'eye', 7)
    assert (health.name, health.level, health.message, health.hardware_id) == (
        'v@1', level, message, 'eye')
    assert health.values['status'] == status.value and health.values['view_id'] == 7
    assert health.values.get('object_id') == object_id and health.values['score'] == 0.5


@pytest.mark.parametrize(('word', 'level'), [
    (Word.SKIPPED, Level.OK), (Word.EMPTY, Level.WARN), (Word.BAD, Level.ERROR)])
def test_word_on_a_frame_without_views(word, level):
    health = frame_health(FrameReport('v@1', word, 'the queue is full'), 'eye')
    assert (health.level, health.hardware_id) == (level, 'eye')
    assert health.message == f'{word.value.capitalize()}: the queue is full.'


def test_word_on_a_view_taken_back():
    assert gone_health('v', 'eye').values == {'status': 'removed'}


def _healths(state=None, lifecycle='active', inlets=(VIEWS,), lately=None, values=None):
    state = state or StationState(journal='whole')
    found = station_health(state, lifecycle, inlets, lately or Lately(), values or {})
    return {item.name: item for item in found}


def test_all_is_well():
    found = _healths(values={'note': 'x'})
    assert list(found) == ['input', 'queue', 'registration', 'journal']
    assert {item.level for item in found.values()} == {Level.OK}
    assert found['input'].values['note'] == 'x'
    assert found['input'].values['/views'] == '1 publisher, reliable'
    for item in found.values():
        assert item.message[0].isupper() and item.message.endswith('.')


@pytest.mark.parametrize(('given', 'level', 'part'), [
    ({'inlets': [Inlet('/views', 0, 'reliable')]}, Level.WARN, 'nobody publishes /views'),
    ({'inlets': [VIEWS, Inlet('/facts', 0, 'reliable', needed=False)]}, Level.OK, 'listening'),
    ({'inlets': [Inlet('/views', 1, '', 'best effort offered')]}, Level.ERROR, 'best effort'),
    ({'lifecycle': 'inactive', 'inlets': []}, Level.OK, 'not listening: the node is inactive'),
    ({'state': StationState(paused=True)}, Level.WARN, 'paused'),
    ({'state': StationState(words={'bad': 2})}, Level.WARN, '2 of them could not be read')])
def test_input(given, level, part):
    health = _healths(**given)['input']
    assert health.level is level and part in health.message.lower()


@pytest.mark.parametrize(('dropped', 'lately', 'level', 'message'), [
    (0, False, Level.OK, '1 frame and 2 views waiting.'),
    (3, False, Level.OK, '1 frame and 2 views waiting; 3 frames dropped so far: the queue was '
     'full.'),
    (3, True, Level.WARN, '1 frame and 2 views waiting; 3 frames dropped so far: the queue was '
     'full.')])
def test_queue(dropped, lately, level, message):
    state = StationState(waiting_frames=1, waiting_views=2, dropped=dropped)
    health = _healths(state, lately=Lately(dropped=lately, longest_wait_s=0.25))['queue']
    assert (health.level, health.message) == (level, message)
    assert health.values['longest_wait_ms'] == 250.0 and health.values['dropped'] == dropped


@pytest.mark.parametrize(('errors', 'failed', 'level'), [
    (0, False, Level.OK), (1, False, Level.WARN), (1, True, Level.ERROR)])
def test_registration(errors, failed, level):
    state = StationState(
        doing='refining', doing_s=12.3, objects=2, statuses={'placed': 5, 'pending': 0},
        errors=errors, last_error='disk full' if errors else '')
    health = _healths(state, lately=Lately(failed=failed))['registration']
    assert health.level is level
    assert health.message.startswith('Refining for 12 s; 2 objects, views: 5 placed')
    assert ('disk full' in health.message) == bool(errors)


@pytest.mark.parametrize(('journal', 'level'), [
    ('whole', Level.OK), ('none', Level.OK), ('no space left', Level.ERROR)])
def test_journal(journal, level):
    health = _healths(StationState(journal=journal, folder='there'))['journal']
    assert health.level is level and health.values['folder'] == 'there'


@pytest.mark.parametrize(('value', 'text'), [
    ('as it is', 'as it is'), (3, '3'), (3.0, '3'), (0.123456789, '0.123457'),
    (float('nan'), 'nan'), (float('inf'), 'inf'), (1e20, '100000000000000000000')])
def test_values_as_text(value, text):
    assert text_of(value) == text


def test_filling_a_status():
    status = SimpleNamespace(OK=b'\0', WARN=b'\1', ERROR=b'\2')
    diagnostics.fill(status, SimpleNamespace, Health('n', Level.WARN, 'm', {'k': 2.0}, 'h'))
    assert (status.level, status.name, status.message, status.hardware_id) == (
        b'\1', 'n', 'm', 'h')
    assert [(item.key, item.value) for item in status.values] == [('k', '2')]


def test_a_name_that_is_no_unicode_is_sent_all_the_same():
    status = SimpleNamespace(OK=b'\0')
    diagnostics.fill(status, SimpleNamespace, Health('a\udcff', Level.OK, 'b', {'c': 'd\udcff'}))
    assert (status.name, status.values[0].value) == ('a?', 'd?')
