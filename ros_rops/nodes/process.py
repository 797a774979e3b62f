# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A node in a process of its own: from the command line to a clean exit."""

from collections.abc import Callable, Sequence
import os
import sys
import threading
import traceback
from typing import Protocol

import rclpy
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from ros_rops.core.errors import RopsError
from ros_rops.nodes.signals import ask_to_end, wait_for_signal

JOIN_S = 2.0


class Ends(Protocol):
    """A node that is told when its process begins and ends."""

    def begin(self) -> None:
        """Do what is to be done once the node spins; may take long."""

    def end(self) -> bool:
        """Let go of everything; return False if threads of the node still run."""


def run_node(make: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """
    Make a node that `Ends`, spin it until SIGINT or SIGTERM, and let it end.

    The caller has called `hold_signals`.

    Returns
    -------
    int
        The process's exit code: 0, 1 after a defect, 2 for parameters that cannot be.
    """
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy tells by its own errors what is wrong with --ros-args
        sys.stderr.write(f'{error}\n')
        return 2
    try:
        node = make()
    except RopsError as error:
        get_logger('ros_rops').fatal(str(error))
        rclpy.try_shutdown()
        return 2
    spinning = _Spinning(node)
    try:
        node.begin()
        wait_for_signal()
    finally:
        clean = _end(node, spinning)
    code = 1 if spinning.failed else 0
    if not clean:
        # A thread inside of a kernel must not meet an interpreter that is being taken down.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    return code


def _end(node: Node, spinning: '_Spinning') -> bool:
    clean = node.end()
    rclpy.try_shutdown()
    clean = spinning.join() and clean
    if clean:
        node.destroy_node()
    return clean


class _Spinning:
    """The thread that runs the callbacks; the main one waits for signals."""

    def __init__(self, node: Node) -> None:
        self.failed = False
        # rclpy's executor of several threads turns and turns while a callback runs, and takes the
        # interpreter from all others. No callback here takes long.
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, name='executor', daemon=True)
        self._thread.start()

    def join(self) -> bool:
        self._thread.join(JOIN_S)
        return not self._thread.is_alive()

    def _spin(self) -> None:
        try:
            self._spin_on()
        except ExternalShutdownException:
            pass
        except Exception:
            if rclpy.ok():  # else the context went while a wait began, as it should
                self.failed = True
                get_logger('ros_rops').fatal(traceback.format_exc())
                ask_to_end()

    def _spin_on(self) -> None:
        while True:
            try:
                return self._executor.spin()
            except InvalidHandle:
                # Another thread destroyed an event just as the executor began to wait for it.
                if not rclpy.ok():
                    return None
