# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Frames of running sensors: as of a recording, but by the clock.

Of a recording one knows beforehand which topics hold messages; of sensors one learns it. And facts
(`view_facts`) come with a cloud whose topic has another name than the one recorded, so they are
told to belong to it by the header.
"""

from collections import deque
from collections.abc import Iterator

from ros_rops.core.frame import Frame
from ros_rops.recordings.frame_maker import FrameMaker
from ros_rops.recordings.messages import Decoder, RawMessage
from ros_rops.recordings.pairing import Entry, LONGEST_QUEUE, Pairing, WAIT_NS
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.topics import CLOUD, Plan
from ros_rops.recordings.view_facts import FACTS_TOPIC, ViewFacts

VIEWS_TOPIC = 'views'
DEPTH_TOPIC = 'depth/image'
INFO_TOPIC = 'depth/camera_info'
COLOR_TOPIC = 'color/image'
"""What the station's topics are called inside of it, whatever they are remapped to."""
LARGEST_SECONDS = 2**31
"""A header's stamp holds fewer."""


def live_plan(kind: str, *, color: bool = True) -> Plan:
    """Return what a station listens to: `kind` 'cloud' or 'depth', the latter with colour."""
    if kind == 'cloud':
        return Plan(frozenset({VIEWS_TOPIC}), facts=frozenset({FACTS_TOPIC}))
    return Plan(
        frozenset(), frozenset({DEPTH_TOPIC}), {DEPTH_TOPIC: INFO_TOPIC},
        {DEPTH_TOPIC: COLOR_TOPIC} if color else {})


class LiveFrames:
    """
    Makes frames of the messages of running sensors, named '<topic>@<stamp in ns>'.

    A frame waits at most 0.2 s for what belongs to it. What did not come is not waited for again,
    until it does come in time: a camera without colour costs no time, nor does one that sends its
    CameraInfo once.

    Parameters
    ----------
    plan : Plan
        As `live_plan` returns it.
    units, sensor : str
        As for `read_frames`.
    rectified : bool or None
        Whether depth images are undistorted already; None takes it from their topic's name.

    Raises
    ------
    ParameterError
        If `units` or `sensor` is none of the choices.
    """

    def __init__(
        self, plan: Plan, *, units: str = 'auto', sensor: str = 'auto',
        rectified: bool | None = None,
    ) -> None:
        self._maker = FrameMaker(plan, units, sensor, rectified=rectified, live=True)
        self._pairing = _LivePairing(plan)

    def add(self, raw: RawMessage) -> Iterator[Frame | BadView]:
        """Take a message, yield the frames that need not wait any longer."""
        return map(self._outcome, self._pairing.add(raw))

    def flush(self, now_ns: int) -> Iterator[Frame | BadView]:
        """Yield the frames that have waited too long, by the clock of the log times."""
        return map(self._outcome, self._pairing.flush(now_ns))

    @property
    def due_ns(self) -> int | None:
        """When `flush` will yield a frame if no message comes; None if none waits."""
        return self._pairing.due_ns

    def _outcome(self, entry: Entry) -> Frame | BadView:
        # A message whose header cannot be read has no stamp: it is the one of time 0.
        facts, topic = entry.facts, entry.raw.channel.topic
        return self._maker.outcome(entry, facts.name if facts else f'{topic}@{entry.stamp_ns}')


class _LivePairing(Pairing):
    """Learns which messages come with a frame; facts find their cloud by its header."""

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan, Decoder(), {})
        self._silent: set[str] = set()
        self._passed: deque[tuple[int, int]] = deque(maxlen=LONGEST_QUEUE)
        self._told: dict[tuple[int, str], ViewFacts] = {}
        self._facts_come = False

    def flush(self, now_ns: int) -> Iterator[Entry]:
        """Yield what has waited too long."""
        self._now = now_ns
        while self._queue and self._is_ready(self._queue[0]):
            yield self._matched(self._queue.popleft())

    @property
    def due_ns(self) -> int | None:
        """When the first of the queue has waited too long."""
        return self._queue[0].raw.log_time_ns + WAIT_NS + 1 if self._queue else None

    def _has_all(self, entry: Entry) -> bool:
        if entry.raw.channel.kind == CLOUD:
            return entry.facts is not None or not self._facts_come
        return super()._has_all(entry)

    def _awaited(self, topic: str) -> list[str]:
        return [other for other in super()._awaited(topic) if other not in self._silent]

    def _note(self, raw: RawMessage) -> None:
        """Keep a message; one that came soon after its frame is worth waiting for again."""
        super()._note(raw)
        topic = raw.channel.topic
        stamps = self._recent.get(topic, {})
        if any(stamp in stamps and abs(raw.log_time_ns - time) <= WAIT_NS
               for stamp, time in self._passed):
            self._silent.discard(topic)

    def _matched(self, entry: Entry) -> Entry:
        if entry.fault:
            return entry
        if entry.raw.channel.kind == CLOUD:
            self._facts_come = entry.facts is not None
        else:
            self._passed.append((entry.stamp_ns, entry.raw.log_time_ns))
            self._silent.update(
                other for other in self._awaited(entry.raw.channel.topic)
                if entry.stamp_ns not in self._recent.get(other, ()))
        return super()._matched(entry)

    def _facts_of(self, entry: Entry) -> ViewFacts | None:
        if entry.fault or entry.raw.channel.kind != CLOUD:
            return None
        return self._told.pop((entry.stamp_ns, entry.frame_id), None)

    def _keep_facts(self, facts: ViewFacts, time_ns: int) -> None:
        key = _header_of(facts)
        for entry in self._queue:
            if entry.facts is None and (entry.stamp_ns, entry.frame_id) == key:
                entry.facts = facts
                return
        self._told.pop(key, None)
        self._told[key] = facts
        while len(self._told) > LONGEST_QUEUE:
            del self._told[next(iter(self._told))]


def _header_of(facts: ViewFacts) -> tuple[int, str]:
    """Return stamp and frame of the message that facts belong to."""
    stamp_ns = facts.stamp_ns or 0
    writable = 0 <= stamp_ns < LARGEST_SECONDS * 1_000_000_000
    return (stamp_ns if writable else 0), facts.frame_id
