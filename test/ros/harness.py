# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A node of ours in a process of its own, and a client of real rclpy beside it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
import contextlib
import os
from pathlib import Path
import signal
import subprocess
import sys
import threading
import time
from typing import Any

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
import rclpy
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_rops.recordings.messages import RawMessage
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.topics import CLOUD
from std_srvs.srv import SetBool, Trigger

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 30.0
"""Nothing takes so long; two loaded cores take long."""
ASK_AGAIN_S = 3.0
"""A node that is there answers in some milliseconds."""
RELIABLE = QoSProfile(depth=200, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(depth=200, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(
    depth=200, reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL)
NODE = '/rops_registration'


def wait_for(condition: Callable[[], Any], what: str, patience_s: float = PATIENCE_S) -> Any:
    """Return the first value of `condition` that is true."""
    deadline = time.monotonic() + patience_s
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < deadline, f'in vain: {what}'
        time.sleep(0.005)


def environment() -> dict[str, str]:
    """Return the environment of another process: the wheels of ROS prepare each for itself."""
    given = {
        key: value for key, value in os.environ.items()
        if key not in ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH')}
    given['PYTHONPATH'] = os.pathsep.join(filter(None, [str(ROOT), given.get('PYTHONPATH')]))
    return given


def ros_arguments(
    parameters: Mapping[str, Any] | None = None, remap: Mapping[str, str] | None = None
) -> list[str]:
    """Return the words behind a node's command."""
    words = ['--ros-args']
    for name, value in (parameters or {}).items():
        text = str(value).lower() if isinstance(value, bool) else str(value)
        words += ['-p', f'{name}:={text}']
    for old, new in (remap or {}).items():
        words += ['-r', f'{old}:={new}']
    return words


class NodeProcess:
    """
    A module of `ros_rops.nodes` in a process of its own; use as a context.

    What it writes to stdout and stderr is in `output`. It is ended by SIGINT if it still runs.
    """

    def __init__(
        self, module: str, words: Sequence[str] = (), *, expected: Sequence[int] = (0,),
        variables: Mapping[str, str] | None = None,
    ) -> None:
        self.started = time.monotonic()
        self._expected = expected
        self._lines: list[str] = []
        self._process = subprocess.Popen(
            [sys.executable, '-m', f'ros_rops.nodes.{module}', *words], stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True, env={**environment(), **(variables or {})})
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    @property
    def output(self) -> str:
        return ''.join(self._lines)

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def code(self) -> int | None:
        """Return the exit code; None while it runs."""
        return self._process.poll()

    def says(self, text: str) -> str:
        """Wait until it has said something."""
        wait_for(lambda: text in self.output or self.code is not None, f'{text!r}')
        assert text in self.output, self.output
        return self.output

    def send(self, number: int) -> None:
        self._process.send_signal(number)

    def end(self, number: int = signal.SIGINT, patience_s: float = PATIENCE_S) -> int:
        """End it by a signal, and return its exit code."""
        if self.code is None:
            self.send(number)
        return self.wait(patience_s)

    def wait(self, patience_s: float = PATIENCE_S) -> int:
        try:
            code = self._process.wait(patience_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        self._reader.join()
        self._process.stdout.close()
        return code

    def __enter__(self) -> 'NodeProcess':
        return self

    def __exit__(self, kind: type | None, *error: object) -> None:
        code = self.end()
        if kind is not None:
            sys.stdout.write(self.output)  # pytest shows it with what failed
        else:
            assert code in self._expected, self.output
            assert 'Traceback' not in self.output, self.output

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.append(line)


class Client:
    """A node that publishes, listens and calls; use as a context. Spins in its own thread."""

    def __init__(self, name: str = 'test_client', namespace: str = '') -> None:
        self._context = rclpy.Context()
        self._context.init()
        self.node = Node(name, namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()

    def __enter__(self) -> 'Client':
        return self

    def __exit__(self, *error: object) -> None:
        self._context.try_shutdown()
        self._thread.join()
        self.node.destroy_node()

    def publisher(self, kind: type, topic: str, qos: Any = RELIABLE, *, matched: int = 1) -> Any:
        """Return a publisher that so many subscriptions have found."""
        publisher = self.node.create_publisher(kind, topic, qos)
        wait_for(lambda: publisher.get_subscription_count() >= matched, f'a reader of {topic}')
        return publisher

    def collect(
        self, kind: type, topic: str, qos: Any = RELIABLE, *, matched: int = 1, raw: bool = False
    ) -> list[Any]:
        """Return a list that messages are added to, once so many publishers have been found."""
        found: list[Any] = []
        heard: list[int] = [0]
        events = SubscriptionEventCallbacks(
            matched=lambda event: heard.__setitem__(0, event.current_count))
        self.node.create_subscription(
            kind, topic, found.append, qos, event_callbacks=events, raw=raw)
        wait_for(lambda: heard[0] >= matched, f'a writer of {topic}')
        return found

    def call(
        self, kind: type, name: str, request: Any = None, patience_s: float = PATIENCE_S
    ) -> Any:
        """Call a service, and return its response."""
        client = self._client(kind, name)
        wait_for(client.service_is_ready, f'the service {name}', patience_s)
        future = client.call_async(kind.Request() if request is None else request)
        return wait_for(lambda: future.done() and future.result(), f'{name} answers', patience_s)

    def ask(self, name: str, on: bool | None = None, node: str = NODE) -> tuple[bool, str]:
        """Call one of the station's services: success and sentence."""
        full = f'{node}/{name}'
        if on is None:
            answer = self.call(Trigger, full)
        else:
            answer = self.call(SetBool, full, SetBool.Request(data=on))
        return answer.success, answer.message

    def state(self, node: str = NODE) -> str:
        """Return the label of a lifecycle node's state."""
        # On a busy machine an answer may be lost, probably since a service that does not know of
        # its client yet gives up after 0.1 s (rmw_fastrtps): the question is asked again.
        client = self._client(GetState, f'{node}/get_state')
        wait_for(client.service_is_ready, f'the service {node}/get_state')
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            future = client.call_async(GetState.Request())
            again = time.monotonic() + ASK_AGAIN_S
            while time.monotonic() < again:
                if future.done():
                    return str(future.result().current_state.label)
                time.sleep(0.005)
        raise AssertionError(f'in vain: {node}/get_state answers')

    def change(self, transition: int | str, node: str = NODE) -> bool:
        """Ask for a transition, and tell whether it went well."""
        asked = Transition(label=transition) if isinstance(transition, str) else Transition(
            id=transition)
        request = ChangeState.Request(transition=asked)
        return bool(self.call(ChangeState, f'{node}/change_state', request).success)

    def wait_state(self, label: str, node: str = NODE) -> None:
        wait_for(lambda: self.state(node) == label, f'{node} is {label}')

    def ready(self, kind: type, name: str) -> bool:
        """Tell whether a service is there."""
        return bool(self._client(kind, name).service_is_ready())

    def _client(self, kind: type, name: str) -> Any:
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
        return self._clients[name]

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()


@contextlib.contextmanager
def station(
    folder: Path, parameters: Mapping[str, Any] | None = None, *,
    remap: Mapping[str, str] | None = None, state: str = 'active', node: str = NODE,
    words: Sequence[str] = (), expected: Sequence[int] = (0,),
) -> Iterator[tuple[NodeProcess, Client]]:
    """Run the registration node until it is in a state, and a client beside it."""
    given = {
        'output.folder': folder, 'output.models': False, 'output.report': False,
        **(parameters or {})}
    arguments = [*ros_arguments(given, remap), *words]
    with NodeProcess(
            'registration_node', arguments, expected=expected) as process, Client() as client:
        wait_for(lambda: process.code is not None or client.ready(GetState, f'{node}/get_state'),
                 'the node')
        assert process.code is None, process.output
        client.wait_state(state, node)
        yield process, client


def demo_clouds(count: int | None = None) -> list[bytes]:
    """Return the messages of bags/demo.mcap, 20 views of two objects, as on the wire."""
    with open_storage(ROOT / 'bags' / 'demo.mcap') as storage:
        topics = frozenset(c.topic for c in storage.channels() if c.kind == CLOUD)
        found = [
            bytes(item.data) for item in storage.messages(topics) if isinstance(item, RawMessage)]
    return found[:count]
