# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure the registration node from outside, as the sensor and the software beside it see it.

A node of its own, in its own process: it starts the registration node, sends it what a recording
holds, and takes the times at which topics and services answer. `rops bench station` runs it.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, cycle, islice
import json
from pathlib import Path
import sys
from tempfile import TemporaryDirectory
import time
from typing import Any

from ros_rops.nodes.meter_client import MeterClient
from ros_rops.nodes.meter_process import NodeProcess
from ros_rops.recordings.messages import Cut
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.topics import CLOUD

PATIENCE_S = 60.0
PING_S = 0.05
"""Between two calls of a service while views are registered."""


def measure_start(runs: int) -> dict[str, Any]:
    """Start the node so often; return the seconds from its command to the state active."""
    seconds = []
    for _ in range(runs):
        with (TemporaryDirectory() as folder, MeterClient() as client,
              NodeProcess(folder, {}) as node):
            client.wait_active(PATIENCE_S)
            seconds.append(time.monotonic() - node.started)
    return {'start_s': seconds}


def measure_session(clouds: list[bytes], settings: dict[str, Any]) -> dict[str, Any]:
    """Send view after view, each when the one before has its word; call a service meanwhile."""
    rows: list[dict[str, Any]] = []
    with (TemporaryDirectory() as folder, MeterClient() as client,
          NodeProcess(folder, settings) as node):
        client.wait_active(PATIENCE_S)
        client.wait_matched(PATIENCE_S)
        for cloud in clouds:
            with client.calling('pause', PING_S):
                row = client.send_and_wait(cloud, PATIENCE_S)
            rows.append({**row, 'rss_mib': node.rss_mib()})
        return {
            'views': rows, 'service_s': client.answers, 'statuses': client.statuses(),
            'peak_rss_mib': node.peak_rss_mib(), 'diagnostics': client.diagnostics}


def measure_stream(
    frames: list[bytes], rate_hz: float, seconds: float, stop: 'Stop', settings: dict[str, Any]
) -> dict[str, Any]:
    """Send frames at a fixed rate, whatever the node does with them."""
    settings = {'selection.method': 'still', 'publish.skipped': True, **settings}
    with (TemporaryDirectory() as folder, MeterClient() as client,
          NodeProcess(folder, settings) as node):
        client.wait_active(PATIENCE_S)
        client.wait_matched(PATIENCE_S)
        client.send_and_wait(frames[0], PATIENCE_S)
        before, memory = node.cpu_s(), []
        began = time.monotonic()
        for number, frame in enumerate(_endless(frames, stop, int(rate_hz * seconds))):
            client.sleep_until(began + number / rate_hz)
            client.send(frame)
            if number % int(10 * rate_hz) == 0:
                memory.append(node.rss_mib())
        took = time.monotonic() - began
        cpu = node.cpu_s() - before
        client.wait_quiet(PATIENCE_S)
        memory.append(node.rss_mib())
        return {
            'seconds': took, 'cpu_cores': cpu / took, 'rss_mib': memory, 'sent': client.sent,
            'handled': client.handled, 'waits_s': client.waits(),
            'statuses': client.statuses(), 'diagnostics': client.diagnostics}


@dataclass(frozen=True, slots=True)
class Stop:
    """A stop of the turntable: frames recorded at rest, then in motion; sent at rest in all."""

    still: int
    moving: int
    dwell: int


def _endless(frames: list[bytes], stop: Stop, count: int) -> Iterator[bytes]:
    """Rest at each stop for as long as asked, by sending its frames again and again."""
    sent = 0
    while True:
        for first in range(0, len(frames), stop.still + stop.moving):
            rest = frames[first:first + stop.still]
            motion = frames[first + stop.still:first + stop.still + stop.moving]
            for frame in chain(islice(cycle(rest), stop.dwell), motion):
                if sent == count:
                    return
                sent += 1
                yield frame


def read_clouds(path: Path) -> list[bytes]:
    """Return the point clouds of a recording as they stand in it."""
    with open_storage(path) as storage:
        topics = frozenset(c.topic for c in storage.channels() if c.kind == CLOUD)
        return [
            bytes(item.data) for item in storage.messages(topics) if not isinstance(item, Cut)]


def main() -> int:
    """Run the cases asked for, and write what was measured as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--starts', type=int, default=0)
    parser.add_argument('--session', type=Path)
    parser.add_argument('--stream', type=Path)
    parser.add_argument('--rate', type=float, default=30.0)
    parser.add_argument('--seconds', type=float, default=60.0)
    parser.add_argument('--stop', type=int, nargs=3, default=(12, 3, 300))
    parser.add_argument('--settings', type=json.loads, default={})
    args = parser.parse_args()
    found: dict[str, Any] = {}
    if args.starts:
        found |= measure_start(args.starts)
    if args.session:
        found['session'] = measure_session(read_clouds(args.session), args.settings)
    if args.stream:
        found['stream'] = measure_stream(
            read_clouds(args.stream), args.rate, args.seconds, Stop(*args.stop), args.settings)
    sys.stdout.write(json.dumps(found) + '\n')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
