# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
Case `recordings`: how long the way from a message to a view takes, stage by stage.

Messages lie in memory as a recording holds them, unpacked. Each is decoded as `read_frames` does,
then the stage is timed by itself; every run is of another frame while there are any.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
import time

import numpy as np
from ros_rops.bench.recording_data import crop_of, huge, load, Memory, SMALL, stops
from ros_rops.bench.settings import add_common_arguments, config_of, report, SEED, teller
from ros_rops.bench.timing import Limit, Timing, timing_table
from ros_rops.core.config import Config, SelectionConfig
from ros_rops.core.errors import InputError, ParameterError
from ros_rops.core.frame import Frame
from ros_rops.recordings.frames import frame_view
from ros_rops.recordings.simulate import Output
from ros_rops.segmentation.segment import segment
from ros_rops.segmentation.selection import Selector

DECODE, SEGMENT = Limit(10.0, 4.0), Limit(60.0, 25.0)
STILL, HUGE = Limit(10.0, 3.0), Limit(500.0, 200.0)
FREE = Limit()
Step = Callable[[Frame], object]


def timed_decodes(memory: Memory, runs: int, then: Step) -> tuple[float, ...]:
    """
    Return the seconds that messages take to become frames and `then` what is made of these.

    The recording's first frame is left out where there are more: finding out what the recording
    holds falls to it.
    """
    seconds: list[float] = []
    while len(seconds) < runs:
        found = list(_decodes(memory, then))
        seconds += found[1:] or found
    return tuple(seconds[:runs])


def _decodes(memory: Memory, then: Step) -> Iterator[float]:
    outcomes = memory.outcomes()
    while True:
        started = time.perf_counter()
        frame = next(outcomes, None)
        if not isinstance(frame, Frame):
            return
        then(frame)
        yield time.perf_counter() - started


def timed_steps(frames: list[Frame], runs: int, step: Step) -> tuple[float, ...]:
    """Return the seconds of a step on frames that are decoded already, one after the other."""
    seconds = []
    for number in range(runs + 1):
        started = time.perf_counter()
        step(frames[number % len(frames)])
        seconds.append(time.perf_counter() - started)
    return tuple(seconds[1:])  # the first fills caches


def frame_timings(
    memory: Memory, what: str, config: Config, runs: int, threads: int
) -> list[Timing]:
    """Time decoding, segmentation and selection on a recording; limits are for 640x480."""
    frames = memory.frames()
    asked = frames[0].points.shape[:-1] == SMALL[::-1]
    data = f'{memory.name}, {_size(frames[0])}'
    selector = Selector(SelectionConfig(method='still'))

    def cut(frame: Frame) -> object:
        return segment(frame, config.segmentation, threads=threads)

    return [
        Timing(f'{what} to a view', data, timed_decodes(memory, runs, frame_view),
               DECODE if asked else FREE),
        Timing('frame to segmented views', data, timed_steps(frames, runs, cut),
               SEGMENT if asked else FREE),
        Timing('still and new', data, timed_steps(frames, runs, selector.decide),
               STILL if asked else FREE)]


def huge_timing(memory: Memory, runs: int, threads: int) -> Timing:
    """Time a huge cloud's way: decoded, cropped, reduced."""
    frames = memory.frames()
    config = crop_of(frames)

    def reduce(frame: Frame) -> object:
        return segment(frame, config, threads=threads)

    if segment(frames[0], config, threads=threads).segmented:
        raise InputError(f'{memory.name}: taken for a raw frame: more than cropped')
    return Timing(
        'decode, crop, reduce', f'{memory.name}, {_size(frames[0])}',
        timed_decodes(memory, runs, reduce), HUGE)


def _size(frame: Frame) -> str:
    measured = np.isfinite(frame.points).all(axis=-1).mean()
    size = 'x'.join(str(length) for length in frame.points.shape[-2::-1])
    return f'{size}, {100 * measured:.0f}% measured'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `rops bench recordings`."""
    add_common_arguments(
        parser, metavar='RECORDING', what='measured beside the simulated ones', count='*')
    parser.add_argument('--runs', type=int, default=30, help='runs of each stage (default: 30)')
    parser.add_argument('--stops', type=int, default=4, help='stops simulated (default: 4)')
    parser.add_argument('--no-huge', action='store_true', help='without the huge clouds')
    parser.add_argument('--seed', type=int, default=0, help='seed of the simulation')


def run(args: argparse.Namespace) -> int:
    """Run `rops bench recordings`; returns the exit code."""
    for name in ('runs', 'stops'):
        if getattr(args, name) < 1:
            raise ParameterError(f'--{name}: must be at least 1, got {getattr(args, name)}')
    config = config_of(args, {SEED: args.seed})
    timings = list(_timings(args, config))
    report(args, [timing.to_json() for timing in timings], timing_table(timings))
    return 0


def _timings(args: argparse.Namespace, config: Config) -> Iterator[Timing]:
    tell = teller(args)
    named = [load(Path(path)) for path in args.datasets]
    kinds: tuple[tuple[Output, str], ...] = (
        ('points', 'PointCloud2'), ('depth', 'depth image'))
    for output, what in kinds:
        tell(f'simulating {what}')
        memory = stops(args.seed, output, args.stops)
        tell(f'measuring {what}')
        yield from frame_timings(memory, what, config, args.runs, args.threads)
    for organized in () if args.no_huge else (True, False):
        tell('measuring huge clouds')
        memory = huge(args.seed, organized=organized)
        yield huge_timing(memory, max(3, args.runs // 4), args.threads)
    for memory in named:
        tell(f'measuring {memory.name}')
        yield from frame_timings(memory, 'message', config, args.runs, args.threads)
