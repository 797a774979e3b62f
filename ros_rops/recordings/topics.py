# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Which topics of a recording hold frames, and which of the others belong to a depth image."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from msg_adapters.depth_image import COLORS, DEPTHS

from ros_rops.core.errors import InputError
from ros_rops.recordings.messages import Channel, Cut, Decoder, header, Storage
from ros_rops.recordings.view_facts import FACTS_TOPIC

CLOUD = 'sensor_msgs/msg/PointCloud2'
IMAGE = 'sensor_msgs/msg/Image'
INFO = 'sensor_msgs/msg/CameraInfo'


@dataclass(frozen=True, slots=True)
class Plan:
    """
    What to read of a recording.

    Parameters
    ----------
    clouds : frozenset of str
        Topics of point clouds.
    depths : frozenset of str
        Topics of depth images.
    infos, colors : dict of str
        By depth topic, the topic of its CameraInfo and of its colour image, where there is one.
    count : int or None
        Frames in all; None if the recording does not tell.
    notes : tuple of str
        What was decided, one sentence each.
    facts : frozenset of str
        The topic of `view_facts`, if the recording has it.
    """

    clouds: frozenset[str]
    depths: frozenset[str] = frozenset()
    infos: dict[str, str] = field(default_factory=dict)
    colors: dict[str, str] = field(default_factory=dict)
    count: int | None = 0
    notes: tuple[str, ...] = ()
    facts: frozenset[str] = frozenset()

    @property
    def frames(self) -> frozenset[str]:
        """Topics whose messages are frames."""
        return self.clouds | self.depths

    @property
    def topics(self) -> frozenset[str]:
        """All topics that must be read."""
        return self.frames | self.facts | {*self.infos.values(), *self.colors.values()}


def choose(storage: Storage, named: Sequence[str], decoder: Decoder) -> Plan:
    """
    Return what to read: the topics named, else all clouds, else all depth images.

    Raises
    ------
    InputError
        If a topic named is missing or holds no frames, or the recording holds none.
    """
    channels = storage.channels()
    frames = [_named(topic, channels) for topic in dict.fromkeys(named)]
    if not named:
        frames = [c for c in channels if c.kind == CLOUD and c.count != 0]
    clouds = frozenset(c.topic for c in frames if c.kind == CLOUD)
    images: dict[str, Any] = {}
    if not clouds or len(clouds) < len({c.topic for c in frames}):
        images = _first_images(storage, channels, decoder)
    depths = [c.topic for c in frames if c.kind == IMAGE]
    if not named and not clouds:
        depths = [topic for topic, image in images.items() if _is_depth(topic, image)]
    if not (clouds or depths):
        raise InputError(_nothing(storage, channels))
    wanted = {(topic, CLOUD) for topic in clouds} | {(topic, IMAGE) for topic in depths}
    counts = [c.count for c in channels if (c.topic, c.kind) in wanted]
    colors = {topic: color for topic in depths if (color := _color_of(topic, images))}
    return Plan(
        clouds, frozenset(depths),
        {topic: info for topic in depths if (info := _info_of(topic, channels))}, colors,
        None if None in counts else sum(count or 0 for count in counts),
        () if named or not clouds else tuple(_unused(channels)),
        frozenset(
            c.topic for c in channels if c.topic == FACTS_TOPIC and c.encoding == 'cdr'))


def chosen(path: Path, storage: Storage, named: Sequence[str], decoder: Decoder) -> Plan:
    """Do as `choose`; an error names the recording, which is called `path`."""
    try:
        return choose(storage, named, decoder)
    except InputError as error:
        raise InputError(f'{path}: {error}') from None


def is_rectified(topic: str) -> bool:
    """Tell whether images are undistorted already, by their topic's name (`image_rect...`)."""
    return 'rect' in topic.rpartition('/')[2]


def holds(channels: Sequence[Channel]) -> str:
    """Return the topics and their types in words."""
    listed = sorted({f'{c.topic} ({c.kind or "no type"})' for c in channels if c.count != 0})
    return f'it holds {", ".join(listed)}' if listed else 'it holds no message'


def _named(topic: str, channels: Sequence[Channel]) -> Channel:
    found = [c for c in channels if c.topic in (topic, f'/{topic}')]
    if not found:
        raise InputError(f'topics: there is no {topic!r} in the recording; {holds(channels)}')
    for channel in found:
        if channel.kind in (CLOUD, IMAGE):
            return channel
    raise InputError(f'topics: {topic!r} is of type {found[0].kind!r}, neither {CLOUD} nor a '
                     f'depth {IMAGE}; {holds(channels)}')


def _first_images(
    storage: Storage, channels: Sequence[Channel], decoder: Decoder
) -> dict[str, Any]:
    """Return the first image of each image topic that can be decoded."""
    missing = {c.topic for c in channels if c.kind == IMAGE and c.count != 0}
    order = [c.topic for c in channels if c.topic in missing]
    found: dict[str, Any] = {}
    for raw in storage.messages(frozenset(missing)) if missing else ():
        if isinstance(raw, Cut) or raw.channel.topic not in missing:
            continue
        missing.discard(raw.channel.topic)
        try:
            found[raw.channel.topic] = decoder.decode(raw)
        except InputError:
            pass
        if not missing:
            break
    return {topic: found[topic] for topic in dict.fromkeys(order) if topic in found}


def _is_depth(topic: str, image: Any) -> bool:
    # Infrared cameras send mono16 too.
    return image.encoding in DEPTHS and (image.encoding != 'mono16' or 'depth' in topic.lower())


def _info_of(topic: str, channels: Sequence[Channel]) -> str | None:
    """Return the CameraInfo topic beside an image topic, or the only one there is."""
    infos = list(dict.fromkeys(c.topic for c in channels if c.kind == INFO and c.count != 0))
    beside = topic.rpartition('/')[0] + '/camera_info'
    if beside in infos:
        return beside
    return infos[0] if len(infos) == 1 else None


def _color_of(topic: str, images: dict[str, Any]) -> str | None:
    """Return a colour image topic of the same camera frame and size; colour before grey."""
    depth = images.get(topic)
    if depth is None:
        return None
    found = [
        (len(set(COLORS[image.encoding])) == 1, k, other)
        for k, (other, image) in enumerate(images.items())
        if image.encoding in COLORS and _same_camera(depth, image)]
    return min(found)[2] if found else None


def _same_camera(depth: Any, image: Any) -> bool:
    try:
        same_frame = header(depth)[1] == header(image)[1]
        return same_frame and (depth.height, depth.width) == (image.height, image.width)
    except (AttributeError, InputError):
        return False


def _unused(channels: Sequence[Channel]) -> list[str]:
    topics = sorted({
        c.topic for c in channels
        if c.kind == IMAGE and c.count != 0 and 'depth' in c.topic.lower()})
    return [f'depth images on {topic} not read, since the recording holds point clouds (name the '
            'topic to read them)' for topic in topics]


def _nothing(storage: Storage, channels: Sequence[Channel]) -> str:
    cut = next((item for item in storage.messages(frozenset({''})) if isinstance(item, Cut)), None)
    broken = f'; truncated or damaged ({cut.reason})' if cut else ''
    return f'holds no {CLOUD} and no depth image; {holds(channels)}{broken}'
