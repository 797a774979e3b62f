# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""The transform tree of a recording or of a live station: `/tf` and `/tf_static`."""

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Iterable
from pathlib import Path

from msg_adapters import transforms
from msg_adapters.transforms import StampedTransform
import numpy as np
from ros_rops.core.errors import InputError
from ros_rops.core.types import Floats
from ros_rops.recordings.messages import Cut, Decoder
from ros_rops.recordings.storage import open_storage
from scipy.spatial.transform import Rotation, Slerp

TYPES = frozenset({'tf2_msgs/msg/TFMessage', 'tf/msg/tfMessage'})
BEYOND_NS = 100_000_000
"""So far before the first and behind the last of its stamps a moving transform still holds."""


class _Edge:
    """All that is known of one child in one parent."""

    def __init__(self) -> None:
        self.static: Floats | None = None
        self._stamps: list[int] = []
        self._poses: list[Floats] = []

    def add(self, stamp_ns: int, T: Floats) -> None:
        """Take a pose; the later one counts where two have one stamp."""
        at = bisect_right(self._stamps, stamp_ns)
        if at and self._stamps[at - 1] == stamp_ns:
            self._poses[at - 1] = T
            return
        self._stamps.insert(at, stamp_ns)
        self._poses.insert(at, T)

    def remember(self, stamp_ns: int, span_ns: int) -> None:
        """
        Forget what lies more than `span_ns` before the newest pose, which came with `stamp_ns`.

        If it is that one that lies so far back, the clock was set back: it alone counts.
        """
        newest = self._stamps[-1]
        if stamp_ns < newest - span_ns:
            at = bisect_left(self._stamps, stamp_ns)
            self._stamps, self._poses = [stamp_ns], [self._poses[at]]
        elif self._stamps[0] < newest - span_ns:
            old = bisect_left(self._stamps, newest - span_ns)
            del self._stamps[:old], self._poses[:old]

    @property
    def kept(self) -> int:
        """Return the number of poses kept."""
        return len(self._stamps) + (self.static is not None)

    def at(self, stamp_ns: int | None, beyond_ns: int) -> Floats | None:
        """Return the pose at a time, between two stamps interpolated; None where unknown."""
        if not self._stamps:
            return self.static
        if stamp_ns is None:
            return self._poses[-1]
        behind = bisect_right(self._stamps, stamp_ns)
        for end in (0, -1):
            outside = behind == (0 if end == 0 else len(self._stamps))
            if outside:
                close = abs(self._stamps[end] - stamp_ns) <= beyond_ns
                return self._poses[end] if close else self.static
        before, after = self._stamps[behind - 1:behind + 1]
        share = (stamp_ns - before) / (after - before)
        return _between(self._poses[behind - 1], self._poses[behind], share)


def _between(first: Floats, second: Floats, share: float) -> Floats:
    if share == 0.0:
        return first
    turns = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([first[:3, :3], second[:3, :3]])))
    T = np.eye(4)
    T[:3, :3] = turns(share).as_matrix()
    T[:3, 3] = (1 - share) * first[:3, 3] + share * second[:3, 3]
    return T


class TransformTree:
    """
    Transforms between frames, static and moving.

    Parameters
    ----------
    static, moving : iterable of StampedTransform
    span_ns : int or None
        Of a stream without end: of each moving frame what lies farther behind its newest
        transform is forgotten. None keeps all.
    """

    def __init__(
        self, static: Iterable[StampedTransform] = (), moving: Iterable[StampedTransform] = (), *,
        span_ns: int | None = None,
    ) -> None:
        self._span_ns = span_ns
        self._edges: dict[tuple[str, str], _Edge] = {}
        self._neighbours: dict[str, list[str]] = {}
        for item in static:
            self.add(item, static=True)
        for item in moving:
            self.add(item)

    def add(self, item: StampedTransform, *, static: bool = False) -> None:
        """Take a transform; one of a frame to itself says nothing."""
        if item.parent == item.child:
            return
        edge = self._edges.setdefault((item.parent, item.child), _Edge())
        for one, other in ((item.parent, item.child), (item.child, item.parent)):
            near = self._neighbours.setdefault(one, [])
            if other not in near:
                near.append(other)
        if static:
            edge.static = item.T_parent_child
            return
        edge.add(item.stamp_ns, item.T_parent_child)
        if self._span_ns is not None:
            edge.remember(item.stamp_ns, self._span_ns)

    @property
    def kept(self) -> int:
        """Return the number of transforms kept."""
        return sum(edge.kept for edge in self._edges.values())

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames, in the order of their first mention."""
        return tuple(self._neighbours)

    def lookup(
        self, target_frame: str, source_frame: str, stamp_ns: int | None = None, *,
        beyond_ns: int = BEYOND_NS,
    ) -> Floats | None:
        """
        Return T_target_source (4, 4), or None where the transforms known do not lead there.

        Parameters
        ----------
        target_frame, source_frame : str
            With or without a leading slash.
        stamp_ns : int or None
            Moving transforms are interpolated between the stamps around it; None takes the latest
            of each.
        beyond_ns : int
            For so long they are held beyond their ends.
        """
        target, source = target_frame.removeprefix('/'), source_frame.removeprefix('/')
        reached = {target: np.eye(4)}
        queue = deque([target])
        while queue and source not in reached:
            here = queue.popleft()
            for there in self._neighbours.get(here, ()):
                T = None if there in reached else self._step(
                    here, there, stamp_ns, beyond_ns)
                if T is not None:
                    reached[there] = reached[here] @ T
                    queue.append(there)
        return reached.get(source)

    def _step(
        self, here: str, there: str, stamp_ns: int | None, beyond_ns: int
    ) -> Floats | None:
        """Return T_here_there from the edge of either direction."""
        down, up = self._edges.get((here, there)), self._edges.get((there, here))
        T: Floats | None = None if down is None else down.at(stamp_ns, beyond_ns)
        if T is None and up is not None:
            back = up.at(stamp_ns, beyond_ns)
            T = None if back is None else np.asarray(np.linalg.inv(back), np.float64)
        return T


def read_transforms(path: Path) -> TransformTree:
    """
    Return the transforms of a recording, from its topics `.../tf` and `.../tf_static`.

    What cannot be decoded, or lies behind the place where a recording breaks off, is missing.

    Parameters
    ----------
    path : Path
        A .mcap, .bag or .db3 file or a rosbag2 folder.

    Raises
    ------
    InputError
        If it cannot be read or is no recording.
    """
    tree, decoder = TransformTree(), Decoder()
    with open_storage(path) as storage:
        topics = frozenset(
            channel.topic for channel in storage.channels() if channel.kind in TYPES
            and channel.topic.rpartition('/')[2] in ('tf', 'tf_static'))
        for raw in storage.messages(topics) if topics else ():
            if isinstance(raw, Cut) or raw.channel.kind not in TYPES:
                continue
            try:
                found = transforms.decode(decoder.decode(raw))
            except InputError:
                continue
            for item in found:
                tree.add(item, static=raw.channel.topic.endswith('tf_static'))
    return tree
