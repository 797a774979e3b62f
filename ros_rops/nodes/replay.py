# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Play a recording into the topics of a station, in step with it or by the recorded clock."""

from collections.abc import Sequence
from pathlib import Path
import sys
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from ros_rops.core.errors import InputError, ParameterError, RopsError
from ros_rops.core.groups_replay import ReplayConfig, topics_of
from ros_rops.core.parameter import describe_group
from ros_rops.nodes.declaring import declare, given_values
from ros_rops.nodes.replay_clock import ByClock
from ros_rops.nodes.replay_lock_step import LockStep
from ros_rops.nodes.replay_outlets import EndedError, Outlets, Pump
from ros_rops.nodes.replay_voice import NoReplyError, Voice
from ros_rops.recordings.playback import open_playback, Playback
from std_srvs.srv import Trigger

NAME = 'rops_replay'
DONE, FAILED, MISTAKE = 0, 1, 2
"""Exit codes: as of `rops replay`."""


class Replay:
    """
    A replay from the first frame to the last.

    Parameters
    ----------
    node : Node
    config : ReplayConfig
    pump : Pump
    """

    def __init__(self, node: Node, config: ReplayConfig, pump: Pump) -> None:
        self._node, self._config, self._pump = node, config, pump
        self._logger = node.get_logger()

    def run(self) -> None:
        """
        Play the recording as often as asked for, then call the services that are asked for.

        Raises
        ------
        InputError
            If the recording cannot be read.
        NoReplyError
            If no station listens or answers.
        """
        path = Path(self._config.recording).expanduser()
        with open_playback(
                path, topics_of(self._config),
                start_offset_s=self._config.start_offset_s) as playback:
            for note in playback.notes:
                self._logger.warning(note)
            self._play(playback)
        for service in ('finish', 'save'):
            if getattr(self._config, service):
                self._call(service)

    def _play(self, playback: Playback) -> None:
        config = self._config
        outlets = Outlets(
            self._node, self._pump, playback, tf=config.tf, clock=config.mode == 'clock')
        whole = playback.count is not None and not config.start_offset_s
        voice = Voice(
            self._node, playback, (playback.count or 0) * config.loops if whole else None)
        mode = (
            ByClock(self._pump, playback, outlets, config, voice) if config.mode == 'clock'
            else LockStep(self._node, self._pump, playback, outlets, config, voice))
        outlets.send_static(playback)
        self._wait(outlets)
        count, sent = 0, -1
        while (not config.loops or count < config.loops) and sent < voice.tally.sent:
            count, sent = count + 1, voice.tally.sent
            mode.play()
        if config.mode == 'clock':
            outlets.wait_for_arrival()
        self._sum_up(voice)

    def _wait(self, outlets: Outlets) -> None:
        topic = outlets.frames.topic_name
        self._logger.info(f'waiting for a station to listen on {topic}')
        if not outlets.wait_for_listeners(self._config.wait_s):
            raise NoReplyError(
                f'nobody listens on {topic} (wait_s = {self._config.wait_s:g} s); is the station '
                'active, in the same namespace and ROS_DOMAIN_ID, and its input.kind as the '
                'recording?')

    def _sum_up(self, voice: Voice) -> None:
        tally = voice.tally
        text = f'{tally.sent} frames sent'
        if tally.bad:
            text += f', {tally.bad} could not be'
        if tally.late:
            text += (f', {tally.late} of them behind their time (up to {tally.worst_s:.3f} s); a '
                     'smaller rate helps')
        self._logger.info(text)

    def _call(self, service: str) -> None:
        client = self._node.create_client(Trigger, f'{self._config.station}/{service}')
        if not self._pump.until(client.service_is_ready, self._config.wait_s):
            raise NoReplyError(f'{client.srv_name}: there is no such service (parameter station)')
        future = client.call_async(Trigger.Request())
        if not self._pump.until(future.done, self._config.reply_timeout_s):
            raise NoReplyError(f'{client.srv_name}: no answer')
        answer = future.result()
        if not answer.success:
            raise NoReplyError(f'{client.srv_name}: {answer.message}')
        self._logger.info(f'{client.srv_name}: {answer.message}')


def run_replay(args: Sequence[str] | None = None) -> int:
    """
    Run the node to the end of the recording; the caller has called `hold_signals`.

    Returns
    -------
    int
        The process's exit code: 0 when all was played or a signal ended it, 1 when no station
        listened or answered, 2 for a recording or a parameter that cannot be.
    """
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy tells by its own errors what is wrong with --ros-args
        sys.stderr.write(f'{error}\n')
        return MISTAKE
    node = Node(NAME, automatically_declare_parameters_from_overrides=True)
    executor = SingleThreadedExecutor()
    try:
        return _played(node, executor)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def _played(node: Node, executor: SingleThreadedExecutor) -> int:
    try:
        config = _configured(node)
        if not config.recording:
            raise ParameterError('recording: must be given')
        Replay(node, config, Pump(node, executor)).run()
        return DONE
    except EndedError:
        return DONE
    except RopsError as error:
        node.get_logger().error(str(error))
        return MISTAKE if isinstance(error, (InputError, ParameterError)) else FAILED


def _configured(node: Node) -> ReplayConfig:
    """Declare the parameters, and return their values."""
    infos = list(describe_group(ReplayConfig))
    given: dict[str, Any] = given_values(node, infos)
    config = ReplayConfig(**given)
    names = [info.name for info in infos]
    declare(node, infos, {name: getattr(config, name) for name in names}, read_only=names)
    return config
