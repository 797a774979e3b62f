# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The node's services: there in every state; they hand on what is asked and answer at once."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.node import Node
from ros_rops.live.words import Answer
from std_srvs.srv import SetBool, Trigger

TRIGGERS = ('capture', 'finish', 'save', 'reset', 'remove_last_view')
Ask = Callable[..., Answer]


class Services:
    """
    `~/capture`, `~/finish`, `~/save`, `~/reset`, `~/remove_last_view` and `~/pause`.

    Parameters
    ----------
    node : Node
    ask : callable
        Is given the service's name, and for `pause` a bool; returns the answer at once.
    """

    def __init__(self, node: Node, ask: Ask) -> None:
        self._node, self._ask = node, ask
        for name in TRIGGERS:
            node.create_service(Trigger, f'~/{name}', partial(self._trigger, name))
        node.create_service(SetBool, '~/pause', self._pause)

    def _trigger(self, name: str, _: Any, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, name)

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        return self._answer(response, 'pause', bool(request.data))

    def _answer(self, response: Any, name: str, *values: bool) -> Any:
        try:
            answer = self._ask(name, *values)
        except Exception as error:  # the executor would end with it
            answer = Answer(False, f'{name} failed: {error!r}')
            self._node.get_logger().error(answer.message)
        response.success, response.message = bool(answer.success), answer.message
        return response
