# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a recording of any kind, one after the other, in the order of log time."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ros_rops.core.frame import Frame
from ros_rops.recordings.cloud import measured_cloud
from ros_rops.recordings.frame_maker import check_stated, FrameMaker
from ros_rops.recordings.messages import Cut, Decoder, Storage
from ros_rops.recordings.pairing import Entry, first_infos, Pairing
from ros_rops.recordings.reader import BadView, finish_clean, NotedView
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.topics import chosen


def read_frames(
    path: Path, *, topics: Sequence[str] = (), units: str = 'auto', sensor: str = 'auto'
) -> Iterator[Frame | BadView]:
    """
    Yield the frames of a recording, named '<topic>@<log time in ns>', as they are read.

    A message that cannot be read is yielded as a `BadView` and the rest follows; so is the place
    where a recording breaks off, after all that could be read of it.

    Parameters
    ----------
    path : Path
        A .mcap, .bag or .db3 file or a rosbag2 folder.
    topics : sequence of str
        Of point clouds and depth images; none: all point clouds, or where there is none all
        depth images.
    units : {'auto', 'm', 'mm'}
        Of the numbers in point clouds and 32FC1 images, and of the frames; 'auto' follows REP 103
        and 118: metres. 16UC1 always counts millimetres.
    sensor : str
        As for `read_view`; 'auto' leaves it to be inferred from the points, but for depth images
        and for unorganized points in an `*optical_frame`, which are seen from the frame's origin.

    Raises
    ------
    InputError
        If it cannot be read, is no recording, lacks a topic named or holds no frame.
    ParameterError
        If `units` or `sensor` is none of the choices.
    """
    check_stated(units, sensor)
    with open_storage(path) as storage:
        yield from frames_of(storage, path, topics=topics, units=units, sensor=sensor)


def frames_of(
    storage: Storage, path: Path, *, topics: Sequence[str] = (), units: str = 'auto',
    sensor: str = 'auto',
) -> Iterator[Frame | BadView]:
    """Yield the frames of an open recording, called `path`; all else as `read_frames`."""
    check_stated(units, sensor)
    decoder = Decoder()
    plan = chosen(path, storage, topics, decoder)
    maker = FrameMaker(plan, units, sensor)
    names = _Names()
    pairing = Pairing(plan, decoder, first_infos(storage, plan, decoder))
    cuts = []
    for item in storage.messages(plan.topics):
        if isinstance(item, Cut):
            cuts.append(item)
            continue
        yield from (maker.outcome(entry, names.of(entry)) for entry in pairing.add(item))
    yield from (maker.outcome(entry, names.of(entry)) for entry in pairing.rest())
    yield from (_broken(path, cut, names.given) for cut in cuts)


def count_frames(path: Path, topics: Sequence[str] = ()) -> int:
    """
    Return how many frames `read_frames` would find, those that cannot be decoded included.

    Raises
    ------
    InputError
        As `read_frames`.
    """
    with open_storage(path) as storage:
        plan = chosen(path, storage, topics, Decoder())
        if plan.count is not None:
            return plan.count
        return sum(not isinstance(item, Cut) for item in storage.messages(plan.frames))


def frame_view(frame: Frame) -> NotedView:
    """Return all measured points of a frame as a view, nothing segmented."""
    if frame.view is not None:
        return NotedView(frame.view, tuple(f'{frame.name}: {note}' for note in frame.notes))
    noted = finish_clean(
        frame.name, measured_cloud(frame.points, frame.colors, frame.notes),
        units='auto' if frame.units == 'unknown' else frame.units, sensor=frame.sensor or 'auto',
        stamp_ns=frame.stamp_ns, frame_id=frame.frame_id)
    return NotedView(noted.view, tuple(f'{frame.name}: {note}' for note in noted.notes))


class _Names:
    """Names of frames, each given once."""

    def __init__(self) -> None:
        self.given = 0
        self._used: dict[str, int] = {}

    def of(self, entry: Entry) -> str:
        """Return a frame's name."""
        facts, raw = entry.facts, entry.raw
        name = facts.name if facts else f'{raw.channel.topic}@{raw.log_time_ns}'
        self.given += 1
        self._used[name] = self._used.get(name, 0) + 1
        return name if self._used[name] == 1 else f'{name}#{self._used[name]}'


def _broken(path: Path, cut: Cut, done: int) -> BadView:
    """Return the place where a recording breaks off."""
    return BadView(path.name, f'{path}: the recording is truncated or damaged after '
                   f'{done} {"view" if done == 1 else "views"} ({cut.reason})')
