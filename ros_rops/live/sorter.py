# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The thread that looks at messages: decode, select, segment, journal, hand on."""

from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
import time

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.core.node_config import NodeConfig
from ros_rops.intake.admission import Admission, Admitted
from ros_rops.intake.journal import JOURNAL_NAME
from ros_rops.intake.ledger import told
from ros_rops.intake.past import Entry, set_aside
from ros_rops.intake.reports import FrameReport, without_figures, Word
from ros_rops.intake.sensor_poses import Lookup
from ros_rops.live.board import Board
from ros_rops.live.inbox import Inbox, Item, Kind
from ros_rops.live.inputs import frames_of, header_of
from ros_rops.live.run import LiveRun
from ros_rops.live.tasks import Arrival, Begin, Command, Configure, Count, Place, Recall, Tasks
from ros_rops.live.voice import Voice
from ros_rops.recordings.messages import RawMessage
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.view_facts import FACTS_TOPIC

WHY = {
    Kind.FULL: 'the queue is full', Kind.PAUSED: 'the station is paused',
    Kind.DROPPED: 'the queue was full, and newer frames came'}
FACTS_FRAME = 'view_facts'
"""What the word on facts has in place of a frame."""


@dataclass(frozen=True, slots=True)
class Capture:
    """Take the next frame that arrives."""


@dataclass(frozen=True, slots=True)
class Reset:
    """End the run and begin another."""


class Sorter:
    """
    Gives every message its word, or hands the views that it gave on to the worker.

    Parameters
    ----------
    inbox : Inbox
    tasks : Tasks
    run : LiveRun
    config, node : Config, NodeConfig
    background : Frame or None
    lookup : callable or None
        As for `Intake.begin`.
    voice : Voice
    board : Board
    next_run : callable
        Begins the run after a reset.
    """

    def __init__(
        self, inbox: Inbox, tasks: Tasks, run: LiveRun, config: Config, node: NodeConfig,
        background: Frame | None, lookup: Lookup | None, voice: Voice, board: Board,
        next_run: Callable[[Config], LiveRun],
    ) -> None:
        self._inbox, self._tasks, self._run, self._config = inbox, tasks, run, config
        self._node, self._background, self._lookup = node, background, lookup
        self._voice, self._board, self._next_run = voice, board, next_run
        self._frames = frames_of(node)
        self._arrivals: deque[Arrival] = deque()
        self._captures: deque[int] = deque()
        self._counts: dict[Word, Counter[str]] = {}
        self._last = (0, time.monotonic())
        self._admission = self._new_admission()

    def run(self) -> None:
        """Work until the inbox is closed and empty."""
        self._recall()
        while not self._inbox.closed:
            item = self._inbox.get(self._patience())
            try:
                if item is not None:
                    self._look_at(item)
                self._flush()
            except Exception as error:  # a mistake of ours must not end the station
                self._give_up(f'messages could not be looked at: {told(error)}')
        self._journal_counts()
        self._run.close_journal()

    @property
    def broken(self) -> str:
        """Why the journal cannot be written any more; empty while it can."""
        return self._admission.journal.broken

    def _new_admission(self) -> Admission:
        admission = Admission(
            self._config, background=self._background, threads=self._node.node.threads,
            endless=True)
        admission.begin(self._lookup)
        return admission

    def _recall(self) -> None:
        """Hand on what the journal holds, then open it behind that."""
        past = self._run.past
        if past is None:
            self._admission.journal = self._run.journal()
            return
        damage = ''
        try:
            for entry in past:
                self._recall_entry(entry)
            damage = past.damage
        except Exception as error:  # what was read so far stands
            damage = told(error)
        note = ''
        if damage or past.torn:
            note = (f'{JOURNAL_NAME}: the last {past.torn} bytes are left out: '
                    f'{damage or "the entry was not finished"}')
        self._tasks.put(Recall(note=note))
        if not damage or self._set_aside():
            self._admission.journal = self._run.journal()

    def _recall_entry(self, entry: Entry) -> None:
        if entry.report is not None:
            self._admission.recall(entry.report, entry.views)
        self._board.recall(entry)
        taken_back = entry.command == 'remove_last_view'
        self._board.admit(len(entry.views) - taken_back)
        self._tasks.put(Recall(entry))

    def _set_aside(self) -> bool:
        """Keep a damaged journal whole; tell whether it can be gone on with."""
        path = self._run.folder / JOURNAL_NAME
        try:
            set_aside(path)
        except OSError as error:
            # To go on with it would cut that off.
            journal = self._admission.journal
            journal.broken = f'it is damaged, and cannot be copied ({error.strerror or error})'
            self._board.fail(f'{path}: {journal.broken}')
            return False
        return True

    def _patience(self) -> float | None:
        due = self._frames.due_ns
        return None if due is None else max(0.0, (due - self._now_ns()) * 1e-9)

    def _now_ns(self) -> int:
        """Return the time by the clock of the log times, which need not be the system's."""
        log_time_ns, seen_s = self._last
        return log_time_ns + int((time.monotonic() - seen_s) * 1e9)

    def _flush(self) -> None:
        due = self._frames.due_ns
        if due is not None and (self._now_ns() >= due or self._inbox.closed):
            for outcome in self._frames.flush(max(due, self._now_ns())):
                self._decide(outcome)

    def _look_at(self, item: Item) -> None:
        if item.kind is Kind.COMMAND:
            self._obey(item)
        elif item.raw is None:
            return
        elif item.kind in WHY:
            self._refuse(item.kind, item.raw, self._arrival(item, item.raw))
        else:
            self._last = (item.raw.log_time_ns, item.at_s)
            self._read(item, item.raw)

    def _arrival(self, item: Item, raw: RawMessage) -> Arrival:
        return Arrival(item.number, item.at_s, time.monotonic(), *header_of(raw))

    def _read(self, item: Item, raw: RawMessage) -> None:
        if item.kind is Kind.FRAME:
            self._arrivals.append(self._arrival(item, raw))
        for outcome in self._frames.add(raw):
            self._decide(outcome)
        if raw.channel.topic == FACTS_TOPIC:
            now = time.monotonic()
            self._voice.handled(None, Arrival(item.number, item.at_s, now, 0, FACTS_FRAME))

    def _decide(self, outcome: Frame | BadView) -> None:
        arrival = self._arrivals.popleft()
        if isinstance(outcome, BadView):
            self._hand_on(self._admission.refuse(outcome.name, outcome.reason), arrival)
            return
        try:
            admitted = self._admission.admit(outcome, asked=self._is_asked(arrival))
        except Exception as error:  # whatever it is, the frames that follow are worth their word
            self._board.fail(f'{outcome.name}: {told(error)}')
            admitted = self._admission.refuse(
                outcome.name, f'it could not be segmented: {told(error)}')
        self._hand_on(admitted, arrival)

    def _is_asked(self, arrival: Arrival) -> bool:
        """Tell whether a frame is one that was asked for, once."""
        if self._captures and arrival.number > self._captures[0]:
            self._captures.popleft()
            return True
        return False

    def _refuse(self, kind: Kind, raw: RawMessage, arrival: Arrival) -> None:
        name = f'{raw.channel.topic}@{arrival.stamp_ns}'
        every = self._config.selection.method == 'every'
        if kind is Kind.FULL and (self._is_asked(arrival) or every):
            self._hand_on(self._admission.refuse(name, WHY[kind]), arrival)
        else:
            report = FrameReport(name, Word.SKIPPED, WHY[kind])
            self._hand_on(Admitted(report, counted=True), arrival)

    def _hand_on(self, admitted: Admitted, arrival: Arrival) -> None:
        word = admitted.report.word
        self._board.count(word)
        if admitted.counted:
            reason = without_figures(admitted.report.reason)
            self._counts.setdefault(word, Counter())[reason] += 1
            self._voice.handled(admitted.report, arrival)
            return
        self._board.admit(len(admitted.views))
        self._journal_counts()
        self._tasks.put(Place(admitted, arrival))
        if word is not Word.TAKEN:
            self._voice.handled(admitted.report, arrival)

    def _journal_counts(self) -> None:
        counts, self._counts = self._counts, {}
        if counts:
            self._admission.journal.count(counts)
            self._tasks.put(Count(counts))

    def _obey(self, item: Item) -> None:
        order = item.order
        if isinstance(order, Capture):
            self._captures.append(item.number)
        elif isinstance(order, Reset):
            self._reset()
        elif isinstance(order, Configure):
            self._config = order.config
            self._admission.reconfigure(order.config)
            self._tasks.put(order)
        elif isinstance(order, Command):
            self._journal_counts()
            if order.name != 'save':
                self._admission.journal.command(order.name)
            self._tasks.put(order)

    def _reset(self) -> None:
        """Begin the next run; where its folder cannot be made, this one goes on."""
        try:
            run = self._next_run(self._config)
        except InputError as error:
            self._board.fail(f'~/reset: {error}; the run goes on')
            return
        self._journal_counts()
        self._run.close_journal()
        self._run = run
        self._admission = self._new_admission()
        self._admission.journal = run.journal()
        self._board.begin()
        self._tasks.put(Begin(run))

    def _give_up(self, why: str) -> None:
        """Give the frames up that were being put together."""
        self._board.fail(why)
        self._frames = frames_of(self._node)
        while self._arrivals:
            arrival = self._arrivals.popleft()
            self._hand_on(self._admission.refuse(f'frame@{arrival.stamp_ns}', why), arrival)
