# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The live station: messages and commands in from any thread, words out to one listener."""

from dataclasses import fields
from pathlib import Path
import threading
import time

from ros_rops.core.config import Config
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.core.frame import Frame
from ros_rops.core.node_config import NodeConfig
from ros_rops.intake.run_file import Stamp
from ros_rops.intake.sensor_poses import Lookup
from ros_rops.live.board import Board
from ros_rops.live.inbox import Inbox
from ros_rops.live.inputs import background_of
from ros_rops.live.modeller import Modeller
from ros_rops.live.run import begin_run, LiveRun, resume_run
from ros_rops.live.sorter import Capture, Reset, Sorter
from ros_rops.live.tasks import Begin, Command, Configure, Place, Tasks
from ros_rops.live.voice import Voice
from ros_rops.live.warmup import warm_up
from ros_rops.live.words import Answer, Listener, StationState
from ros_rops.live.worker import Worker
from ros_rops.recordings.live_frames import live_plan
from ros_rops.recordings.messages import RawMessage
from ros_rops.recordings.topics import CLOUD, IMAGE

DYNAMIC = ('selection', 'segmentation', 'model')
"""Groups of parameters that may change while the station works."""
ONE_SHOT = ('every', 'request')
"""Ways of selection where each frame may be wanted, so that none is dropped for a newer one."""


class Station:
    """
    A session that views come to by themselves, its run folder, and three threads.

    All methods but `start` and `close` return at once, from any thread. The same frames and
    commands in the same order give the same poses as `rops replay`.

    Parameters
    ----------
    config : Config
    node : NodeConfig
    folder : Path
        The runs are below it.
    listener : Listener
        Called from the station's threads.
    lookup : callable, optional
        As for `Intake.begin`; called from one of the station's threads, may wait a little.
    """

    def __init__(
        self, config: Config, node: NodeConfig, folder: Path, listener: Listener, *,
        lookup: Lookup | None = None,
    ) -> None:
        self._config, self._node, self._parent, self._lookup = config, node, folder, lookup
        self._board = Board()
        self._voice = Voice(listener, self._board)
        plan = live_plan(node.input.kind, color=node.input.color)
        self._framing = {
            *((topic, CLOUD) for topic in plan.clouds), *((topic, IMAGE) for topic in plan.depths)}
        self._inbox = Inbox(
            node.input.most_frames, node.input.most_mb * 1_000_000,
            refuse=config.selection.method in ONE_SHOT)
        self._tasks = Tasks(node.input.most_views)
        self._accepting = False
        self._paused = False
        self._stamp: Stamp | None = None
        self._sorter: Sorter | None = None
        self._modeller = Modeller(self._board)
        self._threads: list[threading.Thread] = []

    def start(self) -> None:
        """
        Open a run folder, load what registration needs, start the threads.

        Raises
        ------
        InputError
            If the folder cannot be written, or the background is no recording.
        """
        background, self._stamp = background_of(self._node)
        run = self._open()
        try:
            warm_up(self._config, self._node.node.threads)
            self._make_threads(run, background)
        except BaseException:
            run.release()
            raise
        self._board.folder = str(run.folder)
        self._board.resuming = run.past is not None
        for thread in self._threads:
            thread.start()

    def accept(self, on: bool) -> None:
        """Take messages from now on, or none any more; what came before is worked on."""
        self._accepting = on

    def offer(self, raw: RawMessage) -> None:
        """Take a message: it waits for its turn. Never blocks nor raises."""
        try:
            if self._accepting:
                self._take(raw)
        except Exception as error:  # the caller's thread serves others too
            self._board.fail(f'a message could not be taken: {error!r}')

    def lose(self, topic: str, messages: int) -> None:
        """Note so many more messages of a topic that the middleware lost on their way here."""
        self._board.lose(topic, messages)

    def capture(self) -> Answer:
        """Take the next frame that arrives, whatever the selection says."""
        if not self._accepting:
            return Answer(False, 'the station takes no frames now: it is not active')
        if self._paused:
            return Answer(False, 'the station is paused: ~/pause with false lets it go on')
        self._inbox.put_command(Capture())
        return Answer(True, 'the next frame that arrives becomes a view')

    def finish(self) -> Answer:
        """Refine all views of each object together, after what came before."""
        if not self._may_hold_views():
            return Answer(False, 'there is no view yet to refine')
        self._inbox.put_command(Command('finish'))
        return Answer(True, f'refining{self._after()}')

    def save(self) -> Answer:
        """Write the run folder, after what came before."""
        self._inbox.put_command(Command('save'))
        return Answer(True, f'saving to {self._board.folder}{self._after()}')

    def reset(self) -> Answer:
        """End the run, and begin the next one in a folder of its own."""
        self._inbox.put_command(Reset())
        return Answer(
            True, f'a new run begins{self._after()}; {self._board.folder} keeps its views')

    def remove_last_view(self) -> Answer:
        """Take back the last view of what came before."""
        if not self._may_hold_views():
            return Answer(False, 'there is no view to take back')
        self._inbox.put_command(Command('remove_last_view'))
        self._board.admit(-1)
        return Answer(True, f'taking the last view back{self._after()}')

    def pause(self, on: bool) -> Answer:
        """Let frames go by from now on, or no longer."""
        was, self._paused = self._paused, on
        if on:
            return Answer(True, 'it was paused already' if was else 'paused: frames go by')
        return Answer(True, 'frames are taken again' if was else 'it was not paused')

    def reconfigure(self, config: Config) -> None:
        """
        Select and segment the frames that follow by other parameters; make models by them.

        Raises
        ------
        ParameterError
            If others than those of `selection`, `segmentation` and `model` differ.
        """
        for group in fields(Config):
            if group.name not in DYNAMIC and (
                    getattr(config, group.name) != getattr(self._config, group.name)):
                raise ParameterError(f'{group.name}: cannot change while the station works')
        self._config = config
        self._inbox.refuse = config.selection.method in ONE_SHOT
        self._inbox.put_command(Configure(config))

    def state(self) -> StationState:
        """Return how the station stands."""
        board = self._board
        doing, seconds = board.doing
        return StationState(
            doing, seconds, self._paused, self._inbox.frames, self._tasks.views, board.received,
            self._inbox.overflowed, board.words, board.statuses, board.objects, board.latency_s,
            board.folder, self._journal, board.last_error, board.last_save, board.errors,
            board.lost, board.resuming, board.modelling)

    def close(self, patience_s: float) -> bool:
        """
        Stop: what waits is journalled, what is being registered is registered to its end.

        Returns
        -------
        bool
            False if a thread still works after that time.
        """
        deadline = time.monotonic() + patience_s
        self._accepting = False
        self._tasks.hurry()
        self._inbox.close()
        if not self._threads:
            return True
        sorter, worker, modeller = self._threads
        sorter.join(max(0.0, deadline - time.monotonic()))
        self._tasks.stop()
        worker.join(max(0.0, deadline - time.monotonic()))
        if sorter.is_alive() or worker.is_alive():
            return False
        self._modeller.close()
        modeller.join(max(0.0, deadline - time.monotonic()))
        if modeller.is_alive():
            return False
        self._leave()
        return True

    def _make_threads(self, run: LiveRun, background: Frame | None) -> None:
        self._sorter = Sorter(
            self._inbox, self._tasks, run, self._config, self._node, background, self._lookup,
            self._voice, self._board, self._begin)
        worker = Worker(
            self._tasks, run, self._config, self._node, self._voice, self._board,
            lambda: self._journal, self._modeller)
        self._threads = [
            threading.Thread(target=target, name=name, daemon=True)
            for target, name in (
                (self._sorter.run, 'sorter'), (worker.run, 'worker'),
                (self._modeller.run, 'modeller'))]

    def _leave(self) -> None:
        """Let go of what the threads left, and say what is lost by it."""
        left = self._tasks.rest()
        for task in left:
            if isinstance(task, Begin):
                task.run.release()
        views = sum(len(task.admitted.views) for task in left if isinstance(task, Place))
        if views and self._journal != 'whole':
            self._board.fail(f'{views} views that waited are lost: no whole journal has them')

    def _take(self, raw: RawMessage) -> None:
        if (raw.channel.topic, raw.channel.kind) not in self._framing:
            self._inbox.put_companion(raw)
            return
        self._board.received += 1
        self._inbox.put_frame(raw, paused=self._paused)

    def _open(self) -> LiveRun:
        if self._node.node.resume:
            try:
                run = resume_run(self._parent, self._config, self._node)
            except InputError as error:
                self._board.fail(f'not resumed: {error}')
                run = None
            if run is not None:
                return run
        return self._begin(self._config)

    def _begin(self, config: Config) -> LiveRun:
        return begin_run(self._parent, config, self._node, self._stamp)

    @property
    def _journal(self) -> str:
        if self._sorter is None or not self._node.output.journal:
            return 'none'
        return self._sorter.broken or 'whole'

    def _may_hold_views(self) -> bool:
        return self._board.resuming or self._inbox.frames > 0 or self._board.admitted > 0

    def _after(self) -> str:
        """Return what comes first, in words."""
        waiting = self._inbox.frames + self._tasks.views
        if self._board.resuming:
            return ' when what the journal holds has been gone through'
        if waiting:
            return f' when {waiting} waiting frame{"" if waiting == 1 else "s"} had their turn'
        return ''
