# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings held in memory, so that no disk takes part in what is measured."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from ros_rops.core.config import SegmentationConfig
from ros_rops.core.errors import InputError
from ros_rops.core.frame import Frame
from ros_rops.recordings.depth_noise import PRESETS
from ros_rops.recordings.frames import frames_of
from ros_rops.recordings.mcap_files import create_mcap
from ros_rops.recordings.messages import Channel, Cut, RawMessage
from ros_rops.recordings.reader import BadView
from ros_rops.recordings.simulate import Output, pinhole, Sensor, simulate
from ros_rops.recordings.simulate_models import read_models
from ros_rops.recordings.station import Plan
from ros_rops.recordings.storage import open_storage

MODELS = ('procedural:bracket', 'procedural:blob')
SMALL, LARGE = (640, 480), (1424, 1424)
"""Images simulated, in pixels; the large one has two million."""
SMALL_TABLE = 0.37
"""Metres; it ends within the image, so that the frame is not taken for a raw one."""
FEWEST_PIXELS = 100
MOST_MESSAGES = 200
"""Of a recording named, so many are held in memory at most."""
REDUCED_TO = 200_000
"""Points that the huge clouds are reduced to."""


@dataclass(frozen=True, slots=True)
class Memory:
    """A recording of which everything was read; a `Storage`."""

    name: str
    listed: tuple[Channel, ...]
    held: tuple[RawMessage, ...]

    def channels(self) -> list[Channel]:
        """Return the channels."""
        return list(self.listed)

    def messages(self, topics: frozenset[str]) -> Iterator[RawMessage | Cut]:
        """Yield the messages of `topics`."""
        return (message for message in self.held if message.channel.topic in topics)

    def outcomes(self) -> Iterator[Frame | BadView]:
        """Yield the frames, decoded anew with each call."""
        return frames_of(self, Path(self.name))

    def frames(self) -> list[Frame]:
        """
        Return the frames.

        Raises
        ------
        InputError
            If one cannot be read, or there is none.
        """
        found = []
        for outcome in self.outcomes():
            if isinstance(outcome, BadView):
                raise InputError(outcome.reason)
            found.append(outcome)
        if not found:
            raise InputError(f'{self.name}: holds no frame')
        return found


def load(path: Path, name: str = '') -> Memory:
    """
    Read a recording into memory: its first messages, without what is cut off.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    with open_storage(path) as storage:
        channels = tuple(storage.channels())
        held: list[RawMessage] = []
        for item in storage.messages(frozenset(channel.topic for channel in channels)):
            if isinstance(item, Cut) or len(held) == MOST_MESSAGES:
                break
            held.append(replace(item, data=bytes(item.data)))
    return Memory(name or path.name, channels, tuple(held))


def simulated(
    output: Output, image: tuple[int, int], plan: Plan, seed: int, *, table: float = 0.0
) -> Memory:
    """Simulate two objects on a table, seen by a depth camera with its errors."""
    sensor = Sensor(pinhole(*image, 56.0), output, PRESETS['d435'], table)
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'simulated.mcap'
        models = read_models(MODELS, size=0.2, color=output == 'points')
        simulate(models, path, plan, sensor, seed=seed)
        return load(path, f'simulated, seed {seed}')


def stops(seed: int, output: Output, count: int) -> Memory:
    """Simulate stops of a turntable, with frames of rest at each and of motion between."""
    plan = Plan(views=count, together=True, mixed=False, still=4, moving=1, rate_hz=10.0)
    return simulated(output, SMALL, plan, seed)


def huge(seed: int, *, organized: bool) -> Memory:
    """
    Make a recording of one cloud of two million points, coloured.

    Unorganized, every point is measured: those of the simulated image several times, apart by
    its noise.
    """
    plan = Plan(views=1, together=True, elevation_deg=(80.0,))
    whole = simulated('points', LARGE, plan, seed, table=SMALL_TABLE)
    if organized:
        return whole
    frame, = whole.frames()
    measured = np.isfinite(frame.points).all(axis=-1)
    wanted = LARGE[0] * LARGE[1]
    points = np.resize(frame.points[measured], (wanted, 3)).astype(np.float32)
    rng = np.random.default_rng([seed, 3])
    points += rng.normal(0.0, 2e-4, points.shape).astype(np.float32)
    colors = None if frame.colors is None else np.resize(frame.colors[measured], (wanted, 3))
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'huge.mcap'
        with create_mcap(path) as mcap:
            mcap.add_cloud(
                points, topic='/points', stamp_ns=0, frame_id='camera_optical_frame',
                colors=colors)
        return load(path, whole.name)


def crop_of(frames: Sequence[Frame]) -> SegmentationConfig:
    """Return a crop box and a depth limit that keep most of a cloud, and its reduction."""
    points = frames[0].points.reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)].astype(np.float64)
    if len(points) < FEWEST_PIXELS:
        raise InputError(f'{frames[0].name}: {len(points)} points cannot be cropped')
    (left, top), (right, bottom) = np.quantile(points[:, :2], [0.03, 0.97], axis=0).tolist()
    return SegmentationConfig(
        far_m=float(np.quantile(points[:, 2], 0.97)), box_low_x_m=left, box_high_x_m=right,
        box_low_y_m=top, box_high_y_m=bottom, most_points=REDUCED_TO)
