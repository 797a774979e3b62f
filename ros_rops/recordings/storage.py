# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""One door to all kinds of recordings, told apart by the suffix of their names."""

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
from pathlib import Path
import tempfile

from ros_rops.core.errors import InputError
from ros_rops.recordings.files import RECORDING_SUFFIXES
from ros_rops.recordings.mcap_reader import McapFile
from ros_rops.recordings.messages import Storage
from ros_rops.recordings.rosbag_folder import Joined, storage_files
from ros_rops.recordings.unpacking import unpack_file


@contextmanager
def open_storage(path: Path) -> Iterator[Storage]:
    """
    Open a recording: a .mcap, .bag or .db3 file (the last two `.zstd` too) or a rosbag2 folder.

    Raises
    ------
    InputError
        If it cannot be read or is no recording.
    """
    with ExitStack() as stack:
        try:
            storage = (_open_folder if path.is_dir() else _open_file)(path, stack)
        except OSError as error:
            raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
        yield storage


def _open_folder(folder: Path, stack: ExitStack) -> Storage:
    files, packed = storage_files(folder)
    storages: list[tuple[Path, Storage | InputError]] = []
    for file in files:
        try:
            storages.append((file, _open_file(file, stack, unpack=not packed)))
        except OSError as error:
            storages.append((file, InputError(f'cannot be read ({error.strerror or error})')))
        except InputError as error:
            storages.append((file, error))
    if not any(not isinstance(storage, InputError) for _, storage in storages):
        raise InputError(f'{folder}: none of its files can be read ({storages[0][1]})')
    return Joined(storages, packed)


def _open_file(path: Path, stack: ExitStack, *, unpack: bool = True) -> Storage:
    name = path.name.lower()
    if name.endswith('.zstd'):
        return _open_file(_unpacked(path, stack), stack, unpack=unpack)
    if name.endswith('.mcap'):
        return McapFile(path, stack.enter_context(path.open('rb')))
    if name.endswith('.db3'):
        from ros_rops.recordings.rosbag_sqlite import SqliteFile

        sqlite = SqliteFile(path, unpack=unpack)
        stack.callback(sqlite.close)
        return sqlite
    if name.endswith('.bag'):
        from ros_rops.recordings.rosbag_ros1 import Ros1Bag

        bag = Ros1Bag(path)
        stack.callback(bag.close)
        return bag
    known = ', '.join(sorted(RECORDING_SUFFIXES))
    raise InputError(f'{path}: no recording, its suffix is none of {known}')


def _unpacked(path: Path, stack: ExitStack) -> Path:
    """Return the file that a compressed one holds, on disk: readers must be able to seek."""
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix='rops_')))
    with path.open('rb') as packed, (folder / path.stem).open('wb') as out:
        unpack_file(packed, out)
    return folder / path.stem
