# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Compressed files, messages and chunks of recordings; no few bytes may claim all memory."""

import bz2
from typing import Any, IO

from ros_rops.core.errors import InputError

BLOCK = 2**20
LARGEST = 2**30
"""Bytes of one message or chunk; the largest cloud of any sensor has a tenth of that."""


def unpack_file(packed: IO[bytes], out: IO[bytes]) -> None:
    """
    Write the content of a zstd file to `out`, block by block, as far as it goes.

    Raises
    ------
    OSError
        If a file cannot be read or written.
    """
    import zstandard

    try:
        _copy(zstandard, packed, out, None)
    except zstandard.ZstdError:
        return  # the file inside breaks off here, which its own reader tells


def unpack_message(data: bytes | memoryview) -> bytes:
    """
    Return what a zstd frame holds.

    Raises
    ------
    InputError
        If it is none, breaks off or holds more than `LARGEST`.
    """
    import io

    import zstandard

    out = io.BytesIO()
    try:
        _copy(zstandard, io.BytesIO(data), out, LARGEST)
        stated = zstandard.frame_content_size(data)
    except zstandard.ZstdError as error:
        raise InputError(f'the compressed message is damaged ({error})') from None
    if stated not in (-1, out.tell()):
        raise InputError(f'the compressed message holds {out.tell()} of {stated} bytes')
    return out.getvalue()


def _copy(zstandard: Any, packed: IO[bytes], out: IO[bytes], limit: int | None) -> None:
    done = 0
    with zstandard.ZstdDecompressor().stream_reader(
            packed, read_across_frames=True, closefd=False) as stream:
        while block := stream.read(BLOCK):
            done += len(block)
            if limit is not None and done > limit:
                raise InputError(f'the compressed message holds more than {limit} bytes')
            out.write(block)


def unpack_chunk(
    compression: str, data: memoryview, size: int, *, whole: bool = True
) -> bytes | memoryview:
    """
    Return the content of a ROS 1 bag's chunk.

    Parameters
    ----------
    compression : {'none', 'bz2', 'lz4'}
    data : memoryview
    size : int
        Of the content, as the chunk states it.
    whole : bool
        False where the file breaks off within the chunk: its content then as far as it goes.

    Raises
    ------
    InputError
        If it is damaged, of another compression or of another size.
    """
    from lz4.frame import LZ4FrameDecompressor

    if size > LARGEST:
        raise InputError(f'a chunk states {size} bytes')
    unpackers = {'bz2': bz2.BZ2Decompressor, 'lz4': LZ4FrameDecompressor}
    if compression == 'none':
        content: bytes | memoryview = data
    elif compression not in unpackers:
        raise InputError(f'a chunk is compressed by {compression!r}')
    else:
        try:
            content = unpackers[compression]().decompress(data, max_length=size + 1)
        except (OSError, EOFError, ValueError, RuntimeError) as error:
            raise InputError(f'a chunk is damaged ({error})') from None
    if whole and len(content) != size:
        raise InputError(f'a chunk holds {len(content)} bytes and states {size}')
    return content
