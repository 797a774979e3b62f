# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Transitions of a lifecycle node, one at a time; what is asked against the rules is refused.

rclpy lets an illegal request end the process, and tells nobody why a callback failed.
"""

from collections.abc import Callable
import threading
import traceback
from typing import Any

from lifecycle_msgs.msg import Transition
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import Executor
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.task import Future
from ros_rops.core.errors import RopsError

SHUTDOWNS = (
    Transition.TRANSITION_UNCONFIGURED_SHUTDOWN, Transition.TRANSITION_INACTIVE_SHUTDOWN,
    Transition.TRANSITION_ACTIVE_SHUTDOWN)
FINALIZED = 'finalized'


class CarefulLifecycleNode(LifecycleNodeMixin, Node):
    """
    A lifecycle node that answers every request for a transition, in every state.

    Attributes
    ----------
    last_failure : str
        Why the last transition that failed did; empty after one that went well.
    """

    def __init__(self, name: str, **kwargs: Any) -> None:
        Node.__init__(self, name, **kwargs)
        # States can be asked for while a transition is under way.
        LifecycleNodeMixin.__init__(self, callback_group=ReentrantCallbackGroup())
        self._service_change_state.callback = self._on_change_state
        self._moving = threading.Lock()
        self.last_failure = ''

    @property
    def label(self) -> str:
        """Return the state's name, such as `active` or `configuring`."""
        return str(self._state_machine.current_state[1])

    def move(self, *triggers: Callable[[], TransitionCallbackReturn]) -> bool:
        """Go through transitions, after one that is under way; stop at one that fails."""
        with self._moving:
            return all(trigger() == TransitionCallbackReturn.SUCCESS for trigger in triggers)

    def tried(self, step: Callable[[], None], what: str) -> TransitionCallbackReturn:
        """Take a step of a transition; say what went wrong, if it did."""
        try:
            step()
        except (RopsError, OSError) as error:
            self.last_failure = f'{what} failed: {error}'
            self.get_logger().error(self.last_failure)
            return TransitionCallbackReturn.FAILURE
        except Exception:
            self.last_failure = f'{what} failed: {traceback.format_exc()}'
            self.get_logger().error(self.last_failure)
            return TransitionCallbackReturn.ERROR
        self.last_failure = ''
        return TransitionCallbackReturn.SUCCESS

    async def _on_change_state(self, request: Any, response: Any) -> Any:
        response.success = False
        if not self._moving.acquire(blocking=False):
            self.get_logger().warning('asked for a transition while one is under way; refused')
            return response
        # In a thread of its own: the executor serves others meanwhile.
        succeeded: Future = Future()
        threading.Thread(
            target=self._go, args=(request.transition, succeeded, self.executor),
            name='transition', daemon=True).start()
        response.success = await succeeded
        return response

    def _go(self, asked: Transition, succeeded: Future, executor: Executor | None) -> None:
        """Go through a transition that was asked for, and let the executor answer."""
        success = False
        try:
            trigger = self._trigger(asked)
            success = trigger is not None and trigger() == TransitionCallbackReturn.SUCCESS
        except Exception as error:  # ROS went down meanwhile
            self.last_failure = f'transition failed: {error!r}'
        finally:
            self._moving.release()
            succeeded.set_result(success)
            if executor is not None:
                executor.wake()

    def _trigger(self, asked: Transition) -> Callable[[], TransitionCallbackReturn] | None:
        """Return what goes through a transition; None if the state does not have it."""
        for number, label, *_ in self._state_machine.available_transitions:
            # As rclpy and rclcpp do: the label counts if there is one.
            if label == asked.label if asked.label else number == asked.id:
                return {
                    Transition.TRANSITION_CONFIGURE: self.trigger_configure,
                    Transition.TRANSITION_ACTIVATE: self.trigger_activate,
                    Transition.TRANSITION_DEACTIVATE: self.trigger_deactivate,
                    Transition.TRANSITION_CLEANUP: self.trigger_cleanup,
                    **dict.fromkeys(SHUTDOWNS, self.trigger_shutdown),
                }.get(number)
        self.get_logger().warning(
            f'asked for the transition {asked.label or asked.id}, which a node that is '
            f'{self.label} does not have; refused')
        return None

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin anew: `last_failure` has been said."""
        return TransitionCallbackReturn.SUCCESS
