# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""`rops_registration`: the live station as a lifecycle node."""

import math
import os
from pathlib import Path
import time
from typing import Any, TYPE_CHECKING

from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.core.node_config import NodeConfig
from ros_rops.live.words import Answer
from ros_rops.nodes.idle_health import IdleHealth
from ros_rops.nodes.inputs import Inputs, with_lens
from ros_rops.nodes.parameters import Settings
from ros_rops.nodes.services import Services
from ros_rops.nodes.signals import asked_again
from ros_rops.nodes.tf_input import TfInput
from ros_rops.nodes.transitions import CarefulLifecycleNode, FINALIZED

if TYPE_CHECKING:
    from ros_rops.live.station import Station
    from ros_rops.nodes.outputs import Outputs

CLEANUP_S = 30.0
"""A registration that is under way may take so long to come to its end."""
END_S = 3.5
"""And so long when the process is to end: `ros2 launch` waits for 5 s."""
STEP_S = 0.1


class RegistrationNode(CarefulLifecycleNode):
    """
    The station: topics in, session, topics and services out.

    Unconfigured it has its services and parameters; configured (inactive) it has a session and
    publishes; active it takes views.

    Raises
    ------
    ParameterError
        If it was started with parameters that cannot be.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(
            'rops_registration', automatically_declare_parameters_from_overrides=True, **kwargs)
        self._station: Station | None = None
        self._leaving: Station | None = None
        self._outputs: Outputs | None = None
        self._inputs: Inputs | None = None
        self._tf: TfInput | None = None
        self._settings = Settings(self, self._reconfigure)
        self._doors = Services(self, self._ask)
        self._idle = IdleHealth(self)
        # Of a clock that goes on when simulated time stands still.
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self._diagnose, clock=self._steady)
        self._rebroadcast: Any = None
        self._end_by = math.inf

    def begin(self) -> None:
        """Configure and activate, if that is asked for."""
        if self._settings.read()[1].node.autostart:
            self.move(self.trigger_configure, self.trigger_activate)

    def end(self) -> bool:
        """Let go of everything; tell whether all threads came to their end."""
        # A transition that is under way must not take its own time now.
        self._end_by = time.monotonic() + END_S
        if self.label != FINALIZED:
            self.move(self.trigger_shutdown)
        return self._leaving is None

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Open the run folder and make the session ready."""
        result = self.tried(self._open, 'configuring')
        if result != TransitionCallbackReturn.SUCCESS:
            self._close(0.0)
        return result

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take views."""
        return self.tried(self._listen, 'activating')

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take views no longer; those that wait are still registered."""
        return self.tried(self._stop_listening, 'deactivating')

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give the session up; its run folder keeps it."""
        return self.tried(lambda: self._close(CLEANUP_S), 'cleaning up')

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give the session up, for good."""
        return self.tried(lambda: self._close(END_S), 'shutting down')

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin anew."""
        return self.tried(lambda: self._close(0.0), 'beginning anew')

    def _open(self) -> None:
        # Here, so that services answer before scipy is imported.
        from ros_rops.live.station import Station
        from ros_rops.nodes.outputs import Outputs

        self._let_leave(CLEANUP_S)
        if self._leaving is not None:
            raise InputError('the session before is still at work; try again')
        config, own = self._settings.fix()
        self._outputs = Outputs(self, own, fixed_frame=config.prior.fixed_frame)
        self._tf = TfInput(self) if own.input.tf else None
        station = Station(
            config, with_lens(self, own), _folder(own, self.get_fully_qualified_name()),
            self._outputs, lookup=self._tf.lookup if self._tf else None)
        station.start()
        self._station = station
        self._set_rate(own)
        state = station.state()
        how = 'going on with the run in' if state.resuming else 'a new run, in'
        self.get_logger().info(f'{how} {state.folder}')

    def _listen(self) -> None:
        if self._station is None:
            raise InputError('there is no session')
        self._station.accept(True)
        config, own = self._settings.read()
        self._inputs = Inputs(self, own.input, self._station.offer, self._station.lose)
        # What must come is named first.
        inlets = sorted(self._inputs.inlets(), key=lambda inlet: not inlet.needed)
        topics = ', '.join(inlet.topic for inlet in inlets)
        self.get_logger().info(
            f'active: listening on {topics}; selection.method {config.selection.method}')

    def _stop_listening(self) -> None:
        inputs, self._inputs = self._inputs, None
        if inputs is not None:
            inputs.close()
            if self.context.ok():
                self.get_logger().info('listening no more')
        if self._station is not None:
            self._station.accept(False)

    def _close(self, patience_s: float) -> None:
        self._stop_listening()
        if self._station is not None:
            station = self._leaving = self._station
            self._station = None
            self._let_leave(patience_s)
            outputs = self._outputs
            if outputs is not None:  # what came of the last second
                self._guarded(lambda: outputs.diagnostics(station.state(), self.label))
        if self._leaving is not None:
            self.get_logger().warning(
                'a registration is under way that does not end in time; its view is in the '
                'journal')
        if self._rebroadcast is not None:
            self.destroy_timer(self._rebroadcast)
            self._rebroadcast = None
        for part in (self._tf, self._outputs):
            if part is not None:
                part.close()
        self._tf = self._outputs = None
        self._settings.free()

    def _let_leave(self, patience_s: float) -> None:
        """Wait for a station to come to its end, or for another signal to end the process."""
        deadline = time.monotonic() + patience_s
        while self._leaving is not None:
            if self._leaving.close(STEP_S):
                self._leaving = None
            elif time.monotonic() > min(deadline, self._end_by) or asked_again():
                return

    def _ask(self, name: str, *values: bool) -> Answer:
        station = self._station
        if station is None:
            return Answer(False, f'the node is {self.label}: {self._advice()}')
        answer: Answer = getattr(station, name)(*values)
        return answer

    def _advice(self) -> str:
        label = self.label
        if label == FINALIZED:
            return 'it has been shut down; start it anew'
        if label == 'unconfigured':
            return (f'it has no session yet; ros2 lifecycle set '
                    f'{self.get_fully_qualified_name()} configure begins one')
        return 'its session is being made or given up; ask again in a moment'

    def _reconfigure(self, config: Config, own: NodeConfig) -> None:
        try:
            if self._station is not None:
                self._station.reconfigure(config)
                self._set_rate(own)
            if self._outputs is not None:
                self._outputs.reconfigure(own)
        except Exception as error:  # the executor would end with it
            self.get_logger().error(f'the change of parameters failed: {error!r}')

    def _set_rate(self, own: NodeConfig) -> None:
        if self._rebroadcast is not None:
            self.destroy_timer(self._rebroadcast)
            self._rebroadcast = None
        if own.publish.tf:
            self._rebroadcast = self.create_timer(
                1.0 / own.publish.tf_rate_hz, self._broadcast, clock=self._steady)

    def _broadcast(self) -> None:
        outputs = self._outputs
        if outputs is not None:
            self._guarded(outputs.rebroadcast)

    def _diagnose(self) -> None:
        outputs, station, inputs = self._outputs, self._station, self._inputs
        extra: dict[str, str | float] = (
            {'last failure': self.last_failure} if self.last_failure else {})
        if inputs is not None:
            extra['callback_p99_ms'] = inputs.callback_p99_ms
        if outputs is None or station is None:
            self._guarded(lambda: self._idle.publish(self.label, extra))
            return
        inlets = inputs.inlets() if inputs is not None else []
        state = station.state()
        self._guarded(lambda: outputs.diagnostics(state, self.label, extra, inlets))

    def _guarded(self, call: Any) -> None:
        try:
            call()
        except Exception as error:  # the executor would end with it
            if self.context.ok():
                self.get_logger().error(f'{error!r}', throttle_duration_sec=10.0)


def _folder(own: NodeConfig, name: str) -> Path:
    if own.output.folder:
        return Path(own.output.folder).expanduser()
    home = Path(os.environ.get('ROS_HOME') or Path.home() / '.ros')
    # No name holds a minus, so no two nodes have one folder.
    return home / 'ros_rops' / name.strip('/').replace('/', '-')
