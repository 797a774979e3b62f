# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""A rosbag2 folder: metadata.yaml and one or several storage files, perhaps compressed."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ros_rops.core.errors import InputError
from ros_rops.recordings.files import natural_key
from ros_rops.recordings.messages import Channel, Cut, RawMessage, Storage, unpacked

METADATA = 'metadata.yaml'
STORAGE_SUFFIXES = ('.db3', '.mcap', '.db3.zstd', '.mcap.zstd')


def is_rosbag_folder(folder: Path) -> bool:
    """Tell whether a folder is a rosbag2 recording."""
    return (folder / METADATA).is_file()


def storage_files(folder: Path) -> tuple[list[Path], bool]:
    """
    Return a recording's files in order, and whether each message is compressed.

    Where the metadata cannot be read the files are those in the folder, in natural order.

    Raises
    ------
    InputError
        If the folder cannot be read, or holds no storage file.
    """
    names, packed = _stated(folder / METADATA)
    try:
        here = sorted(
            (path for path in folder.iterdir() if path.name.endswith(STORAGE_SUFFIXES)),
            key=lambda path: natural_key(path.name))
    except OSError as error:
        raise InputError(f'{folder}: cannot be read ({error.strerror or error})') from None
    # Older versions wrote paths from the folder above.
    stated = [folder / Path(name).name for name in names]
    if not (stated or here):
        raise InputError(f'{folder}: holds no file of a rosbag2 recording')
    return stated or here, packed


def _stated(path: Path) -> tuple[list[str], bool]:
    """Return the names of the files, none if it does not tell, and whether messages are packed."""
    import yaml

    try:
        about = yaml.safe_load(path.read_text(encoding='utf-8'))['rosbag2_bagfile_information']
        names = [str(name) for name in about['relative_file_paths']]
        mode = str(about.get('compression_mode') or '').lower()
        return names, mode == 'message'
    except (OSError, UnicodeDecodeError, yaml.YAMLError, TypeError, KeyError, AttributeError,
            ValueError, RecursionError):
        return [], False


class Joined:
    """
    Storages one after the other, as one recording.

    Parameters
    ----------
    storages : sequence of (path, Storage or InputError)
        What each file is, or why it cannot be read.
    packed : bool
        Whether each message is compressed by zstd.
    """

    def __init__(
        self, storages: Sequence[tuple[Path, Storage | InputError]], packed: bool
    ) -> None:
        self._storages, self._packed = storages, packed

    def channels(self) -> list[Channel]:
        """Return the channels, counted over all files."""
        found: dict[tuple[str, str], Channel] = {}
        for _, storage in self._storages:
            for channel in [] if isinstance(storage, InputError) else storage.channels():
                key = (channel.topic, channel.kind)
                before = found.get(key, replace(channel, count=0))
                count = None if None in (before.count, channel.count) else (
                    (before.count or 0) + (channel.count or 0))
                found[key] = replace(before, count=count)
        return list(found.values())

    def messages(self, topics: frozenset[str]) -> Iterator[RawMessage | Cut]:
        """Yield the messages of `topics`, a `Cut` where a file is missing or breaks off."""
        for path, storage in self._storages:
            if isinstance(storage, InputError):
                yield Cut(f'{path.name}: {storage}')
                continue
            for item in storage.messages(topics):
                if isinstance(item, Cut):
                    yield Cut(f'{path.name}: {item.reason}')
                elif self._packed:
                    yield unpacked(item)
                else:
                    yield item
