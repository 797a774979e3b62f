# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of views, frames and the station: a level, a sentence, numbers."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from msg_adapters.diagnostics import Health, Level

from ros_rops.core.types import Status
from ros_rops.intake.reports import FrameReport, Word
from ros_rops.live.words import StationState
from ros_rops.pipeline.reports import ViewReport

_VIEW_LEVELS = {
    Status.PLACED: Level.OK, Status.PENDING: Level.WARN, Status.AMBIGUOUS: Level.WARN,
    Status.REFUSED: Level.ERROR}
_FRAME_LEVELS = {
    Word.TAKEN: Level.OK, Word.SKIPPED: Level.OK, Word.EMPTY: Level.WARN, Word.BAD: Level.ERROR}


@dataclass(frozen=True, slots=True)
class Inlet:
    """
    A topic that the node listens to.

    Parameters
    ----------
    topic : str
        As it is on the wire, after remapping.
    publishers : int
        Those that are there now.
    how : str
        How it is listened to: its reliability.
    fault : str
        A sentence on what is wrong with it and what to change, such as a QoS that does not match;
        '' if nothing is.
    needed : bool
        Whether nothing can be done without it.
    """

    topic: str
    publishers: int
    how: str = ''
    fault: str = ''
    needed: bool = True


def view_health(report: ViewReport, frame_id: str, number: int) -> Health:
    """Return the word on a view: OK if it is placed, WARN while it is not, ERROR if refused."""
    place = '' if report.object_id is None else f' in object {report.object_id}'
    where = {} if report.object_id is None else {'object_id': report.object_id}
    return Health(
        report.name, _VIEW_LEVELS[report.status],
        _sentence(f'{report.status.value}{place}', report.reason),
        {'status': report.status.value, **where, 'view_id': number, **report.numbers}, frame_id)


def gone_health(name: str, frame_id: str) -> Health:
    """Return the word on a view that was taken back."""
    return Health(name, Level.WARN, 'Removed: taken back.', {'status': 'removed'}, frame_id)


def frame_health(report: FrameReport, frame_id: str) -> Health:
    """Return the word on a frame or message that gave no view."""
    return Health(
        report.name, _FRAME_LEVELS[report.word], _sentence(report.word.value, report.reason),
        {'status': report.word.value, **report.numbers}, frame_id)


@dataclass(frozen=True, slots=True)
class Lately:
    """
    What is known beside the station's own state.

    Parameters
    ----------
    dropped, failed, lost : bool
        Whether frames were dropped, anything failed that should not, or the middleware lost
        messages, within the last minute.
    longest_wait_s : float
        The longest that a frame waited to be looked at, since the session began.
    """

    dropped: bool = False
    failed: bool = False
    lost: bool = False
    longest_wait_s: float = 0.0


def station_health(
    state: StationState, lifecycle: str, inlets: Iterable[Inlet],
    lately: Lately, values: Mapping[str, str | float],
) -> Iterator[Health]:
    """
    Yield the words on the station: input, queue, registration, journal.

    Parameters
    ----------
    state : StationState
    lifecycle : str
        'unconfigured', 'inactive', 'active' or 'finalized'.
    inlets : iterable of Inlet
        Topics that the node listens to now.
    lately : Lately
    values : mapping of str to str, int or float
        More of the input.
    """
    heard = _input(state, lifecycle, tuple(inlets), lately)
    yield replace(heard, values={**heard.values, **values})
    yield _queue(state, lately)
    yield _registration(state, lately)
    yield _journal(state)


def _input(
    state: StationState, lifecycle: str, inlets: tuple[Inlet, ...], lately: Lately
) -> Health:
    faults = [inlet.fault for inlet in inlets if inlet.fault]
    silent = [inlet.topic for inlet in inlets if inlet.needed and not inlet.publishers]
    level, text = Level.OK, f'listening, {_count(state.received, "frame")} so far'
    if faults:
        level, text = Level.ERROR, '; '.join(faults)
    elif lifecycle != 'active':
        text = f'not listening: the node is {lifecycle}'
    elif state.paused:
        level, text = Level.WARN, 'paused: frames are not taken until ~/pause is called with false'
    elif silent:
        level, text = Level.WARN, f'nobody publishes {", ".join(silent)}'
    bad = state.words.get('bad', 0)
    if bad and level is Level.OK:
        level, text = Level.WARN, f'{text}; {_count(bad, "of them")} could not be read'
    if state.lost:
        lost = ', '.join(f'{count} of {topic}' for topic, count in state.lost.items())
        text = f'{text}; lost by the middleware before they came here: {lost}'
        level = Level.WARN if lately.lost and level is Level.OK else level
    return Health('input', level, _sentence(text), {
        'lifecycle': lifecycle, 'paused': str(state.paused).lower(), 'received': state.received,
        'lost': sum(state.lost.values()),
        **{f'frames_{word}': count for word, count in state.words.items()},
        **{inlet.topic: f'{_count(inlet.publishers, "publisher")}, {inlet.how}'
           for inlet in inlets}})


def _queue(state: StationState, lately: Lately) -> Health:
    text = (f'{_count(state.waiting_frames, "frame")} and {_count(state.waiting_views, "view")} '
            'waiting')
    if not state.waiting_frames and not state.waiting_views:
        text = 'nothing is waiting'
    level = Level.OK
    if state.dropped:
        text += f'; {_count(state.dropped, "frame")} dropped so far: the queue was full'
    if lately.dropped:
        level = Level.WARN
    return Health('queue', level, _sentence(text), {
        'waiting_frames': state.waiting_frames, 'waiting_views': state.waiting_views,
        'dropped': state.dropped, 'longest_wait_ms': 1e3 * lately.longest_wait_s})


def _registration(state: StationState, lately: Lately) -> Health:
    doing = f'{state.doing} for {state.doing_s:.0f} s' if state.doing else 'idle'
    if state.modelling:
        doing = f'{doing}; making models: {state.modelling}'
    text = f'{doing}; {_count(state.objects, "object")}, views: {_listed(state.statuses)}'
    level = Level.OK
    if state.last_error:
        text = f'{text}; {_count(state.errors, "error")}, the last: {state.last_error}'
        level = Level.ERROR if lately.failed else Level.WARN
    return Health('registration', level, _sentence(text), {
        'doing': state.doing, 'doing_s': state.doing_s, 'objects': state.objects,
        **{f'views_{status}': count for status, count in state.statuses.items()},
        'latency_s': state.latency_s, 'errors': state.errors, 'last_error': state.last_error,
        'last_save': state.last_save, 'modelling': state.modelling})


def _journal(state: StationState) -> Health:
    if state.journal == 'whole':
        level, text = Level.OK, f'every view is on disk in {state.folder}'
    elif state.journal == 'none':
        level, text = Level.OK, 'no journal is kept: what is not saved is lost when the node ends'
    else:
        level, text = Level.ERROR, f'broken off, what follows is not on disk: {state.journal}'
    return Health('journal', level, _sentence(text), {
        'journal': state.journal, 'folder': state.folder})


def _listed(counts: Mapping[str, int]) -> str:
    return ', '.join(f'{count} {word}' for word, count in counts.items() if count) or 'none'


def _count(number: int, what: str) -> str:
    return f'{number} {what}{"" if number == 1 or " " in what else "s"}'


def _sentence(*parts: str) -> str:
    text = ': '.join(part for part in parts if part).rstrip('.')
    return f'{text[:1].upper()}{text[1:]}.'
