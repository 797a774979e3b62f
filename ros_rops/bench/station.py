# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Case `station`: the registration node in its own process, fed and timed from another one.

The objects are captured by a simulated camera on a table; what is sent are whole frames, so that
segmentation is part of every time. Needs rclpy.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import importlib.util
import json
import os
from pathlib import Path
import subprocess
import sys
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from ros_rops.bench.settings import add_common_arguments, config_of, report, teller
from ros_rops.bench.table import table
from ros_rops.core.config import Config
from ros_rops.core.errors import InputError
from ros_rops.recordings.depth_noise import PRESETS
from ros_rops.recordings.simulate import pinhole, Sensor, simulate
from ros_rops.recordings.simulate_models import read_models, UPS
from ros_rops.recordings.station import Plan

IMAGE = (640, 480)
SETTLED = 10
"""Latency is that of the views behind so many."""
STILL, MOVING, DWELL_S = 12, 3, 10.0
METER = 'ros_rops.nodes.meter'
HEADS = ('what', 'got', 'must', 'aim', 'reached')


@dataclass(frozen=True, slots=True)
class Figure:
    """One number measured, in `unit`, and what it must and should not exceed."""

    what: str
    value: float
    unit: str
    must: float | None = None
    aim: float | None = None

    @property
    def reached(self) -> str | None:
        """Return 'aim', 'must' or 'neither'; None where nothing is asked."""
        if self.must is None or self.aim is None:
            return None
        if self.value <= self.aim:
            return 'aim'
        return 'must' if self.value <= self.must else 'neither'

    def row(self) -> list[object]:
        """Return the cells under `HEADS`."""
        def text(value: float | None) -> str:
            return '' if value is None else f'{value:.3g} {self.unit}'.strip()
        return [self.what, text(self.value), text(self.must), text(self.aim), self.reached or '']


def start_figures(found: dict[str, Any]) -> Iterator[Figure]:
    """Yield what is said of starting."""
    yield Figure('start to active, median', float(np.median(found['start_s'])), 's', 3.0, 1.0)


def session_figures(session: dict[str, Any]) -> Iterator[Figure]:
    """Yield what is said of a session of many views."""
    views = session['views']
    late = [view['assembled_s'] for view in views[SETTLED:2 * SETTLED] if 'assembled_s' in view]
    every = [view['assembled_s'] for view in views[SETTLED:] if 'assembled_s' in view]
    if late:
        yield Figure(
            f'arrival to assembled, views {SETTLED + 1}-{2 * SETTLED}, p95',
            _quantile(late, 0.95), 's', 1.0, 0.3)
        yield Figure(f'the same, all views after {SETTLED}, p95', _quantile(every, 0.95), 's')
        yield Figure('the same, last ten views, median', float(np.median(every[-10:])), 's')
    answers = session['service_s']
    yield Figure('service while registering, p99', 1e3 * _quantile(answers, 0.99), 'ms', 200, 50)
    yield Figure(f'{len(views)} views, most memory', session['peak_rss_mib'], 'MiB', 2048, 1024)
    yield Figure('views placed', session['statuses']['placed'], '')
    yield Figure('exponent of time per view over number of views', _exponent(views), '')


def stream_figures(stream: dict[str, Any]) -> Iterator[Figure]:
    """Yield what is said of a stream of frames."""
    waits = stream['waits_s']
    yield Figure('frames sent', stream['sent'], '')
    yield Figure('frames without a word', stream['sent'] - stream['handled'], '')
    yield Figure('word on a frame, p99', 1e3 * _quantile(waits, 0.99), 'ms')
    yield Figure('CPU', stream['cpu_cores'], 'cores', 1.0, 0.5)
    memory = stream['rss_mib']
    yield Figure('memory at the end less that after 10 s', memory[-1] - memory[1], 'MiB')
    for key, value in stream['diagnostics'].items():
        if key.endswith(('longest_wait_ms', 'callback_p99_ms', 'dropped')):
            must, aim = ((100.0, 100.0) if 'wait' in key else (5.0, 2.0)) \
                if key.endswith('ms') else (None, None)
            yield Figure(key, float(value), 'ms' if key.endswith('ms') else '', must, aim)


def _quantile(values: Sequence[float], share: float) -> float:
    return float(np.quantile(values, share))


def _exponent(views: Sequence[dict[str, float]]) -> float:
    """Return k of: time per view ~ views^k, beyond the first ten."""
    numbers = np.arange(1, len(views) + 1)[SETTLED:]
    seconds = np.array([view['handled_s'] for view in views[SETTLED:]])
    if len(seconds) < 2:
        return 0.0
    return float(np.polyfit(np.log(numbers), np.log(seconds), 1)[0])


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench station`."""
    add_common_arguments(
        parser, metavar='MESH', what='PLY, OBJ, STL or procedural:NAME, captured one by one')
    parser.add_argument('--views', type=int, default=75, help='of all objects (default: 75)')
    parser.add_argument('--size', type=float, default=0.2, help='longest side in m')
    parser.add_argument('--up', choices=list(UPS), default='z', help='axis that points up')
    parser.add_argument('--distance', type=float, default=0.0, help='of the camera in m')
    parser.add_argument('--starts', type=int, default=5, help='starts of the node (default: 5)')
    parser.add_argument('--seconds', type=float, default=60.0, help='of the stream')
    parser.add_argument('--rate', type=float, default=30.0, help='of the stream in Hz')
    parser.add_argument('--seed', type=int, default=0, help='seed of the simulation')
    parser.add_argument(
        '--profile', type=Path, metavar='XML', help='Fast DDS profile, as config/fastdds.xml')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench station`; returns the exit code."""
    if importlib.util.find_spec('rclpy') is None:
        raise InputError('rclpy is not installed; the station cannot be measured without it')
    tell = teller(args)
    with TemporaryDirectory() as folder:
        session, stream = Path(folder) / 'session.mcap', Path(folder) / 'stream.mcap'
        tell('simulating')
        _simulate(args, session, Plan(views=max(1, args.views // len(args.datasets)),
                                      distance=args.distance))
        _simulate(args, stream, Plan(
            views=3, together=True, mixed=False, still=STILL, moving=MOVING, rate_hz=args.rate,
            distance=args.distance))
        tell('measuring; a quiet machine helps')
        found = _measure(args, session, stream)
    figures = [
        *start_figures(found), *session_figures(found['session']),
        *stream_figures(found['stream'])]
    report(args, [found], table(HEADS, [figure.row() for figure in figures]))
    return 0


def _simulate(args: argparse.Namespace, path: Path, plan: Plan) -> None:
    models = read_models(args.datasets, size=args.size, up=args.up)
    sensor = Sensor(pinhole(*IMAGE, 56.0), 'points', PRESETS['d435'], 0.0)
    simulate(models, path, plan, sensor, seed=args.seed)


def _measure(args: argparse.Namespace, session: Path, stream: Path) -> dict[str, Any]:
    default = Config().to_flat()
    changed = {
        name: value for name, value in config_of(args, {}).to_flat().items()
        if value != default[name]}
    words = [
        sys.executable, '-m', METER, '--starts', str(args.starts), '--session', str(session),
        '--stream', str(stream), '--rate', str(args.rate), '--seconds', str(args.seconds),
        '--stop', str(STILL), str(MOVING), str(int(DWELL_S * args.rate)),
        '--settings', json.dumps({'threads': args.threads, **changed})]
    environment = {
        **os.environ, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_DOMAIN_ID': str(1 + os.getpid() % 101)}
    environment.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None)
    if args.profile is not None:
        environment['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(args.profile.resolve())
    done = subprocess.run(
        words, env=environment, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise InputError('the station could not be measured; the lines above say why')
    found: dict[str, Any] = json.loads(done.stdout)
    return found
