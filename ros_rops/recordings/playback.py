# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A recording as messages to be sent again, under the names that the station's topics have."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from ros_rops.core.errors import InputError
from ros_rops.recordings import cdr
from ros_rops.recordings.convert_recording import Coder
from ros_rops.recordings.live_frames import (
    COLOR_TOPIC, DEPTH_TOPIC, INFO_TOPIC, VIEWS_TOPIC)
from ros_rops.recordings.messages import Channel, Cut, Decoder, RawMessage, Storage
from ros_rops.recordings.pairing import Entry, first_infos, Pairing
from ros_rops.recordings.rectified import rectified_info
from ros_rops.recordings.storage import open_storage
from ros_rops.recordings.topics import chosen, is_rectified, Plan
from ros_rops.recordings.transforms import TYPES
from ros_rops.recordings.view_facts import encode_facts, FACTS_TOPIC, ViewFacts

TF_TOPIC, TF_STATIC_TOPIC = '/tf', '/tf_static'


@dataclass(frozen=True, slots=True)
class Piece:
    """
    A message to be sent.

    Parameters
    ----------
    topic : str
        The station's.
    log_time_ns : int
    data : bytes
        CDR.
    fault : str
        Why it cannot be sent.
    """

    topic: str
    log_time_ns: int
    data: bytes = b''
    fault: str = ''


@dataclass(frozen=True, slots=True)
class Shot:
    """
    A frame and what must be there before it.

    Parameters
    ----------
    frame : Piece
    stamp_ns : int
        Of its header, as is `frame_id`.
    frame_id : str
    facts : Piece or None
    beside : tuple of Piece
        CameraInfo and colour image of a depth image.
    """

    frame: Piece
    stamp_ns: int = 0
    frame_id: str = ''
    facts: Piece | None = None
    beside: tuple[Piece, ...] = ()


@contextmanager
def open_playback(
    path: Path, topics: Sequence[str] = (), *, start_offset_s: float = 0.0
) -> Iterator['Playback']:
    """
    Open a recording to play it.

    Parameters
    ----------
    path : Path
        A .mcap, .bag or .db3 file or a rosbag2 folder.
    topics : sequence of str
        As for `read_frames`.
    start_offset_s : float
        Leave out what was recorded before the first frame and so long after it.

    Raises
    ------
    InputError
        If it cannot be read, is no recording, lacks a topic named, holds no frame from the offset
        on, or frames of several depth cameras or of both kinds, for which a station has no
        topics.
    """
    # Transforms are read ahead of the frames, which one reader cannot do.
    with open_storage(path) as storage, open_storage(path) as ahead:
        yield Playback(path, storage, ahead, topics, start_offset_s)


class Playback:
    """
    An open recording; see `open_playback`.

    Attributes
    ----------
    kind : {'cloud', 'depth'}
    color : bool
        Whether there are colour images beside the depth images.
    facts : bool
        Whether it holds `view_facts`.
    rectified : bool
        Whether the depth topic's name says that its images are undistorted already. Since the
        station's name does not, CameraInfo is sent without distortion then.
    count : int or None
        Frames in all, the start offset not counted in; None if the recording does not tell.
    notes : tuple of str
    start_ns : int
        Log time from which on it is played.
    """

    def __init__(
        self, path: Path, storage: Storage, ahead: Storage, topics: Sequence[str],
        start_offset_s: float,
    ) -> None:
        self._path, self._storage, self._ahead = path, storage, ahead
        self._decoder = Decoder()
        self._plan = chosen(path, storage, topics, self._decoder)
        self._topics = _station_topics(path, self._plan)
        self._coders: dict[Channel, Coder] = {}
        self._infos = first_infos(storage, self._plan, self._decoder)
        self.kind = 'depth' if self._plan.depths else 'cloud'
        self.color = bool(self._plan.colors)
        self.facts = bool(self._plan.facts)
        self.rectified = any(map(is_rectified, self._plan.depths))
        self.count = self._plan.count
        self.notes = self._plan.notes
        self.start_ns = self._first_ns() + round(start_offset_s * 1e9)
        if start_offset_s and not self._has_frames():
            raise InputError(
                f'{path}: start_offset_s: no frame {start_offset_s:g} s after the first one')

    def shots(self) -> Iterator[Shot]:
        """Yield the frames in the order of `read_frames`, and where the recording breaks off."""
        pairing = Pairing(self._plan, self._decoder, self._infos)
        end = ''
        for item in self._storage.messages(self._plan.topics):
            if isinstance(item, Cut):
                end = self._broken(item)
                continue
            yield from self._shots_of(pairing.add(item))
        yield from self._shots_of(pairing.rest())
        if end:
            yield Shot(Piece('', self.start_ns, fault=end))

    def pieces(self) -> Iterator[Piece]:
        """Yield all messages in the order of log time, before them the first CameraInfo."""
        for noted in self._infos.values():
            yield replace(self._piece(noted.raw), log_time_ns=self.start_ns)
        last_ns = self.start_ns
        for item in self._storage.messages(self._plan.topics):
            if isinstance(item, Cut):
                yield Piece('', last_ns, fault=self._broken(item))
            elif item.log_time_ns >= self.start_ns and item.channel.topic in self._topics:
                last_ns = item.log_time_ns
                yield self._piece(item)

    def static_transforms(self) -> Iterator[Piece]:
        """Yield all that was recorded on `/tf_static`, whenever it was."""
        return self._transforms(TF_STATIC_TOPIC)

    def moving_transforms(self) -> Iterator[Piece]:
        """Yield what was recorded on `/tf`, in the order of log time, from the start on."""
        return (
            piece for piece in self._transforms(TF_TOPIC) if piece.log_time_ns >= self.start_ns)

    @property
    def has_transforms(self) -> bool:
        """Whether it holds transforms."""
        return any(_is_tf(c, TF_TOPIC) or _is_tf(c, TF_STATIC_TOPIC)
                   for c in self._storage.channels())

    def _transforms(self, ending: str) -> Iterator[Piece]:
        topics = frozenset(
            channel.topic for channel in self._ahead.channels() if _is_tf(channel, ending))
        for item in self._ahead.messages(topics) if topics else ():
            if not isinstance(item, Cut) and _is_tf(item.channel, ending):
                yield self._piece(item, ending)

    def _shots_of(self, entries: Iterator[Entry]) -> Iterator[Shot]:
        for entry in entries:
            if entry.raw.log_time_ns >= self.start_ns:
                yield self._shot(entry)

    def _shot(self, entry: Entry) -> Shot:
        if entry.fault:
            # Other listeners may trip over it, and the station could only say the same.
            topic = self._topics[entry.raw.channel.topic]
            return Shot(Piece(topic, entry.raw.log_time_ns, fault=entry.fault))
        beside = [self._piece(noted.raw) for noted in (entry.info, entry.color) if noted]
        return Shot(
            self._piece(entry.raw), entry.stamp_ns, entry.frame_id,
            entry.facts and _piece_of(entry.facts, entry.raw.log_time_ns),
            tuple(piece for piece in beside if not piece.fault))

    def _piece(self, raw: RawMessage, topic: str = '') -> Piece:
        topic = topic or self._topics[raw.channel.topic]
        try:
            if raw.fault:
                raise InputError(raw.fault)
            if raw.channel not in self._coders:
                self._coders[raw.channel] = Coder(raw.channel)
            data = self._coders[raw.channel].encode(raw.data)
            if self.rectified and topic == INFO_TOPIC:
                data = rectified_info(data)
            return Piece(topic, raw.log_time_ns, data)
        except InputError as error:
            return Piece(topic, raw.log_time_ns, fault=str(error))

    def _first_ns(self) -> int:
        for item in self._storage.messages(self._plan.frames):
            if not isinstance(item, Cut):
                return item.log_time_ns
        raise InputError(f'{self._path}: holds no frame that can be read')

    def _has_frames(self) -> bool:
        return any(
            not isinstance(item, Cut) and item.log_time_ns >= self.start_ns
            for item in self._storage.messages(self._plan.frames))

    def _broken(self, cut: Cut) -> str:
        return f'{self._path}: the recording is truncated or damaged here ({cut.reason})'


def _station_topics(path: Path, plan: Plan) -> dict[str, str]:
    """Return the station's topic by that of the recording."""
    if len(plan.depths) > (0 if plan.clouds else 1):
        listed = ', '.join(sorted(plan.frames))
        raise InputError(
            f'{path}: topics: a station takes point clouds, or one depth camera; name one of '
            f'{listed}')
    return {
        **dict.fromkeys(plan.clouds, VIEWS_TOPIC), **dict.fromkeys(plan.depths, DEPTH_TOPIC),
        **dict.fromkeys(plan.infos.values(), INFO_TOPIC),
        **dict.fromkeys(plan.colors.values(), COLOR_TOPIC),
        **(dict.fromkeys(plan.facts, FACTS_TOPIC) if plan.clouds else {})}


def _piece_of(facts: ViewFacts, log_time_ns: int) -> Piece:
    return Piece(
        FACTS_TOPIC, log_time_ns, cdr.string_message(encode_facts(facts).decode()))


def _is_tf(channel: Channel, ending: str) -> bool:
    return channel.kind in TYPES and f'/{channel.topic}'.endswith(ending)
