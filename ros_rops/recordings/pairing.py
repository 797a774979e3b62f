# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A depth image, its CameraInfo and its colour image, brought together from a stream."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from ros_rops.core.errors import InputError
from ros_rops.recordings.messages import Cut, Decoder, header, RawMessage, Storage
from ros_rops.recordings.topics import CLOUD, IMAGE, INFO, Plan
from ros_rops.recordings.view_facts import decode_facts, FACTS_TOPIC, ViewFacts

WAIT_NS = 200_000_000
"""A depth image waits so long, in log time, for the messages that belong to it."""
LONGEST_QUEUE = 8
"""Frames that wait at a time, whatever the time."""


class Noted(NamedTuple):
    """A message beside a depth image, decoded and raw."""

    message: Any
    raw: RawMessage


@dataclass(slots=True)
class Entry:
    """
    A message that makes a frame, and what belongs to it.

    Parameters
    ----------
    raw : RawMessage
    message : object or None
        Decoded; None if that failed.
    fault : str
        Why it failed.
    stamp_ns : int
    frame_id : str
    info, color : Noted or None
        Of a depth image.
    facts : ViewFacts or None
        What this package wrote of the frame beside the message.
    """

    raw: RawMessage
    message: Any = None
    fault: str = ''
    stamp_ns: int = 0
    frame_id: str = ''
    info: Noted | None = None
    color: Noted | None = None
    facts: ViewFacts | None = None


def first_infos(storage: Storage, plan: Plan, decoder: Decoder) -> dict[str, Noted]:
    """Return the first CameraInfo of each topic: a latched one may have been recorded late."""
    found: dict[str, Noted] = {}
    wanted = frozenset(plan.infos.values())
    for raw in storage.messages(wanted) if wanted else ():
        if isinstance(raw, Cut) or found.keys() == wanted:
            break
        try:
            found.setdefault(raw.channel.topic, Noted(decoder.decode(raw), raw))
        except InputError:
            continue
    return found


class Pairing:
    """
    A short queue of frames in the order of the recording.

    Parameters
    ----------
    plan : Plan
    decoder : Decoder
    infos : dict of str to Noted
        By topic, the first CameraInfo of the recording: used until one has been seen.
    """

    def __init__(self, plan: Plan, decoder: Decoder, infos: dict[str, Noted]) -> None:
        self._plan, self._decoder = plan, decoder
        self._queue: deque[Entry] = deque()
        self._last_info = dict(infos)
        self._recent: dict[str, dict[int, Noted]] = {}
        self._facts: dict[str, tuple[int, ViewFacts]] = {}
        self._now = 0

    def add(self, raw: RawMessage) -> Iterator[Entry]:
        """Take a message, yield the frames that need not wait any longer."""
        self._now = raw.log_time_ns
        topic, kind = raw.channel.topic, raw.channel.kind
        if (kind == CLOUD and topic in self._plan.clouds) or (
                kind == IMAGE and topic in self._plan.depths):
            self._queue.append(self._decoded(raw))
        elif kind in (INFO, IMAGE):
            self._note(raw)
        elif topic == FACTS_TOPIC:
            self._note_facts(raw)
        while self._queue and self._is_ready(self._queue[0]):
            yield self._matched(self._queue.popleft())

    def rest(self) -> Iterator[Entry]:
        """Yield what still waits, at the end of the stream."""
        while self._queue:
            yield self._matched(self._queue.popleft())

    def _decoded(self, raw: RawMessage) -> Entry:
        try:
            message = self._decoder.decode(raw)
            entry = Entry(raw, message, '', *header(message))
        except InputError as error:
            entry = Entry(raw, fault=str(error))
        entry.facts = self._facts_of(entry)
        return entry

    def _facts_of(self, entry: Entry) -> ViewFacts | None:
        """Return the facts that came before a message, if they are of its log time."""
        time, facts = self._facts.pop(entry.raw.channel.topic, (None, None))
        return None if entry.fault or time != entry.raw.log_time_ns else facts

    def _note_facts(self, raw: RawMessage) -> None:
        try:
            facts = decode_facts(bytes(raw.data))
        except InputError:
            return  # the message is then read as any other recorder's
        self._keep_facts(facts, raw.log_time_ns)

    def _keep_facts(self, facts: ViewFacts, time_ns: int) -> None:
        self._facts[facts.topic] = (time_ns, facts)

    def _note(self, raw: RawMessage) -> None:
        topic = raw.channel.topic
        try:
            noted = Noted(self._decoder.decode(raw), raw)
            stamp, _ = header(noted.message)
        except InputError:
            return  # as good as not there: the depth image will say that it lacks it
        if raw.channel.kind == INFO:
            self._last_info[topic] = noted
        recent = self._recent.setdefault(topic, {})
        recent[stamp] = noted
        while len(recent) > LONGEST_QUEUE:
            del recent[next(iter(recent))]

    def _is_ready(self, entry: Entry) -> bool:
        waited = abs(self._now - entry.raw.log_time_ns)
        return (bool(entry.fault) or len(self._queue) > LONGEST_QUEUE or waited > WAIT_NS
                or self._has_all(entry))

    def _has_all(self, entry: Entry) -> bool:
        """Return whether all has come that belongs to a message."""
        return all(
            entry.stamp_ns in self._recent.get(other, ())
            for other in self._awaited(entry.raw.channel.topic))

    def _awaited(self, topic: str) -> list[str]:
        """Return the topics that a frame's messages wait for."""
        both = self._plan.infos.get(topic), self._plan.colors.get(topic)
        return [other for other in both if other is not None]

    def _matched(self, entry: Entry) -> Entry:
        topic = entry.raw.channel.topic
        if topic not in self._plan.depths or entry.fault:
            return entry
        info = self._plan.infos.get(topic, '')
        entry.info = self._recent.get(info, {}).get(entry.stamp_ns, self._last_info.get(info))
        color = self._plan.colors.get(topic, '')
        entry.color = self._recent.get(color, {}).get(entry.stamp_ns)
        return entry
