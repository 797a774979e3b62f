# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Bytes of a file, every way that a file can fail told in a sentence."""

import gzip
from pathlib import Path
import re
import zlib

from ros_rops.core.errors import InputError

TEXT_SUFFIXES = frozenset({'.xyz', '.txt', '.csv', '.asc'})
VIEW_SUFFIXES = TEXT_SUFFIXES | {'.ply', '.pcd', '.npz'}
RECORDING_SUFFIXES = frozenset({'.mcap', '.bag', '.db3', '.mcap.zstd', '.db3.zstd'})


def kind_of(path: Path) -> str | None:
    """Return the suffix that tells the kind of a view file (`.gz` peeled off), or None."""
    suffixes = [suffix.lower() for suffix in path.suffixes]
    if suffixes and suffixes[-1] == '.gz':
        suffixes = suffixes[:-1]
    kind = suffixes[-1] if suffixes else ''
    return kind if kind in VIEW_SUFFIXES else None


def is_recording(path: Path) -> bool:
    """Tell by its name whether a file is a recording."""
    return path.name.lower().endswith(tuple(RECORDING_SUFFIXES))


def read_bytes(path: Path) -> bytes:
    """
    Return the content of a file, unpacked if its name ends in `.gz`.

    Raises
    ------
    InputError
        If the file is missing, a folder, unreadable, empty or a broken gzip stream.
    """
    try:
        data = path.read_bytes()
    except IsADirectoryError:
        raise InputError(f'{path}: is a folder, not a file') from None
    except FileNotFoundError:
        raise InputError(f'{path}: no such file') from None
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror or error})') from None
    if path.suffix.lower() == '.gz' and data:
        try:
            data = gzip.decompress(data)
        except EOFError:
            raise InputError(f'{path}: the gzip stream is truncated') from None
        except (OSError, zlib.error) as error:
            raise InputError(f'{path}: is not a sound gzip file ({error})') from None
    if not data:
        raise InputError(f'{path}: is empty')
    return data


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Return a sort key that puts `view2` before `view10`."""
    parts = re.split(r'([0-9]+)', name)
    return tuple(
        (1, int(p), p) if p.isascii() and p.isdigit() else (0, 0, p.lower())
        for p in parts if p)
