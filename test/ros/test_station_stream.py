# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
A minute of a depth camera's stream, 30 clouds of 640x480 a second, before a scene at rest.

Truth: what was sent. Every cloud has its word, or is counted among those that DDS lost; the scene
is one view; the node's memory is what it was.
"""

from collections.abc import Iterator
from itertools import cycle, islice
from pathlib import Path
import re
from statistics import median
import struct
import time

import pytest

rclpy = pytest.importorskip('rclpy', reason='no rclpy on this platform')
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100
from rclpy.qos import QoSProfile  # noqa: E402
from ros.harness import Client, station, wait_for  # noqa: E402
from ros_rops.recordings.depth_noise import PRESETS  # noqa: E402
from ros_rops.recordings.messages import RawMessage  # noqa: E402
from ros_rops.recordings.simulate import pinhole, Sensor, simulate  # noqa: E402
from ros_rops.recordings.simulate_models import read_models  # noqa: E402
from ros_rops.recordings.station import Plan  # noqa: E402
from ros_rops.recordings.storage import open_storage  # noqa: E402
from ros_rops.recordings.topics import CLOUD  # noqa: E402
from sensor_msgs.msg import PointCloud2  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

RATE_HZ, SECONDS = 30, 60
DIFFERENT = 6
"""So many frames, each with noise of its own, are sent again and again."""
WORDS = QoSProfile(depth=RATE_HZ * SECONDS)
MOST_MIB = 8.0
"""Growth in half a minute: a kilobyte for each frame is 0.9, a frame kept of a hundred is 42."""


def _frames(folder: Path) -> list[bytes]:
    """Return what a depth camera sends of a part that stands still on a table."""
    path = folder / 'rest.mcap'
    sensor = Sensor(pinhole(640, 480, 56.0), 'points', PRESETS['d435'], 0.0)
    simulate(
        read_models(['procedural:bracket'], size=0.2), path,
        Plan(views=1, still=DIFFERENT, rate_hz=RATE_HZ), sensor, seed=0)
    with open_storage(path) as storage:
        topics = frozenset(c.topic for c in storage.channels() if c.kind == CLOUD)
        return [
            bytes(item.data) for item in storage.messages(topics) if isinstance(item, RawMessage)]


def _stream(frames: list[bytes]) -> Iterator[tuple[int, bytes]]:
    """Yield stamps in nanoseconds and clouds with them, as fast as the camera at most."""
    due = time.monotonic()
    for frame in islice(cycle(frames), RATE_HZ * SECONDS):
        time.sleep(max(0.0, due - time.monotonic()))
        # What a busy machine delayed is not made up for by a burst: a camera sends none.
        due = max(due, time.monotonic() - 1.0 / RATE_HZ) + 1.0 / RATE_HZ
        stamp_ns = time.time_ns()
        # The stamp is the first field, behind four bytes that tell the encapsulation.
        yield stamp_ns, frame[:4] + struct.pack('<iI', *divmod(stamp_ns, 10**9)) + frame[12:]


def _own_mib(pid: int) -> float:
    """Return the memory that is a process's own: not DDS's segments, nor libraries."""
    status = Path(f'/proc/{pid}/status').read_text(encoding='ascii')
    return int(re.search(r'RssAnon:\s+(\d+)', status)[1]) / 1024


def _numbers(health: list[DiagnosticArray]) -> dict[str, str]:
    """Return what was said last on /diagnostics, by name of the value."""
    return {item.key: item.value for status in health[-1].status for item in status.values}


def _lost(health: list[DiagnosticArray]) -> int:
    """Return how many messages the node says that DDS lost."""
    return int(_numbers(health)['lost'])


def _send(client: Client, frames: list[bytes], pid: int) -> tuple[set[int], list[float]]:
    """Send the stream; return the stamps, and the node's memory with each cloud."""
    views = client.publisher(PointCloud2, 'views')
    stamps, memory = set(), []
    for stamp_ns, cloud in _stream(frames):
        views.publish(cloud)
        stamps.add(stamp_ns)
        memory.append(_own_mib(pid))
    return stamps, memory


@pytest.mark.alone
@pytest.mark.slow
@pytest.mark.skipif(not Path('/proc/self/status').exists(), reason='no /proc on this system')
def test_a_minute_loses_nothing_and_leaves_nothing(tmp_path: Path) -> None:
    frames = _frames(tmp_path)
    assert len(frames) == DIFFERENT
    assert all(len(frame) > 640 * 480 * 12 and frame[1] == 1 for frame in frames)
    with station(tmp_path, {'selection.method': 'still'}) as (process, client):
        health = client.collect(DiagnosticArray, '/diagnostics')
        words = client.collect(Header, 'handled', WORDS)
        wait_for(lambda: health, 'how the node stands')
        sent, memory = _send(client, frames, process.pid)

        def worded() -> set[int]:
            return {word.stamp.sec * 10**9 + word.stamp.nanosec for word in list(words)}

        wait_for(lambda: len(worded()) + _lost(health) >= len(sent), 'all words')
        said = len(health)
        wait_for(lambda: len(health) > said + 1, 'how the node stands after them')
        assert worded() <= sent
        assert len(words) == len(worded()) == len(sent) - _lost(health)
        numbers = _numbers(health)
        assert numbers['frames_taken'] == '1', numbers
        assert int(numbers['frames_skipped']) == len(words) - 1, numbers
        _check_flat(memory)


def _check_flat(memory: list[float]) -> None:
    """Compare the seconds around the middle of the stream with its last ones."""
    middle, around = len(memory) // 2, 5 * RATE_HZ
    grown = median(memory[-around:]) - median(memory[middle - around:middle])
    assert grown < MOST_MIB, f'{grown:.1f} MiB more: {memory[::around]}'
